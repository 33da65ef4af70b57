"""Flight without GNSS in the closed loop, in place of lidar_odometry, vision_pose_publisher and MAVROS."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flights.errors import FlightError
from flights.flight.due import Due
from gridslam.cloud_odometry import CloudOdometry, SensedCloud
from gridslam.level_cloud import LevelCloud
from gridslam.odometry import LidarOdometry, OdometryEstimate
from gridslam.odometry.inertial import InertialReading
from gridslam.odometry.intake import Answer, OdometryIntake, SensedRange, SensedScan
from inspection_tools.vision_pose import Motion, VisionPose, VisionState
from simulation_tools.geometry import (
    Pose,
    Quaternion,
    Vector3,
    quaternion_from_rpy,
    rpy_from_quaternion,
)
from simulation_tools.ned_frames import attitude_to_enu, attitude_to_ned, enu_to_ned, flu_to_frd
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.px4.px4 import Px4
from simulation_tools.sensors.cloud import Cloud, CloudLidar
from simulation_tools.sensors.odometry import OdometrySample
from simulation_tools.sensors.range_finder import RangeFinder
from simulation_tools.simulation import Simulation, StepOutput
from simulation_tools.simulation.payload import PayloadSensor

IMU_PERIOD_US = 20_000
"""Of PX4's ATTITUDE_QUATERNION on the offboard link."""
_LIDAR_FRAME = "hokuyo"
CLOUDS_KEPT = 8
LIDAR, RANGE_FINDER, BRIDGE, SLAM = "lidar", "range_finder", "bridge", "slam"
PARTS = (LIDAR, RANGE_FINDER, BRIDGE, SLAM)
"""The bridge is vision_pose_publisher, which begins anew when it comes back. So does SLAM."""


def felt_by(px4: Px4) -> tuple[Vector3, Vector3]:
    """Return the rates, rad/s, and the specific force, m/s2, about the body's axes as MAVROS tells them."""
    estimate = px4.estimate[0]
    rates, force = (flu_to_frd(estimate[name].tolist()) for name in ("rates", "specific_force"))
    return rates, force


@dataclass(frozen=True)
class Outage:
    """A part of the chain dies in flight.

    part: of `PARTS`. begins_s: simulation time. lasts_s: infinite: for good.
    """

    part: str
    begins_s: float
    lasts_s: float = math.inf

    def __post_init__(self) -> None:
        if self.part not in PARTS:
            raise FlightError(f"There is no part '{self.part}' to end; choose one of {', '.join(PARTS)}.")

    def holds(self, part: str, t_s: float) -> bool:
        """Whether this part is dead at a time."""
        return part == self.part and self.begins_s <= t_s < self.begins_s + self.lasts_s

    def applied_to(self, output: StepOutput) -> StepOutput:
        """Return what is still measured: a dead lidar gives neither scans nor clouds."""
        dead = {LIDAR: CloudLidar, RANGE_FINDER: RangeFinder}.get(self.part)
        if dead is None or not self.holds(self.part, 1e-6 * output.time_us):
            return output
        alive = tuple(sensor for sensor in output.payload if not isinstance(sensor.device, dead))
        return output._replace(scan=None if self.part == LIDAR else output.scan, payload=alive)


class Estimated(NamedTuple):
    """Odometry at the stamp of a scan, which may be older than the present time step."""

    time_us: int
    sample: OdometrySample


