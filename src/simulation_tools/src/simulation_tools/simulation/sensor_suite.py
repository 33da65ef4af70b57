"""The sensors of the simulated UAV: which one is due at an instant, and what it measures."""

from __future__ import annotations

from typing import Callable, NamedTuple, Sequence

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sensors.imu import Imu, ImuSample
from simulation_tools.sensors.lidar import Lidar
from simulation_tools.sensors.odometry import DriftingOdometry, OdometryParameters, OdometrySample
from simulation_tools.sensors.schedule import Schedule
from simulation_tools.simulation.own_motion import OwnMotion
from simulation_tools.simulation.payload import PayloadSensor, payload_sensors, scene_of
from simulation_tools.simulation.random_streams import RandomStreams
from simulation_tools.vehicle.gimbal import Gimbal
from simulation_tools.vehicle.uav import MountedSensor, Uav
from simulation_tools.world.world import BodyState, Contact, PhysicsWorld

POSE_RATE_HZ = 100.0
"""Rate of odometry and ground truth, as TF needs it. They also come with every scan."""


class StepOutput(NamedTuple):
    """The measurements of one instant; None for a sensor that is not due.

    scan: float32 ranges (beams,) in metres by REP-117. odometry: pose in `odom` and body twist, with drift.
    ground_truth: the same in `world`, true. contacts: of the UAV, right now. payload: the further sensors
    that are due. Each one measures when somebody reads it.
    """

    time_us: int
    scan: np.ndarray | None
    odometry: OdometrySample | None
    ground_truth: OdometrySample | None
    imu: ImuSample | None
    contacts: Sequence[Contact]
    payload: tuple[PayloadSensor, ...] = ()


class SensorSuite:
    """Lidar, IMU, odometry and further sensors, each with its own schedule and random stream.

    lidar: None where the UAV has none. payload: the further sensors.
    """

    def __init__(
        self,
        uav: Uav,
        world: PhysicsWorld,
        gimbal: Gimbal | None,
        odometry: tuple[OdometryParameters, Pose],
        streams: RandomStreams,
        uav_pose: Callable[[], Pose],
    ) -> None:
        """odometry: its parameters, and the true pose at which it starts. uav_pose: where the UAV is now."""
        self._uav_name = uav.model.name
        self._world = world
        self._gimbal = gimbal
        self._lidar_mount = uav.lidar
        lidar, imu = uav.lidar, uav.imu
        self._scene = scene_of(world, lidar.sensor) if lidar else world.rays
        self.lidar = Lidar(lidar.sensor, lidar.pose, streams["lidar"]) if lidar else None
        self._imu = Imu(imu.sensor, imu.pose, streams["imu"]) if imu else None
        self._odometry = DriftingOdometry(*odometry, streams["odometry"])
        self._odometry_us = 0
        self._scan_schedule = Schedule(lidar.sensor.update_rate_hz if lidar else 1.0)
        self._imu_schedule = Schedule(imu.sensor.update_rate_hz if imu else 1.0)
        self._pose_schedule = Schedule(POSE_RATE_HZ)
        self.payload = payload_sensors(
            uav, world, lambda mount: uav_pose() @ self._pose_in_body(mount), streams.__getitem__
        )

    def restart(self) -> None:
        """Begin again at t = 0: every sensor is due, and the odometry forgets its way."""
        self._odometry_us = 0
        self._odometry.reset()
        further = [sensor.schedule for sensor in self.payload]
        for schedule in (self._scan_schedule, self._pose_schedule, self._imu_schedule, *further):
            schedule.restart()

    def aim_lidar(self) -> None:
        """Turn the lidar to the gimbal's present angles."""
        if self.lidar is not None and self._lidar_mount is not None:
            self.lidar.pose_in_body = self._pose_in_body(self._lidar_mount)

    def read(self, time_us: int, body: BodyState, own: OwnMotion) -> StepOutput:
        """Return the measurements of all sensors that are due.

        Odometry and ground truth also come with every scan.

        body: the UAV in the world now. own: its motion in its own axes.
        """
        scan_now = self.lidar is not None and time_us >= self._scan_schedule.due_us
        odometry = ground_truth = scan = imu = None
        if scan_now or time_us >= self._pose_schedule.due_us:
            odometry, ground_truth = self._read_pose(time_us, body.pose, own)
        if self._imu is not None and time_us >= self._imu_schedule.due_us:
            self._imu_schedule.fired(time_us)
            imu = self._imu.sample(body.pose.orientation_xyzw, own.specific_force_m_s2, own.turning_rad_s)
        if self.lidar is not None and scan_now:
            scan = self.lidar.scan(self._scene, body.pose, self._uav_name)
            self._scan_schedule.fired(time_us)
        contacts = self._world.contacts(self._uav_name)
        payload = self._payload_due(time_us) if self.payload else ()
        return StepOutput(time_us, scan, odometry, ground_truth, imu, contacts, payload)

    def _read_pose(self, time_us: int, pose: Pose, own: OwnMotion) -> tuple[OdometrySample, OdometrySample]:
        truth = OdometrySample(pose, own.velocity_m_s, own.turning_rad_s)
        odometry = self._odometry.update(truth, 1e-6 * (time_us - self._odometry_us))
        self._odometry_us = time_us
        self._pose_schedule.fired(time_us)
        return odometry, truth

    def _payload_due(self, time_us: int) -> tuple[PayloadSensor, ...]:
        due = tuple(sensor for sensor in self.payload if time_us >= sensor.schedule.due_us)
        for sensor in due:
            sensor.schedule.fired(time_us)
        return due

    def _pose_in_body(self, mount: MountedSensor) -> Pose:
        """Return a sensor's pose in the UAV's model frame.

        If the gimbal carries it, its present angles count.
        """
        gimbal = self._gimbal
        return gimbal.turned(mount.pose) if gimbal and mount.link in gimbal.carries else mount.pose
