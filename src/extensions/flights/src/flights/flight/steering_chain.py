"""The part of the chain between a scan and a velocity, from the classes of its nodes."""

from __future__ import annotations

from typing import Callable, NamedTuple, Sequence

import numpy as np

from cepa import LaserScan2D, Ranging, SteeringLoop
from cepa.algorithm import Algorithm
from cepa.steering.answering import RANGE_FINDERS, Answer
from cepa.steering.clouds import CloudLimits, SensedPoints
from cepa.steering.inertial_path import InertialReading
from cepa.steering.loop import Command
from cepa.steering.mount import Mount
from cepa.steering.own_motion import OwnState
from inspection_tools import (
    LidarMedianFilter,
    LidarPadding,
    MedianFilterParameters,
    PaddingParameters,
    ScanGeometry,
    YawRegulatorParameters,
    YawSteering,
)
from inspection_tools.yaw.steering import Turn
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sensors.cloud import Cloud as LidarTurn
from simulation_tools.sensors.cloud import CloudLidar
from simulation_tools.sensors.lidar import Lidar
from simulation_tools.sensors.odometry import OdometrySample
from simulation_tools.sensors.range_finder import RangeFinder
from simulation_tools.simulation.payload import PayloadSensor

FRAME = "hokuyo"
"""Of the lidar. Only one UAV flies, so any name would do."""


class Flown(NamedTuple):
    """A velocity for the flight controller: ahead, left, up. answer: None while the UAV brakes blindly."""

    time_us: int
    velocity_m_s: Vector3
    yaw_rate_rad_s: float
    answer: Answer | None


NOTHING: Sequence[Flown] = ()
"""Most messages bring nothing to fly."""


class SteeringChain:
    """Median filter, padding, collision avoidance and yaw regulator, in the order of the nodes.

    Every message goes in when it comes, and each call returns what is to be flown.

    payload: the UAV's further sensors. uses_range_finders: CEPA heeds those that look up and down. warn:
    takes a sentence whenever something is wrong. uses_imu: CEPA compares the odometry with an IMU.
    """

    def __init__(
        self,
        lidar: Lidar,
        payload: Sequence[PayloadSensor],
        algorithm: Algorithm,
        median_filter: MedianFilterParameters,
        padding: PaddingParameters,
        yaw_regulator: YawRegulatorParameters,
        uses_range_finders: bool,
        warn: Callable[[str], None] = lambda sentence: None,
        uses_imu: bool = False,
    ) -> None:
        self._lidar_limits = lidar.range_min, lidar.range_max
        self._geometry = ScanGeometry(lidar.beams, lidar.angle_min, lidar.angle_increment)
        self._median_filter = LidarMedianFilter(median_filter)
        self._padding = LidarPadding(padding)
        self._yaw_steering = YawSteering(yaw_regulator)
        mount = mount_of(lidar.pose_in_body)
        limits = cloud_limits_of(payload) if algorithm.wants_cloud else None
        self._uses_cloud = limits is not None
        self._wants_single_beams = algorithm.wants_single_beams
        self._range_finders = RANGE_FINDERS if uses_range_finders else ()
        self._loop = SteeringLoop(
            algorithm, lambda frame: mount, warn, limits, uses_range_finders, uses_imu=uses_imu
        )
        self.newest_scan: LaserScan2D | None = None  # the algorithm's input: filtered and padded

    def on_reference(self, time_us: int, v_ref_m_s: Vector3) -> Sequence[Flown]:
        """Take in the wanted velocity: ahead, left, up."""
        turns = self._yaw_steering.on_reference(1000 * time_us, v_ref_m_s[:2])
        commands = self._loop.on_reference(1000 * time_us, v_ref_m_s)
        if not (turns or commands):
            return NOTHING
        return _flown(turns) + self._turned(commands)

    def on_front(self, time_us: int, front: tuple[float, float]) -> None:
        """Take in where the front is to point (x, y), levelled body frame; see `YawSteering.on_front`."""
        self._yaw_steering.on_front(1000 * time_us, front)

    def on_odometry(self, time_us: int, sample: OdometrySample) -> Sequence[Flown]:
        """Take in the UAV's own motion."""
        pose = sample.pose
        state = OwnState(sample.linear_velocity_m_s, pose.position_m, pose.orientation_xyzw)
        commands = self._loop.on_odometry(1000 * time_us, state)
        return self._turned(commands) if commands else NOTHING

    def on_imu(self, time_us: int, rates_rad_s: Vector3, force_m_s2: Vector3) -> None:
        """Take in what the IMU feels, in the body's axes."""
        self._loop.on_imu(1000 * time_us, InertialReading(rates_rad_s, force_m_s2))

    def on_payload(self, time_us: int, due: Sequence[PayloadSensor]) -> list[Flown]:
        """Measure with those further sensors that are due and that the algorithm uses."""
        commands = []
        for sensor in due:
            if isinstance(sensor.device, CloudLidar) and self._uses_cloud:
                commands += self._loop.on_cloud(1000 * time_us, points_of(sensor))
            elif sensor.name in self._range_finders:
                commands += self._loop.on_range(sensor.name, 1000 * time_us, ranging_of(sensor))
        return self._turned(commands)

    def on_scan(self, time_us: int, ranges: np.ndarray) -> list[Flown]:
        """Take in the lidar's ranges (beams,), m."""
        self.newest_scan = scan = self._prepared(ranges)
        return self._turned(self._loop.on_scan(1000 * time_us, scan, FRAME))

    def _prepared(self, ranges: np.ndarray) -> LaserScan2D:
        filtered = ranges
        if not self._wants_single_beams:
            filtered = self._median_filter.filter(ranges, self._geometry, *self._lidar_limits)
        padded = self._padding.pad(filtered, self._geometry, *self._lidar_limits)
        angles = padded.geometry.angle_min_rad, padded.geometry.angle_increment_rad
        return LaserScan2D(padded.ranges, *angles, *self._lidar_limits, seen=padded.seen)

    def _turned(self, commands: list[Command]) -> list[Flown]:
        turns: list[Turn] = []
        for command in commands:
            turns += self._yaw_steering.on_command(command.stamp_ns, command.velocity_m_s[:2], command)
        return _flown(turns)


