"""From a scan with the messages that belong to it to a velocity of the body."""

from __future__ import annotations

import dataclasses
import math
import time
from typing import Callable, NamedTuple

from cepa.algorithm import Algorithm
from cepa.decision import Decision, Vector2
from cepa.dynamic.dynamic import Dynamic
from cepa.errors import AttitudeError
from cepa.keep_out import KeepOut
from cepa.levelling import LidarAttitude, levelled
from cepa.motion import DOUBTED, Cloud, Ranging, Vector3
from cepa.scan import LaserScan2D
from cepa.steering.clouds import CloudLimits, SensedPoints
from cepa.steering.height_guard import guarded_climb
from cepa.steering.inertial_check import InertialCheck
from cepa.steering.mount import Mount, in_lidar_frame
from cepa.steering.own_motion import OwnMotion, OwnState, yaw_of
from cepa.steering.self_filter import SelfFilter
from stamp_pairing.pairing import Paired

MAX_AGE_NS = 500_000_000
MAX_AGE_OF_ATTITUDE_NS = 50_000_000
MAX_AGE_OF_CLOUD_NS = 20_000_000
"""A cloud whose stamp is this near to the scan's counts as taken from the same place."""
LONGEST_MISMATCH_NS = 1_000_000_000
MAX_AGE_OF_RANGE_NS = 100_000_000
RANGE_FINDERS = ("range_finder", "range_finder_up")
STANDSTILL: Vector3 = (0.0, 0.0, 0.0)


class Answer(NamedTuple):
    """What the algorithm answered, and what it was asked."""

    velocity_m_s: Vector3
    """Along the body's axes."""
    decision: Decision
    scan: LaserScan2D
    velocities_xy: tuple[Vector2, Vector2]
    """v_ref and v_uav, m/s in the scan's frame."""
    computation_ms: float
    """Wall time; on a busy machine it includes the time in which the thread waited for a core."""
    cpu_ms: float
    """Processor time of the thread."""
    is_mirrored: bool
    """Whether the scan's frame above is that of the lidar after half a turn around its x axis."""


