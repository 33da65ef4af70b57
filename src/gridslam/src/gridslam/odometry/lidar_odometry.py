"""Where a UAV is in `odom`, by its scans, its IMU and its range finder.

Each scan is levelled by the IMU's attitude and matched with a local map of the last keyframes: point to line,
from the place that the IMU predicts. What a scan does not tell (along a bare wall, or with nothing in range)
comes from the prediction alone, whose speed decays; the covariance grows and ``remark`` says so.

References: hector_slam (Kohlbrecher et al. 2011) for SLAM in the plane with a leaning lidar; Censi 2008 for
matching point to line; Zhang, Kaess and Singh 2016 for leaving out what a scan does not tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Sequence

import numpy as np

from gridslam.errors import NoUsableBeamError
from gridslam.inputs.attitude import matrix_of_lean
from gridslam.inputs.scan_projection import LidarPose, project
from gridslam.odometry.body_sensors import LEVEL, BodySensedOdometry
from gridslam.odometry.drift import Drift
from gridslam.odometry.floor_height import SILENT_S
from gridslam.odometry.inertial import Lean, Motion
from gridslam.odometry.local_map import LocalMap, beams_of
from gridslam.odometry.matching import ScanMatch, match
from gridslam.odometry.parameters import LidarOdometryParameters
from gridslam.odometry.planar_filter import PLACE, POSE, SPEED, PlanarFilter
from gridslam.se2 import wrap

LEAN_SIGMA_RAD = 0.01
PLANE = np.ix_((0, 1, 5), (0, 1, 5))
"""x, y and yaw in a covariance of nav_msgs/Odometry."""
UNKNOWN_M2 = 1.0
"""Least variance of a height or a place that nothing has told yet."""
SETTLING_KEYFRAMES, SETTLING_S = 5, 0.4
"""The first keyframes come at this period even at rest, because their mean is better than one scan."""
TURNED_RAD = tuple(sign * 0.1 * step for step in range(1, 7) for sign in (1.0, -1.0))
"""Without the IMU the turn goes on as from the scan before to the last one. If less than ``overlap_min`` of a
scan finds the local map then, the match begins at these turns beside it, too. From rest to 3.4 rad/s within
0.1 s is among them.
"""
BLIND_MATCH_MIN = 0.5
"""Without the IMU a scan counts only if this share of its beams fits. A wrong turn fits less."""
LOST_S = 2.0
"""If no scan has matched for this long, the local map begins anew at the predicted place."""


@dataclass(frozen=True)
class OdometryEstimate:
    """Pose and velocity of the base frame at a scan's stamp."""

    stamp_s: float
    position_xyz: tuple[float, float, float]
    """m, in `odom`."""
    roll_pitch_yaw: tuple[float, float, float]
    """rad."""
    velocity_xyz: tuple[float, float, float]
    """m/s, along the base frame's own axes."""
    rates_rad_s: tuple[float, float, float]
    """About the base frame's own axes."""
    pose_covariance: np.ndarray
    """(6, 6) of x, y, z, roll, pitch, yaw, as nav_msgs/Odometry has it. It grows with the way flown."""
    matched_covariance: np.ndarray
    """(6, 6) the same against the local map. It tells how good the match is, whatever the drift."""
    velocity_covariance: np.ndarray
    """(6, 6) of the velocity and the rates."""
    share: float
    """Of the scan's beams that found the local map."""
    remark: str
    """What the sensors did not tell, in one sentence; empty if all is well."""

    @property
    def height_uncertain_m(self) -> float:
        """Standard deviation of the height, m."""
        return math.sqrt(float(self.pose_covariance[2, 2]))

    @property
    def planar_covariance(self) -> np.ndarray:
        """(3, 3) of x, y and yaw."""
        return self.pose_covariance[PLANE]