class OwnOdometry:
    """Odometry from the simulated lidar, the flight controller's IMU and the range finder.

    A lidar with clouds is followed by these, any other by its scans. These wait for readings and ranges, as
    in the node.
    uses_clouds: whether the lidar has any. clouds: the last ones, by the simulation's time in us. estimates:
    of all scans or clouds. cpu_ms: CPU time of each.
    told_us: time of the last pose that the flight controller got.
    """

    def __init__(self, simulation: Simulation, px4: Px4) -> None:
        """Begin at the spawn pose; raises FlightError if the UAV has no range finder."""
        if not any(isinstance(sensor.device, RangeFinder) for sensor in simulation.payload):
            raise FlightError("Without GNSS the UAV needs a range finder; add sensors:=range_finder.")
        spawn, lidar = simulation.parameters.spawn_pose, simulation.lidar
        assert lidar is not None  # the closed loop has looked
        self._lidar, self._px4 = lidar, px4
        self._mounts = {sensor.name: sensor.mount.pose for sensor in simulation.payload}
        self._mounts[_LIDAR_FRAME] = lidar.pose_in_body
        start = (*spawn.position_m[:2], spawn.yaw_rad)
        self.uses_clouds = any(isinstance(sensor.device, CloudLidar) for sensor in simulation.payload)
        self._intake: OdometryIntake = OdometryIntake(
            CloudOdometry(start=start) if self.uses_clouds else LidarOdometry(start=start),
            self._mount_of,
            say=lambda sentence: None,
        )
        self._vision = VisionPose()
        self._imu_due = Due(IMU_PERIOD_US)
        self.clouds: dict[int, SensedCloud] = {}
        self.estimates: list[OdometryEstimate] = []
        self.cpu_ms: list[float] = []
        self.told_us: int | None = None
        self._bridge_is_dead = False

    @property
    def is_good(self) -> bool:
        """Whether the flight controller gets the poses, as vision_pose_publisher says."""
        return self._vision.state is VisionState.GOOD

    def on_step(self, output: StepOutput, outage: Outage | None = None) -> list[Estimated]:
        """Take the sensors of one instant. Return the odometry that is known now, oldest first."""
        t_s = 1e-6 * output.time_us
        self._watch_bridge(outage is not None and outage.holds(BRIDGE, t_s))
        started = time.thread_time()
        answers = self._intake.on_imu(self._inertial(t_s)) if self._imu_due(output.time_us) else []
        for sensor in output.payload:
            answers += self._on_payload(output.time_us, sensor)
        if output.scan is not None and not self.uses_clouds:
            answers += self._intake.on_lidar(self._sensed(output.time_us, output.scan))
        if answers:
            self.cpu_ms.append(1e3 * (time.thread_time() - started) / len(answers))
        return [self._estimated(answer.stamp_ns // 1000, answer.estimate) for answer in answers]

    def _on_payload(self, time_us: int, sensor: PayloadSensor) -> list[Answer]:
        t_s = 1e-6 * time_us
        if isinstance(sensor.device, RangeFinder):
            range_m, limits = sensor.shared(), (sensor.device.range_min, sensor.device.range_max)
            assert isinstance(range_m, float)
            return self._intake.on_range(t_s, SensedRange(range_m, limits, sensor.name))
        if isinstance(sensor.device, CloudLidar):
            cloud = sensor.shared()
            assert isinstance(cloud, Cloud)
            sensed = SensedCloud(1000 * time_us, t_s, cloud.points_m, sensor.name)
            self.clouds = {**dict(list(self.clouds.items())[1 - CLOUDS_KEPT :]), time_us: sensed}
            return self._intake.on_lidar(sensed)
        return []

    def level_cloud(self, t_s: float, base_in_odom: Pose) -> LevelCloud | None:
        """Return the cloud of one of the last scans, for SLAM; None: the lidar has none."""
        cloud = self.clouds.get(round(1e6 * t_s))
        if cloud is None:
            return None
        roll_rad, pitch_rad, _ = rpy_from_quaternion(base_in_odom.orientation_xyzw)
        return LevelCloud.of(cloud.points, self._mount_of(cloud.frame), (roll_rad, pitch_rad))

    def _mount_of(self, frame: str) -> tuple[Vector3, Quaternion]:
        mount = self._mounts[frame]
        return mount.position_m, mount.orientation_xyzw

    def _sensed(self, time_us: int, ranges: np.ndarray) -> SensedScan:
        lidar = self._lidar
        angles, limits = (lidar.angle_min, lidar.angle_increment), (lidar.range_min, lidar.range_max)
        return SensedScan(1000 * time_us, 1e-6 * time_us, ranges, angles, limits, _LIDAR_FRAME)

    def _watch_bridge(self, is_dead: bool) -> None:
        if self._bridge_is_dead and not is_dead:
            self._vision.reset()
        self._bridge_is_dead = is_dead

    def _inertial(self, t_s: float) -> InertialReading:
        estimate = self._px4.estimate[0]
        return InertialReading(
            t_s,
            attitude_to_enu(estimate["attitude"].tolist()),
            *felt_by(self._px4),
        )

    def _estimated(self, time_us: int, estimate: OdometryEstimate) -> Estimated:
        self.estimates.append(estimate)
        if not self._bridge_is_dead:
            self._tell_px4(time_us, estimate)
        pose = Pose(estimate.position_xyz, quaternion_from_rpy(*estimate.roll_pitch_yaw))
        return Estimated(time_us, OdometrySample(pose, estimate.velocity_xyz, estimate.rates_rad_s))

    def _tell_px4(self, time_us: int, estimate: OdometryEstimate) -> None:
        motion = Motion(
            1000 * time_us,
            estimate.position_xyz,
            quaternion_from_rpy(*estimate.roll_pitch_yaw),
            estimate.velocity_xyz,
            estimate.rates_rad_s,
            estimate.matched_covariance.ravel().tolist(),
            estimate.velocity_covariance.ravel().tolist(),
        )
        for sent in self._vision.update(motion, motion.stamp_s):
            self.told_us = time_us
            x, y, z, yaw = (sent.pose_covariance[i] for i in (0, 7, 14, 35))
            self._px4.offer_external_vision(
                ExternalVision(
                    sent.stamp_ns // 1000,
                    position_m=enu_to_ned(sent.position_m),
                    attitude=attitude_to_ned(sent.orientation_xyzw),
                    position_variance_m2=(y, x, z),
                    yaw_variance_rad2=yaw,
                )
            )