class Answering:
    """Asks the algorithm, and knows what the algorithm needs of odometry.

    warn: takes a sentence whenever something is missing, as often as it is. limits: of the sensor that gives
    clouds; None: there is none. check: compares odometry and IMU; None: there is no IMU.
    """

    def __init__(
        self,
        algorithm: Algorithm,
        warn: Callable[[str], None],
        limits: CloudLimits | None = None,
        check: InertialCheck | None = None,
    ) -> None:
        self._warn = warn
        self._limits, self._check = limits, check
        self._motion = OwnMotion(warn)
        self._self_filter = SelfFilter(warn, lambda: self.algorithm.reset())
        self.algorithm, self._keep_out, self._is_ready = algorithm, KeepOut(), True
        self._last_xy = (0.0, 0.0)
        self._last_scan: tuple[int, float | None] | None = None  # its stamp, and the body's yaw
        self._matched_ns: int | None = None  # when a cloud came with a scan, or the first one came at all

    def take(self, algorithm: Algorithm) -> None:
        """Steer by another algorithm, or by one with other parameters; it keeps what is remembered."""
        if isinstance(algorithm, Dynamic) and isinstance(self.algorithm, Dynamic):
            algorithm.take_over(self.algorithm)
        algorithm.take_keep_out(self._keep_out)
        algorithm.take_ready(self._can_be_held_up)
        self.algorithm = algorithm

    def take_ready(self, is_ready: bool) -> None:
        """Let this algorithm, and those that follow it, know whether the UAV flies what is answered."""
        self._is_ready = is_ready
        self.algorithm.take_ready(self._can_be_held_up)

    @property
    def _can_be_held_up(self) -> bool:
        """Whether a UAV that gets nowhere is held up by what is around it."""
        return self._is_ready and not self._self_filter.obstructs

    def take_keep_out(self, keep_out: KeepOut) -> None:
        """Let this algorithm, and those that follow it, keep out of boxes."""
        self._keep_out = keep_out
        self.algorithm.take_keep_out(keep_out)

    def restart(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        self.algorithm.reset()
        self._motion.restart()
        if self._self_filter.obstructs:
            self.algorithm.take_ready(self._is_ready)
        self._self_filter.restart()
        self._last_xy = (0.0, 0.0)
        self._last_scan = None
        self._matched_ns = None

    def answer(self, paired: Paired, scan: LaserScan2D, mount: Mount) -> Answer:
        """Return the velocity that answers the scan of a lidar with this mounting."""
        v_ref = paired.fresh("reference", MAX_AGE_NS, STANDSTILL)
        is_mirrored = self.algorithm.wants_motion and mount.turn.flipped
        if is_mirrored:  # the plane of the odometry is not seen from below
            mount, scan = mount.upright(), _mirrored(scan)
        reference_xy = mount.turn.undo(*v_ref[:2])
        started_s, cpu_started_s = time.perf_counter(), time.thread_time()
        motion = None
        if self.algorithm.wants_motion:
            doubt = self._check.doubt_at(paired.leader.stamp_ns) if self._check else DOUBTED
            motion, goes_on = self._motion.at(paired, mount, v_ref[2], doubt)
            if not goes_on:
                self.algorithm.reset()
        own: OwnState | None = paired.fresh("odometry", MAX_AGE_NS, None)
        scan = self._without_own(paired, scan, mount, own)
        own_xy = mount.turn.undo(*self._own_velocity(own, trusted=motion is not None)[:2])
        if self.algorithm.parameters.levelling:
            scan = self._levelled(scan, paired, mount, math.hypot(*own_xy))
        rangings = self._ranges(paired)
        self.algorithm.take_ranges(in_lidar_frame(rangings, mount))
        self._tell_of_last_scan(paired, mount)
        decision = self.algorithm.steer(scan, reference_xy, own_xy, motion, self._cloud(paired, mount))
        cpu_ms = 1e3 * (time.thread_time() - cpu_started_s)
        computation_ms = 1e3 * (time.perf_counter() - started_s)
        for sentence in decision.warnings:
            self._warn(sentence)
        self._last_xy = mount.turn.apply(*decision.velocity_xy)
        climb = decision.climb_m_s
        if climb is None:
            climb = guarded_climb(v_ref[2], rangings, self.algorithm.parameters, self._warn)
        velocity = (*self._last_xy, climb)
        asked = scan, (reference_xy, own_xy)
        return Answer(velocity, decision, *asked, computation_ms, cpu_ms, is_mirrored)

    def _without_own(
        self, paired: Paired, scan: LaserScan2D, mount: Mount, own: OwnState | None
    ) -> LaserScan2D:
        """Return the scan without returns of the UAV itself, if these are to be left out."""
        could_be_held_up = self._can_be_held_up
        self._self_filter.move(own, self.algorithm.parameters)
        scan = self._self_filter.scan(1e-9 * paired.leader.stamp_ns, scan, mount)
        if self._can_be_held_up is not could_be_held_up:
            self.algorithm.take_ready(self._can_be_held_up)
        return scan

    def _tell_of_last_scan(self, paired: Paired, mount: Mount) -> None:
        """Tell the algorithm how long ago the last scan was, and how far the lidar has turned since."""
        scan_ns, last = paired.leader.stamp_ns, self._last_scan
        yaw_rad = yaw_of(paired.fresh("odometry", MAX_AGE_OF_ATTITUDE_NS, None))
        self._last_scan = scan_ns, yaw_rad
        if last is None:
            return
        last_ns, last_yaw_rad = last
        turn_rad = 0.0  # it turns by some degrees from scan to scan
        if yaw_rad is not None and last_yaw_rad is not None:
            turn_rad = math.remainder(yaw_rad - last_yaw_rad, 2.0 * math.pi)
        self.algorithm.on_next_scan(1e-9 * (scan_ns - last_ns), -turn_rad if mount.turn.flipped else turn_rad)

    def _cloud(self, paired: Paired, mount: Mount) -> Cloud | None:
        """Return the cloud of the scan's instant, if there is one and the algorithm uses it."""
        if self._limits is None or not self.algorithm.wants_cloud:
            return None
        cloud = paired.values["cloud"]
        age_ns = math.inf if cloud is None else abs(paired.leader.stamp_ns - cloud.stamp_ns)
        if cloud is None:
            self._warn("No cloud has come yet; the scan alone counts. Check the topic cloud.")
        elif age_ns <= MAX_AGE_OF_CLOUD_NS or self._matched_ns is None:
            self._matched_ns = paired.leader.stamp_ns
        elif age_ns <= MAX_AGE_NS and paired.leader.stamp_ns - self._matched_ns > LONGEST_MISMATCH_NS:
            self._warn(
                f"Clouds come, but none within {1e-9 * MAX_AGE_OF_CLOUD_NS:.2f} s of a scan (now "
                f"{1e-9 * age_ns:.3f} s): the scan alone counts. Check their stamps."
            )
        if cloud is None or cloud.value is None or age_ns > MAX_AGE_OF_CLOUD_NS:
            return None
        sensed: SensedPoints = cloud.value
        points, own = sensed.seen_from(mount), None
        if self._limits.looks_all_around:
            points, own = self._self_filter.cloud(1e-9 * paired.leader.stamp_ns, points, mount)
        return self._limits.cloud(points, own)

    def _ranges(self, paired: Paired) -> list[Ranging]:
        """Return what the range finders measured lately, in the body's frame."""
        sources = [source for source in RANGE_FINDERS if source in paired.values]
        rangings = [paired.fresh(source, MAX_AGE_OF_RANGE_NS, None) for source in sources]
        found = [ranging for ranging in rangings if ranging is not None]
        if sources and not found:
            self._warn("No range of a range finder is near to the scan in time; check their topics.")
        return found

    def _own_velocity(self, own: OwnState | None, trusted: bool) -> tuple[float, ...]:
        """Return the own velocity; zero if it is not known, or the last command if that counts more."""
        if self.algorithm.wants_motion and not trusted:
            return self._last_xy
        return own.velocity_m_s if own and own.velocity_m_s else STANDSTILL

    def _levelled(self, scan: LaserScan2D, paired: Paired, mount: Mount, own_speed: float) -> LaserScan2D:
        """Return the scan without floor and ceiling; the whole scan if the attitude is not known."""
        state = paired.fresh("odometry", MAX_AGE_OF_ATTITUDE_NS, None)
        if state is None:
            self._warn("No odometry is near to the scan in time; floor and ceiling are obstacles.")
            return scan
        try:
            pose = state.position_m[2], state.orientation_xyzw, mount.position_m, mount.orientation_xyzw
            attitude = LidarAttitude.of_mounted(*pose)
        except AttitudeError as error:
            self._warn(f"{error} Floor and ceiling are obstacles.")
            return scan
        return levelled(scan, attitude, self.algorithm.parameters, own_speed)


def _mirrored(scan: LaserScan2D) -> LaserScan2D:
    """Return the scan of a lidar that is upside down, as seen from above."""
    return dataclasses.replace(scan, angle_min=-scan.angle_min, angle_increment=-scan.angle_increment)