class LidarOdometry(BodySensedOdometry):
    """Feed it the IMU's readings and the ranges as they come, then each scan.

    Args:
        parameters: see there.
        start: x, y in m and yaw in rad of the base in `odom` at the first scan.
        say: is called with a sentence when odometry begins anew.
    """

    def __init__(
        self,
        parameters: LidarOdometryParameters | None = None,
        start: Sequence[float] = (0.0, 0.0, 0.0),
        say: Callable[[str], None] = lambda words: None,
    ) -> None:
        self._p = parameters or LidarOdometryParameters()
        super().__init__(self._p, start, say)

    def reset(self) -> None:
        """Begin anew at the start."""
        super().reset()
        self._begin_map()
        self._filter, self._drift = PlanarFilter(self._p, self._start), Drift()
        self._keyframe_s = -math.inf
        self._untold = np.zeros((0, 2))
        self._turn_rate, self._is_blind = 0.0, False
        """rad/s from the scan before to the last one; whether the IMU tells nothing of the turn."""

    def _begin_map(self) -> None:
        self._map = LocalMap(self._p)

    def on_scan(
        self,
        stamp_s: float,
        ranges_m: np.ndarray,
        angles_rad: tuple[float, float],
        limits_m: tuple[float, float],
        lidar_in_base: LidarPose,
        lasts_s: float = 0.0,
    ) -> OdometryEstimate:
        """Take a scan and return the estimate at its stamp.

        Args:
            stamp_s: its time.
            ranges_m: (n,) by REP-117.
            angles_rad: angle of the first beam, and from beam to beam.
            limits_m: least and greatest range of the lidar.
            lidar_in_base: see `project`.
            lasts_s: time from the first beam, which the stamp is of, to the last one.

        Raises:
            ScanError: the scan makes no sense, or is not newer than the last one.
        """
        self._check_stamp(stamp_s, "scan")
        lean, remarks = self._lean(stamp_s)
        moved = self._motion_of(lasts_s, lean)
        beams = self._beams(stamp_s, ranges_m, angles_rad, limits_m, lidar_in_base, lean, remarks, moved)
        place, yaw, before_s = self._filter.state[PLACE].copy(), float(self._filter.state[2]), self._stamp_s
        self._predict(stamp_s)
        share = self._match(stamp_s, beams, remarks)
        if before_s is not None and self._matched_s == stamp_s:
            self._turn_rate = float(wrap(self._filter.state[2] - yaw)) / (stamp_s - before_s)
        self._drift.on_move(self._filter.state[PLACE] - place)
        if self._lacks_height(stamp_s):
            remarks.append("The range finder tells no height.")
        return self._estimate(stamp_s, lean, share, " ".join(remarks))

    def _lacks_height(self, stamp_s: float) -> bool:
        """Whether the range finder is silent. Its first range may come a little after the first scan."""
        self._began_s = stamp_s if self._began_s is None else self._began_s
        return not self.height.is_known_at(stamp_s) and stamp_s - self._began_s >= SILENT_S

    def _lean(self, stamp_s: float) -> tuple[Lean, list[str]]:
        lean = self._inertial.lean_at(stamp_s)
        self._is_blind = lean is None
        if lean is not None:
            return lean, []
        return LEVEL, ["The IMU is silent, so the scan counts as level, and turn and speed as constant."]

    def _motion_of(self, lasts_s: float, lean: Lean) -> tuple[float, float, float] | None:
        """Return x, y in m and yaw in rad by which the base moves from the first beam to the last.

        It goes on as the IMU felt it last, or as from the scan before to the last one.
        """
        if lasts_s <= 0.0 or self._stamp_s is None:
            return None
        yaw, (vx, vy) = float(self._filter.state[2]), self._filter.state[SPEED]
        ahead, left = math.cos(yaw) * vx + math.sin(yaw) * vy, math.cos(yaw) * vy - math.sin(yaw) * vx
        rate = self._turn_rate if self._is_blind else lean.rates_rad_s[2]
        return lasts_s * float(ahead), lasts_s * float(left), lasts_s * rate

    def _beams(
        self,
        stamp_s: float,
        ranges_m: np.ndarray,
        angles_rad: tuple[float, float],
        limits_m: tuple[float, float],
        lidar_in_base: LidarPose,
        lean: Lean,
        remarks: list[str],
        moved: tuple[float, float, float] | None,
    ) -> np.ndarray:
        over_floor_m = None
        if self.height.is_known_at(stamp_s):
            over_floor_m = self.height.at(stamp_s)[0] - self.height.floor_m
        try:
            scan = project(
                ranges_m,
                *angles_rad,
                *limits_m,
                lidar_in_base,
                (lean.roll_rad, lean.pitch_rad),
                over_floor_m,
                stamp_s,
                moved,
            )
        except NoUsableBeamError as error:
            remarks.append(str(error))
            return np.empty((0, 7))
        return beams_of(scan, self._p)

    def _predict(self, stamp_s: float) -> None:
        if self._stamp_s is not None:
            dt_s = stamp_s - self._stamp_s
            motion = self._inertial.motion(self._stamp_s, stamp_s)
            if self._is_blind:
                motion = Motion(self._turn_rate * dt_s, None)
            self._filter.predict(dt_s, motion, self._untold, self._is_blind)
        self._stamp_s = stamp_s

    def _match(self, stamp_s: float, beams: np.ndarray, remarks: list[str]) -> float:
        pose = self._filter.state[POSE]
        if self._map.is_empty:
            self._add_keyframe(stamp_s, beams)
            if len(beams):
                return 1.0
            self._untold = np.eye(2)
            remarks.append("The scan tells no place: nothing has been in range yet.")
            return 0.0
        found = self._best_match(beams, pose.copy())
        least = max(self._p.match_min, BLIND_MATCH_MIN) if self._is_blind else self._p.match_min
        if found.share < least or not np.isfinite(found.pose).all():
            self._untold = np.eye(2)
            share = f"{100 * found.share:.0f} %"
            remarks.append(f"The scan does not match: {share} of its beams find the local map.")
            if stamp_s - self._matched_s > LOST_S and len(beams):
                self._say("No scan has matched for 2 s; the local map begins anew at the predicted place.")
                self._begin_map()
                self._add_keyframe(stamp_s, beams)
            return found.share
        before = self._filter.covariance[POSE, POSE].copy()
        self._filter.correct(found)
        after = self._filter.covariance[POSE, POSE]
        self._drift.on_match(self._untold, before, after)
        self._untold = found.untold
        if len(found.untold) < 2:
            self._matched_s = stamp_s
        if len(found.untold):
            remarks.append(_untold_remark(found, float(pose[2])))
        if self._is_keyframe_due(stamp_s, found.share):
            self._drift.on_keyframe(found, after)
            self._add_keyframe(stamp_s, beams)
        return found.share

    def _best_match(self, beams: np.ndarray, predicted: np.ndarray) -> ScanMatch:
        covariance = self._filter.covariance[POSE, POSE]
        best = match(self._map, beams, predicted.copy(), covariance, self._p)
        if not self._is_blind or best.share >= self._p.overlap_min:
            return best
        for turn_rad in TURNED_RAD:
            start = predicted.copy()
            start[2] += turn_rad
            found = match(self._map, beams, start, covariance, self._p)
            if found.share > best.share and np.isfinite(found.pose).all():
                best = found
        return best

    def _is_keyframe_due(self, stamp_s: float, share: float) -> bool:
        dx, dy, turn = self._filter.state[POSE] - self._map.newest_pose
        return (
            math.hypot(dx, dy) > self._p.keyframe_m
            or abs(math.remainder(turn, math.tau)) > self._p.keyframe_rad
            or (
                stamp_s - self._keyframe_s > SETTLING_S
                and (share < self._p.overlap_min or len(self._map) < SETTLING_KEYFRAMES)
            )
        )

    def _add_keyframe(self, stamp_s: float, beams: np.ndarray) -> None:
        if len(beams):
            self._map.add(self._filter.state[POSE], beams)
            self._keyframe_s = self._matched_s = stamp_s

    def _estimate(self, stamp_s: float, lean: Lean, share: float, remark: str) -> OdometryEstimate:
        x, y, yaw = (float(value) for value in self._filter.state[POSE])
        z, climb, z_variance = self.height.at(stamp_s)
        cos, sin = math.cos(yaw), math.sin(yaw)
        heading = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
        attitude = heading @ matrix_of_lean(lean.roll_rad, lean.pitch_rad)
        velocity = attitude.T @ np.array((*self._filter.state[SPEED], climb))
        if not self.height.is_known_at(stamp_s):
            z_variance = max(z_variance, UNKNOWN_M2)
        matched_covariance = self._matched_covariance(z_variance)
        pose_covariance = matched_covariance.copy()
        pose_covariance[PLANE] += self._drift.covariance
        return OdometryEstimate(
            stamp_s,
            (x, y, z),
            (lean.roll_rad, lean.pitch_rad, yaw),
            tuple(velocity.tolist()),
            lean.rates_rad_s,
            pose_covariance,
            matched_covariance,
            self._velocity_covariance(attitude),
            share,
            remark,
        )

    def _matched_covariance(self, z_variance: float) -> np.ndarray:
        planar = self._filter.covariance
        covariance = np.zeros((6, 6))
        covariance[PLANE] = planar[POSE, POSE]
        covariance[2, 2] = z_variance
        if self._map.is_empty:
            unknown_m2 = np.maximum(np.diag(planar)[PLACE], UNKNOWN_M2)
            covariance[0, 0], covariance[1, 1] = unknown_m2
        covariance[3, 3] = covariance[4, 4] = LEAN_SIGMA_RAD**2
        return covariance

    def _velocity_covariance(self, attitude: np.ndarray) -> np.ndarray:
        """Return (6, 6) along the base frame's axes. attitude (3, 3): of the base frame in `odom`."""
        in_odom = np.zeros((3, 3))
        in_odom[PLACE, PLACE] = self._filter.covariance[SPEED, SPEED]
        in_odom[2, 2] = self.height.climb_variance
        covariance = np.zeros((6, 6))
        covariance[:3, :3] = attitude.T @ in_odom @ attitude
        covariance[3:, 3:] = LEAN_SIGMA_RAD**2 * np.eye(3)
        return covariance


def _untold_remark(found: ScanMatch, yaw_rad: float) -> str:
    if len(found.untold) == 2:
        return "The scan tells no place: too little is in range."
    x, y = found.untold[0]
    degrees = math.degrees(math.remainder(math.atan2(y, x) - yaw_rad, math.pi))
    told = f"the scan tells no place along {degrees:.0f} degrees from ahead."
    return f"Only straight walls are in range: {told}"
