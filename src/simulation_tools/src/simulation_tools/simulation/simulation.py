"""The simulation without ROS: world, UAV, flight controller and sensors, one step at a time.

The `gazebo` node, the closed-loop tests and the campaigns all drive this one class, so a flight is the same
everywhere. It is deterministic bit for bit: time is a whole number of microseconds, every sensor has a random
stream of its own, and nothing looks at a clock.
"""

from __future__ import annotations

import math
from dataclasses import replace

from simulation_tools.autopilot import Autopilot, VehicleState
from simulation_tools.geometry import IDENTITY, ORIGIN, Pose, Vector3, rotate_inverse
from simulation_tools.ned_frames import attitude_to_ned
from simulation_tools.px4.estimation.choice import EKF2
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.sdf.elements import World
from simulation_tools.sdf.parser import load_world
from simulation_tools.simulation.own_motion import own_motion
from simulation_tools.simulation.parameters import (
    WITHOUT_GNSS,
    PhysicsDivergedError,
    SimulationError,
    SimulationParameters,
    step_us_from,
)
from simulation_tools.simulation.payload import further_sensors, has_camera, sees_visuals, unsimulated
from simulation_tools.simulation.random_streams import RandomStreams
from simulation_tools.simulation.sensor_suite import SensorSuite, StepOutput
from simulation_tools.simulation.window import Window
from simulation_tools.vehicle.airframe import Airframe
from simulation_tools.vehicle.energy.power_supply import PowerSupply
from simulation_tools.vehicle.gimbal import Gimbal
from simulation_tools.vehicle.nod import Nod
from simulation_tools.vehicle.uav import load_uav, remarks_on
from simulation_tools.vehicle.wind import Wind, streams_of
from simulation_tools.world.overlaps import warning_of
from simulation_tools.world.shapes.meshes import standing_height_m
from simulation_tools.world.world import PhysicsWorld

IRIS = "iris"
"""If the UAV is a static model (a lidar on a stand), the rotors of this model turn instead."""

WIND = "wind of the world"
"""Name of the wind's random stream; no sensor is called so."""

WARM_UP_MOST_S = 10.0
"""Of simulated time; an estimator may need some seconds to find its position."""

_STANDING_RAD_S = 1e-3
"""A rotor slower than this stands."""

WATCH_PERIOD_US = 100_000
"""Time between two checks that no body is absurdly far or fast."""


