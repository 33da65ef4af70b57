"""The simulation without ROS: world, UAV, flight controller and sensors, one step at a time.

The `gazebo` node, the closed-loop tests and the campaigns all drive this one class, so a flight is the same
everywhere. It is deterministic bit for bit: time is a whole number of microseconds, every sensor has a random
stream of its own, and nothing looks at a clock.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple, Sequence

import numpy as np

from simulation_tools.autopilot import Autopilot, VehicleState
from simulation_tools.geometry import ORIGIN, Pose, Vector3, rotate_inverse
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.sdf.parser import load_world
from simulation_tools.sensors.imu import Imu, ImuSample, specific_force
from simulation_tools.sensors.lidar import Lidar
from simulation_tools.sensors.odometry import DriftingOdometry, OdometrySample
from simulation_tools.sensors.schedule import Schedule
from simulation_tools.simulation.parameters import (
    PhysicsDivergedError,
    SimulationError,
    SimulationParameters,
    step_us_from,
)
from simulation_tools.simulation.payload import (
    PayloadSensor,
    further_sensors,
    has_camera,
    payload_sensors,
    unsimulated,
)
from simulation_tools.simulation.random_streams import RandomStreams
from simulation_tools.vehicle.airframe import Airframe
from simulation_tools.vehicle.gimbal import Gimbal
from simulation_tools.vehicle.uav import MountedSensor, load_uav
from simulation_tools.world.overlaps import warning_of
from simulation_tools.world.shapes.meshes import standing_height_m
from simulation_tools.world.world import Contact, PhysicsWorld

IRIS = "iris"
"""The UAV that is flown by default."""

WATCH_PERIOD_US = 100_000
"""How often it is looked whether everything is still somewhere."""

POSE_RATE_HZ = 100.0
"""Of odometry and ground truth, as TF needs it; they come at every scan besides."""


_NO_GIMBAL = 'The lidar of "{}" cannot be levelled: its SDF has no gimbal (see models/iris).'


class StepOutput(NamedTuple):
    """What the sensors say at one instant; None where none is due.

    scan: float32 ranges (beams,) in metres by REP-117. odometry: pose in `odom` and body twist, with drift.
    ground_truth: the same in `world`, true. contacts: of the UAV, right now. payload: the further sensors
    that are due, to be read or not.
    """

    time_us: int
    scan: np.ndarray | None
    odometry: OdometrySample | None
    ground_truth: OdometrySample | None
    imu: ImuSample | None
    contacts: Sequence[Contact]
    payload: tuple[PayloadSensor, ...] = ()


class Simulation:
    """A world with one UAV in it. wind_m_s: of the air, world frame; may be changed at any time.

    `sense` gives the first instant (t = 0, before any step), `step` every later one. autopilot: who flies;
    None: the PX4 stand-in, which is then also `px4`. Raises `SimulationToolsError` subclasses when files or
    parameters are bad.
    """

    def __init__(self, parameters: SimulationParameters, autopilot: Autopilot | None = None):
        self.parameters = parameters
        self.uav = load_uav(
            parameters.model,
            parameters.lidar,
            parameters.model_path,
            parameters.lidar_range_max_m,
            parameters.sensors,
        )
        self.uav_name = self.uav.model.name
        world = load_world(parameters.world, parameters.model_path)
        if parameters.static_models:
            world = replace(world, models=tuple(replace(model, static=True) for model in world.models))
        if any(model.name == self.uav_name for model in world.models):
            raise SimulationError(
                f'{parameters.world} already holds a model named "{self.uav_name}", as the UAV is called.'
            )
        self.warnings = (*world.warnings, *self.uav.model.warnings, *unsimulated(self.uav))
        self.wind_m_s = world.wind_m_s
        self._step_us = step_us_from(parameters.time_step_s)
        further = [sensor.name for _, sensor in further_sensors(self.uav)]
        self._streams = RandomStreams(parameters.seed, ("lidar", "imu", "odometry", "px4", *further))
        fixed = self.uav.model.static  # a lidar on a stand: an iris's rotors turn for nothing
        rotors_of = load_uav(IRIS, None, parameters.model_path).model if fixed else self.uav.model
        self.airframe = Airframe.from_sdf(rotors_of)
        rigid = frozenset() if fixed else self.airframe.rotor_joints
        self.gimbal = Gimbal.from_sdf(self.uav.model)
        if self.gimbal is not None:
            rigid |= frozenset(self.gimbal.joint_names)
        elif parameters.level_lidar:
            raise SimulationError(_NO_GIMBAL.format(self.uav_name))
        drawn = has_camera(self.uav.model)
        self.world = PhysicsWorld(world, parameters.time_step_s, parameters.gui, drawn)
        overlapping = warning_of(self.world.overlaps())
        self.warnings += (overlapping,) if overlapping else ()
        spawn_pose = parameters.spawn_pose @ Pose((0.0, 0.0, standing_height_m(self.uav.model)))
        self.world.spawn(self.uav.model, self.uav_name, spawn_pose, rigid)
        tuned = {"MPC_THR_HOVER": self._hover_thrust(), **parameters.px4_parameters}
        self.px4 = None
        if autopilot is None:
            autopilot = self.px4 = Px4(
                self.airframe, Px4Parameters(tuned), self._streams["px4"], origin=parameters.origin
            )
        self.autopilot: Autopilot = autopilot
        lidar, imu = self.uav.lidar, self.uav.imu
        self.lidar = Lidar(lidar.sensor, lidar.pose, self._streams["lidar"]) if lidar else None
        self._imu = Imu(imu.sensor, imu.pose, self._streams["imu"]) if imu else None
        self._odometry = DriftingOdometry(parameters.odometry, spawn_pose, self._streams["odometry"])
        self._scan_schedule = Schedule(lidar.sensor.update_rate_hz if lidar else 1.0)
        self._imu_schedule = Schedule(imu.sensor.update_rate_hz if imu else 1.0)
        self._pose_schedule = Schedule(POSE_RATE_HZ)
        self.payload = payload_sensors(self.uav, self.world, self._place_of, self._streams.__getitem__)
        self._begin()

    def _hover_thrust(self) -> float:
        """Return what an airframe file would give PX4 as MPC_THR_HOVER: closed form, within its limits.

        The estimator in flight finds it too, but only after the UAV has sunk by a metre.
        """
        gravity_m_s2 = math.hypot(*self.world.settings.gravity_m_s2)
        command = self.airframe.hover_command(self.world.mass_kg(self.uav_name), gravity_m_s2)
        return round(min(max(command, 0.1), 0.8), 2)

    def _begin(self) -> None:
        self.time_us = 0
        self._body = self.world.get_state(self.uav_name)
        q = self._body.pose.orientation_xyzw
        gravity = self.world.settings.gravity_m_s2
        self._specific_force = specific_force(ORIGIN, ORIGIN, 1.0, gravity, q)  # at rest
        self._odometry_us = 0
        further = [sensor.schedule for sensor in self.payload]
        for schedule in (self._scan_schedule, self._pose_schedule, self._imu_schedule, *further):
            schedule.restart()
        if self.gimbal is not None:
            self.gimbal.reset(self.parameters.level_lidar)
            self._aim_lidar()

    @property
    def time_step_s(self) -> float:
        """Length of a step, s."""
        return 1e-6 * self._step_us

    def set_time_step(self, time_step_s: float) -> None:
        """Make every later step this long; whole milliseconds, 1 to 8."""
        self._step_us = step_us_from(time_step_s)
        self.world.settings.time_step_s = time_step_s

    def step(self) -> StepOutput:
        """Advance by one time step: flight controller, rotors, physics, and what the sensors then see."""
        q = self._body.pose.orientation_xyzw
        velocity = self._body.linear_velocity_m_s
        commands = self.autopilot.step(self._state())
        dt_s = 1e-6 * self._step_us
        force, torque = self.airframe.step(
            commands, rotate_inverse(q, velocity), dt_s, rotate_inverse(q, self.wind_m_s)
        )
        self.world.apply_wrench(self.uav_name, force, torque)
        self.world.step()
        self.time_us += self._step_us
        self._body = self.world.get_state(self.uav_name)
        self._specific_force = self._felt_since(velocity, dt_s)
        self.autopilot.begin(self._state())  # a real PX4 thinks while sensors are read and published
        if self.time_us % WATCH_PERIOD_US < self._step_us:
            self._watch_bodies()
        if self.gimbal is not None and self.gimbal.is_active:
            self.gimbal.step(self._body.pose.orientation_xyzw, dt_s)
            self._aim_lidar()
        return self.sense()

    def _state(self) -> VehicleState:
        """Return what the flight controller's sensors feel now."""
        body, q = self._body, self._body.pose.orientation_xyzw
        turning = rotate_inverse(q, body.angular_velocity_rad_s)
        return VehicleState(self.time_us, body.pose, body.linear_velocity_m_s, turning, self._specific_force)

    def set_level_lidar(self, level: bool) -> None:
        """Switch the levelling of the lidar on or off; SimulationError when it is not on a gimbal."""
        if self.gimbal is None:
            raise SimulationError(_NO_GIMBAL.format(self.uav_name))
        self.gimbal.switch(level)

    def joint_angles(self) -> dict[str, float]:
        """Return the angle of every joint that moves, rad, by `model::joint`; a gimbal's once it was used."""
        angles = self.world.joint_angles()
        if self.gimbal is not None and self.gimbal.used:
            for joint, angle in zip(self.gimbal.joint_names, self.gimbal.angles_rad):
                angles[f"{self.uav_name}::{joint}"] = angle
        return angles

    def _aim_lidar(self) -> None:
        mount = self.uav.lidar
        if self.lidar is not None and mount.link in self.gimbal.carries:
            self.lidar.pose_in_body = self.gimbal.turned(mount.pose)

    def sense(self) -> StepOutput:
        """Return what the sensors that are due say now; at a scan odometry and ground truth always are."""
        time_us = self.time_us
        scan_now = self.lidar is not None and time_us >= self._scan_schedule.due_us
        odometry = ground_truth = scan = imu = None
        if scan_now or time_us >= self._pose_schedule.due_us:
            odometry, ground_truth = self._sense_pose()
        if self._imu is not None and time_us >= self._imu_schedule.due_us:
            imu = self._sense_imu()
        if scan_now:
            scan = self.lidar.scan(self.world.rays, self._body.pose, self.uav_name)
            self._scan_schedule.fired(time_us)
        contacts = self.world.contacts(self.uav_name)
        payload = self._payload_due() if self.payload else ()
        return StepOutput(time_us, scan, odometry, ground_truth, imu, contacts, payload)

    def _payload_due(self) -> tuple[PayloadSensor, ...]:
        due = tuple(sensor for sensor in self.payload if self.time_us >= sensor.schedule.due_us)
        for sensor in due:
            sensor.schedule.fired(self.time_us)
        return due

    def _place_of(self, mount: MountedSensor) -> Pose:
        """Pose of a sensor in the world, whatever carries it."""
        carried = self.gimbal is not None and mount.link in self.gimbal.carries
        return self._body.pose @ (self.gimbal.turned(mount.pose) if carried else mount.pose)

    def _sense_pose(self) -> tuple[OdometrySample, OdometrySample]:
        body, q = self._body, self._body.pose.orientation_xyzw
        truth = OdometrySample(
            body.pose,
            rotate_inverse(q, body.linear_velocity_m_s),
            rotate_inverse(q, body.angular_velocity_rad_s),
        )
        odometry = self._odometry.update(body, 1e-6 * (self.time_us - self._odometry_us))
        self._odometry_us = self.time_us
        self._pose_schedule.fired(self.time_us)
        return odometry, truth

    def _sense_imu(self) -> ImuSample:
        body, q = self._body, self._body.pose.orientation_xyzw
        self._imu_schedule.fired(self.time_us)
        return self._imu.sample(q, self._specific_force, rotate_inverse(q, body.angular_velocity_rad_s))

    def _felt_since(self, velocity_before: Vector3, dt_s: float) -> Vector3:
        """Specific force over the step that has just been made, body axes; SimulationError if not finite."""
        body, gravity = self._body, self.world.settings.gravity_m_s2
        felt = specific_force(
            velocity_before, body.linear_velocity_m_s, dt_s, gravity, body.pose.orientation_xyzw
        )
        if not math.isfinite(felt[0] + felt[1] + felt[2]):
            raise self._diverged(self.uav_name)
        return felt

    def _watch_bodies(self) -> None:
        """Raise PhysicsDivergedError when anything is beyond all reason."""
        name = self.world.beyond_reason()
        if name is not None:
            raise self._diverged(name)

    def _diverged(self, name: str) -> PhysicsDivergedError:
        return PhysicsDivergedError(
            f'The physics of "{name}" diverged at t = {1e-6 * self.time_us:.3f} s; '
            "look for bodies spawned inside each other, and for speeds and masses beyond reason."
        )

    def reset(self) -> None:
        """Go back to t = 0: same poses, rebooted flight controller, same noise; the flight repeats itself."""
        self._streams.rewind()
        self.world.reset()
        self.airframe.reset()
        self.autopilot.reset()
        self._odometry.reset()
        self._begin()

    def warm_up(self) -> None:
        """Fly for a second, then reset: whatever compiles or loads on first use has done so afterwards.

        With another autopilot than the stand-in nothing flies: it would see the time of the second go back.
        """
        if self.px4 is None:
            return
        for _ in range(round(1.0 / self.time_step_s)):
            self.px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 1.0)))
            self.px4.request_mode(Mode.OFFBOARD)
            self.px4.request_arm()
            self.step()
        self.reset()

    def reset_poses(self) -> None:
        """Put every model back to where it started; time, noise and flight controller go on."""
        self.world.reset()
        self.models_moved()

    def models_moved(self) -> None:
        """Look at the UAV again after something else than a step has moved it: no IMU feels such a move."""
        self._body = self.world.get_state(self.uav_name)

    def close(self) -> None:
        """Release the physics engine and the autopilot."""
        self.autopilot.close()
        self.world.close()