def _flown(turns: list[Turn]) -> list[Flown]:
    return [
        Flown(command.stamp_ns // 1000, command.velocity_m_s, yaw_rate, command.answer)
        for command, yaw_rate in turns
    ]


def mount_of(pose_in_body: Pose) -> Mount:
    """Return how a sensor with this pose sits on the body."""
    return Mount.of_pose(pose_in_body.position_m, pose_in_body.orientation_xyzw)


def cloud_limits_of(payload: Sequence[PayloadSensor]) -> CloudLimits | None:
    """Return where the UAV's three-dimensional lidar looks; None if it has none."""
    for sensor in payload:
        if isinstance(sensor.device, CloudLidar):
            lidar = sensor.device.sensor
            up, around = lidar.vertical, lidar.horizontal
            return CloudLimits(
                (up.min_angle_rad, up.max_angle_rad),
                (around.min_angle_rad, around.max_angle_rad),
                (lidar.range_min_m, lidar.range_max_m),
            )
    return None


def points_of(sensor: PayloadSensor) -> SensedPoints:
    """Measure with a three-dimensional lidar."""
    turn = sensor.shared()
    assert isinstance(turn, LidarTurn)
    return SensedPoints(turn.points_m.astype(float), mount_of(sensor.mount.pose))


def ranging_of(sensor: PayloadSensor) -> Ranging:
    """Measure with a range finder, in the body's frame. It looks along the x axis of its own frame."""
    assert isinstance(sensor.device, RangeFinder)
    range_m, pose = sensor.shared(), sensor.mount.pose
    assert isinstance(range_m, float)
    direction: np.ndarray = pose.rotation[:, 0]
    x, y, z = direction.tolist()
    limits = sensor.device.range_min, sensor.device.range_max
    return Ranging(pose.position_m, (x, y, z), range_m, *limits)