class Simulation:
    """A world with one UAV in it. wind_m_s: of the air, world frame; may be changed at any time.

    `sense` gives the first instant (t = 0, before any step), `step` every later one. autopilot: what flies;
    None: the PX4 stand-in, which is then also `px4`. Raises `SimulationToolsError` subclasses when files or
    parameters are bad.
    """

    def __init__(self, parameters: SimulationParameters, autopilot: Autopilot | None = None) -> None:
        self.parameters = parameters
        self.uav = load_uav(
            parameters.model,
            parameters.lidar,
            parameters.model_path,
            parameters.lidar_range_max_m,
            parameters.sensors,
            parameters.lidar_noise_factor,
        )
        self.uav_name = self.uav.model.name
        world = _world_of(parameters, self.uav_name)
        self.wind_m_s = world.wind_m_s
        self._step_us = step_us_from(parameters.time_step_s)
        further = [sensor.name for _, sensor in further_sensors(self.uav)]
        self._streams = RandomStreams(parameters.seed, ("lidar", "imu", "odometry", "px4", *further, WIND))
        gusts = (*streams_of(world), *parameters.wind)
        self._gusts = Wind(gusts, self._streams[WIND]) if gusts else None
        is_fixed = self.uav.model.static
        rotors_of = load_uav(IRIS, None, parameters.model_path).model if is_fixed else self.uav.model
        self.airframe = Airframe.from_sdf(rotors_of)
        rigid_joints = frozenset() if is_fixed else self.airframe.rotor_joints
        self.power = PowerSupply.from_sdf(self.uav.model, parameters.battery)
        self.gimbal = Gimbal.from_sdf(self.uav.model)
        if self.gimbal is not None:
            rigid_joints |= frozenset(self.gimbal.joint_names)
        elif parameters.level_lidar:
            raise self._no_gimbal()
        self.world = PhysicsWorld(
            world,
            parameters.time_step_s,
            drawn=has_camera(self.uav.model) or parameters.gui,
            seen=sees_visuals(self.uav.model),
        )
        overlapping = warning_of(self.world.overlaps())
        self.warnings = (
            *self.world.remarks,
            *world.warnings,
            *self.uav.model.warnings,
            *remarks_on(parameters.model, self.uav.model),
            *unsimulated(self.uav),
            *((overlapping,) if overlapping else ()),
        )
        spawn_pose = parameters.spawn_pose @ Pose((0.0, 0.0, standing_height_m(self.uav.model)))
        self.world.spawn(self.uav.model, self.uav_name, spawn_pose, rigid_joints)
        self._window = Window(self.world, self.uav_name) if parameters.gui else None
        self.px4: Px4 | None = None
        if autopilot is None:
            autopilot = self.px4 = self._stand_in()
        self.autopilot: Autopilot = autopilot
        self._sensors = SensorSuite(
            self.uav,
            self.world,
            self.gimbal,
            (parameters.odometry, spawn_pose),
            self._streams,
            lambda: self._body.pose,
        )
        self.lidar, self.payload = self._sensors.lidar, self._sensors.payload
        self._begin()

    def _stand_in(self) -> Px4:
        """Return the PX4 stand-in with the hover thrust that an airframe file would set.

        PX4's estimator finds the hover thrust in flight too, but only after the UAV has sunk by a metre.
        """
        gravity_m_s2 = math.hypot(*self.world.settings.gravity_m_s2)
        command = self.airframe.hover_command(self.world.mass_kg(self.uav_name), gravity_m_s2)
        within_limits = round(min(max(command, 0.1), 0.8), 2)
        given = self.parameters
        without = {} if given.gnss else WITHOUT_GNSS
        tuned = {"MPC_THR_HOVER": within_limits, **without, **given.px4_parameters}
        return Px4(
            self.airframe,
            Px4Parameters(tuned),
            self._streams["px4"],
            origin=given.origin,
            estimator=given.estimator if given.gnss else EKF2,
        )

    def _begin(self) -> None:
        self.time_us = 0
        self._body = self.world.get_state(self.uav_name)
        velocity = self._body.linear_velocity_m_s  # the same before: no acceleration is felt
        self._own = own_motion(velocity, self._body, 1.0, self.world.settings.gravity_m_s2)
        self._told: VehicleState | None = None  # the flight controller's newest state
        self._sensors.restart()
        if self._gusts is not None:
            self._gusts.restart()
        if self.gimbal is not None:
            self.gimbal.reset(self.parameters.level_lidar)
            self._sensors.aim_lidar()

    @property
    def time_step_s(self) -> float:
        """Length of a step, s."""
        return 1e-6 * self._step_us

    def set_time_step(self, time_step_s: float) -> None:
        """Make every later step this long; whole milliseconds, 1 to 8."""
        self._step_us = step_us_from(time_step_s)
        self.world.settings.time_step_s = time_step_s

    def step(self) -> StepOutput:
        """Advance by one time step: flight controller, rotors, physics, then the sensors."""
        dt_s = 1e-6 * self._step_us
        commands = self.autopilot.step(self._state())
        velocity, wind = self._own.velocity_m_s, self._wind_in_body(dt_s)
        if self.power is not None:
            commands = self.power.supplied(commands)
        force, torque = self.airframe.step(commands, velocity, dt_s, wind)
        if self.power is not None:
            self.power.draw(self.airframe.thrusts_n, velocity[2] - wind[2], dt_s)
        self.world.apply_wrench(self.uav_name, force, torque)
        self.world.step()
        self.time_us += self._step_us
        self._move(dt_s)
        if self._window is not None:
            self._window.update()
        if self.px4 is None:  # a real PX4 computes while sensors are read and published
            self.autopilot.begin(self._state())
        if self.time_us % WATCH_PERIOD_US < self._step_us:
            self._check_bodies()
        if self.gimbal is not None and self.gimbal.is_active:
            self.gimbal.step(self._body.pose.orientation_xyzw, dt_s)
            self._sensors.aim_lidar()
        return self.sense()

    def _wind_in_body(self, dt_s: float) -> Vector3:
        """Return the velocity of the air during the next step, m/s, body axes."""
        x, y, z = self.wind_m_s
        if self._gusts is not None:
            gx, gy, gz = self._gusts.step(1e-6 * self.time_us, dt_s)
            x, y, z = x + gx, y + gy, z + gz
        if not (x or y or z):
            return ORIGIN
        return rotate_inverse(self._body.pose.orientation_xyzw, (x, y, z))

    def _move(self, dt_s: float) -> None:
        """Look where the last step has brought the UAV, and what it felt; that must be finite."""
        before, self._body = self._body, self.world.get_state(self.uav_name)
        gravity = self.world.settings.gravity_m_s2
        self._own = own_motion(before.linear_velocity_m_s, self._body, dt_s, gravity)
        self._told = None
        x, y, z = self._own.specific_force_m_s2
        if not math.isfinite(x + y + z):
            raise self._diverged(self.uav_name)

    def sense(self) -> StepOutput:
        """Return the measurements that are due now. Odometry and ground truth come with every scan."""
        return self._sensors.read(self.time_us, self._body, self._own)

    def _state(self) -> VehicleState:
        """Return the UAV's present state for the flight controller."""
        battery = None if self.power is None else self.power.battery.reading
        told = self._told
        if told is None or told.battery is not battery:
            (pose, velocity, _), (_, turning, felt) = self._body, self._own
            self._told = told = VehicleState(self.time_us, pose, velocity, turning, felt, battery)
        return told

    def swap_battery(self) -> None:
        """Put in a full battery; SimulationError if there is none, or if the rotors turn.

        Without a battery of its own the UAV flies by the one that the PX4 stand-in simulates.
        """
        if self.power is None and self.px4 is None:
            raise SimulationError(
                "The flight controller simulates the battery itself, so the simulator has none to swap: "
                "see simulation_tools/doc/battery.md."
            )
        if self.airframe.rotor_states.max() > _STANDING_RAD_S:
            raise SimulationError(
                "The battery cannot be swapped while the rotors turn. Land and disarm first."
            )
        if self.power is not None:
            self.power.battery.swap()
        elif self.px4 is not None:
            self.px4.swap_battery()

    def set_level_lidar(self, level: bool) -> None:
        """Switch the levelling of the lidar on or off; SimulationError when it is not on a gimbal."""
        if self.gimbal is None:
            raise self._no_gimbal()
        self.gimbal.switch(level)

    def nod_lidar(self, nod: Nod) -> None:
        """Let the lidar look up and down about level, from the next step on; amplitude 0 ends it.

        Raises:
            SimulationError: the lidar is not on a gimbal.
            GimbalError: the gimbal cannot follow.
        """
        if self.gimbal is None:
            raise self._no_gimbal()
        self.gimbal.start_nod(nod)

    def _no_gimbal(self) -> SimulationError:
        return SimulationError(
            f'The lidar of "{self.uav_name}" cannot be turned: its SDF has no gimbal (see models/iris).'
        )

    def joint_angles(self) -> dict[str, float]:
        """Return the angle of every joint that moves, rad, by `model::joint`.

        A gimbal's joints count once it was used.
        """
        angles = self.world.joint_angles()
        if self.gimbal is not None and self.gimbal.used:
            for joint, angle in zip(self.gimbal.joint_names, self.gimbal.angles_rad):
                angles[f"{self.uav_name}::{joint}"] = angle
        return angles

    def _check_bodies(self) -> None:
        """Raise PhysicsDivergedError when a body is absurdly far or fast."""
        name = self.world.beyond_reason()
        if name is not None:
            raise self._diverged(name)

    def _diverged(self, name: str) -> PhysicsDivergedError:
        return PhysicsDivergedError(
            f'The physics of "{name}" diverged at t = {1e-6 * self.time_us:.3f} s; '
            "look for bodies spawned inside each other, and for speeds and masses beyond reason."
        )

    def reset(self) -> None:
        """Go back to t = 0 with the same poses, a rebooted flight controller and the same noise.

        The flight repeats.
        """
        self._streams.rewind()
        self.world.reset()
        self.airframe.reset()
        if self.power is not None:
            self.power.battery.reset()
        self.autopilot.reset()
        self._begin()

    def warm_up(self) -> None:
        """Fly for a second, then reset, so that everything is compiled and loaded before it is needed.

        With another autopilot than the stand-in this does nothing, because that autopilot would see time go
        back.
        """
        if self.px4 is None:
            return
        for _ in range(round(WARM_UP_MOST_S / self.time_step_s)):
            sample = ExternalVision(self.time_us, ORIGIN, attitude=attitude_to_ned(IDENTITY.orientation_xyzw))
            self.px4.offer_external_vision(sample)
            self.px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 1.0)))
            self.px4.request_mode(Mode.OFFBOARD)
            self.px4.request_arm()
            self.step()
            armed_us = self.px4.armed_since_us
            if armed_us is not None and self.time_us - armed_us > 1_000_000:
                break
        self.reset()

    def reset_poses(self) -> None:
        """Put every model back to where it started; time, noise and flight controller go on."""
        self.world.reset()
        self.models_moved()

    def models_moved(self) -> None:
        """Read the UAV's state again after a call has moved it between two steps.

        The IMU must not measure this move.
        """
        body = self._body = self.world.get_state(self.uav_name)
        moved = own_motion(body.linear_velocity_m_s, body, 1.0, self.world.settings.gravity_m_s2)
        self._own = moved._replace(specific_force_m_s2=self._own.specific_force_m_s2)
        self._told = None

    def close(self) -> None:
        """Release the physics engine and the autopilot."""
        self.autopilot.close()
        if self._window is not None:
            self._window.close()
        self.world.close()


def _world_of(parameters: SimulationParameters, uav_name: str) -> World:
    """Read the world, its models fixed if the parameters say so; refuse one that holds the UAV's name."""
    world = load_world(parameters.world, parameters.model_path, parameters.static_models)
    if any(model.name == uav_name for model in world.models):
        raise SimulationError(
            f'{parameters.world} already holds a model named "{uav_name}", as the UAV is called.'
        )
    if parameters.static_models:  # actors too
        models = tuple(replace(model, static=True, script=None) for model in world.models)
        return replace(world, models=models)
    return world
