"""Where a UAV is in `odom`, in space: by its lidar's clouds, its IMU and its range finder.

Each cloud is matched with a map of planes, from the pose that the IMU and the speed predict. The map keeps
all places, so a UAV that comes back finds the surfaces that it saw first. A level lidar with few rings hardly
sees floor and deck. So the height comes from the range finder, too.

References: see `matching`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Sequence

import numpy as np

from gridslam.cloud_odometry.levelling import Levelling
from gridslam.cloud_odometry.matching import CloudMatch, PoseInSpace, match
from gridslam.cloud_odometry.parameters import CloudOdometryParameters
from gridslam.cloud_odometry.plane_map import PlaneMap, thinned
from gridslam.cloud_odometry.rotations import matrix_of, vector_of
from gridslam.errors import ScanError
from gridslam.inputs.attitude import matrix_of_lean, matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.odometry.body_sensors import LEVEL, BodySensedOdometry
from gridslam.odometry.inertial import Lean
from gridslam.odometry.lidar_odometry import LOST_S, UNKNOWN_M2, OdometryEstimate
from gridslam.odometry.parameters import LidarOdometryParameters

SILENT_LEAN_RAD = 0.1
"""Standard deviation of roll and pitch if the IMU is silent."""
SILENT_TURN = 5.0
"""rad/s/sqrt(s): white noise of the turn's acceleration then. The turn goes on as from the cloud before."""
HEIGHT_SIGMA_M = 0.01
"""Least standard deviation of the predicted height."""
FREE_HEIGHT_M = 0.1
"""Standard deviation of the predicted height while a cloud is matched: so floor and deck are found, also if
the range finder has misled the height."""
LEVEL_SLOPE = 0.05
"""m per m: a floor whose plane in the map rises by less is level."""
SLOPE_UNKNOWN_S = 1.0
"""So long after the map has told a slope it still counts, where the map has no floor below."""
RANGE_SIGMA_M = 0.03
"""Standard deviation of the end of a range, if it is one more point of the cloud."""
POINTS_MIN = 20
"""Fewer points are no cloud."""
FIRST_HEIGHT_S = 1.0
"""The map begins so long after the first cloud at most, if the range finder has told no height until then."""
FIRST_VARIANCE = 1e-6
"""Of place (m2) and turn (rad2) where the map begins."""
PLACE, TURN = slice(0, 3), slice(3, 6)


class CloudOdometry(BodySensedOdometry):
    """Feed it the IMU's readings and the ranges as they come, then each cloud.

    Args:
        parameters: see there.
        start: x, y in m and yaw in rad of the base in `odom` at the first cloud.
        say: is called with a sentence when odometry begins anew.
    """

    def __init__(
        self,
        parameters: CloudOdometryParameters | None = None,
        start: Sequence[float] = (0.0, 0.0, 0.0),
        say: Callable[[str], None] = lambda words: None,
    ) -> None:
        self._p = parameters or CloudOdometryParameters()
        super().__init__(LidarOdometryParameters(), start, say)

    def reset(self) -> None:
        """Begin anew at the start."""
        super().reset()
        self.planes = PlaneMap(self._p)
        self._levelling = Levelling(self._p.level_time_s)
        x, y, yaw = self._start.tolist()
        self._pose = PoseInSpace(np.array((x, y, 0.0)), matrix_of((0.0, 0.0, yaw)))
        self._velocity, self._velocity_covariance = np.zeros(3), 0.01 * np.eye(3)
        self._rates = np.zeros(3)
        """(3,) rad/s in the base frame, from the cloud before to the last one that matched."""
        self._covariance = FIRST_VARIANCE * np.eye(6)
        self._map_covariance = np.zeros((6, 6))  # of the place where the map began, in `odom`
        self._keyframe: PoseInSpace | None = None
        self._untold = np.zeros((0, 3))
        self._lidar_m = np.zeros(3)
        """Of the lidar in the base frame, when it gave the newest cloud."""
        self._way_m = 0.0
        self._slope_s = -math.inf  # when the map has told the floor's slope
        self._slope, self._floor = np.zeros(2), np.zeros(3)  # that slope, and the end of the range below

    def on_cloud(
        self, stamp_s: float, points: np.ndarray, lidar_in_base: tuple[Sequence[float], Sequence[float]]
    ) -> OdometryEstimate:
        """Take a cloud and return the estimate at its stamp.

        Args:
            stamp_s: its time. All points count as seen then.
            points: (n, 3) m, in the lidar's frame. Those that are not finite do not count.
            lidar_in_base: (xyz, quaternion xyzw) of the lidar's frame in the base frame.

        Raises:
            ScanError: the cloud makes no sense, or is not newer than the last one.
        """
        self._check(stamp_s, points)
        self._began_s = stamp_s if self._began_s is None else self._began_s
        remarks: list[str] = []
        lean = self._inertial.lean_at(stamp_s)
        if lean is None:
            remarks.append("The IMU is silent, so the attitude comes from the clouds alone.")
        in_base, self._lidar_m = self._in_base(points, lidar_in_base), np.array(lidar_in_base[0], float)
        before = self._pose
        predicted = self._predict(stamp_s, lean)
        self._follow_slope(stamp_s, predicted)
        found = self._match(stamp_s, in_base, predicted, remarks)
        self._move(stamp_s, found, predicted)
        if found and lean and self._stamp_s is not None:
            self._level_map(lean, stamp_s - self._stamp_s)
        step_m = float(np.linalg.norm(self._pose.place - before.place))
        self._way_m += step_m
        self.height.on_way(step_m)
        self._stamp_s = stamp_s
        if len(in_base) >= POINTS_MIN and self._is_keyframe_due(stamp_s, found):
            self._add_keyframe(stamp_s, in_base)
        if self.planes.is_full:
            remarks.append("The map of planes is full: raise voxels_max to map more.")
        return self._estimate(
            stamp_s, lean or LEVEL, found.near / found.points if found else 0.0, " ".join(remarks)
        )

    def _check(self, stamp_s: float, points: np.ndarray) -> None:
        if points.ndim != 2 or points.shape[1] != 3:
            raise ScanError(f"A cloud must be (n, 3) points, not of shape {points.shape}.")
        self._check_stamp(stamp_s, "cloud")

    def _in_base(
        self, points: np.ndarray, lidar_in_base: tuple[Sequence[float], Sequence[float]]
    ) -> np.ndarray:
        used = points[(np.square(points).sum(axis=1) <= self._p.range_m**2)]  # NaN is not
        kept = thinned(np.ascontiguousarray(used, dtype=float), self._p.kept_m)
        return kept @ matrix_of_quaternion(lidar_in_base[1]).T + np.asarray(lidar_in_base[0])

    def _predict(self, stamp_s: float, lean: Lean | None) -> PoseInSpace:
        """Return the pose by the speed, the gyroscope and the IMU's lean. The covariance grows."""
        dt_s = 0.0 if self._stamp_s is None else stamp_s - self._stamp_s
        rotation, place = self._pose.rotation, self._pose.place
        if lean is None:
            rotation = rotation @ matrix_of(dt_s * self._rates)
            self._covariance[TURN, TURN] += SILENT_TURN**2 * dt_s**3 * np.eye(3)
        roll, pitch, yaw = roll_pitch_yaw_of(rotation)
        if lean is not None:
            roll, pitch = lean.roll_rad, lean.pitch_rad
        if self._stamp_s is not None:
            if lean is not None:
                yaw += self._inertial.motion(self._stamp_s, stamp_s).turn_rad
            self._velocity -= (1.0 - math.exp(-dt_s / self._p.rest_time_s)) * (
                self._untold.T @ (self._untold @ self._velocity)
            )
            place = place + dt_s * self._velocity
            self._covariance[PLACE, PLACE] += self._p.speed_noise**2 * dt_s**3 * np.eye(3)
            self._covariance[5, 5] += self._p.turn_noise**2 * dt_s
        if self._is_by_range(stamp_s):
            height_m, climb, variance_m2 = self.height.at(stamp_s)
            place = np.array((*place[:2], height_m + self.height.map_m))
            place[2] -= self._levelling.rise_m(place)
            self._velocity[2] = climb
            self._covariance[2, :] = self._covariance[:, 2] = 0.0
            self._covariance[2, 2] = max(variance_m2, HEIGHT_SIGMA_M**2)
        sigma = self._p.lean_noise_rad if lean else SILENT_LEAN_RAD
        self._covariance[3:5, :] = self._covariance[:, 3:5] = 0.0
        self._covariance[3, 3] = self._covariance[4, 4] = sigma**2
        rotation = _attitude(roll, pitch, yaw)
        return PoseInSpace(place, self._levelling.rotation.T @ rotation if lean else rotation)

    def _level_map(self, lean: Lean, dt_s: float) -> None:
        """Learn from a match how the map leans."""
        matched = self._pose.rotation
        _, _, yaw = roll_pitch_yaw_of(self._levelling.rotation @ matched)
        self._levelling.learn(_attitude(lean.roll_rad, lean.pitch_rad, yaw), matched, dt_s)

    def _match(
        self, stamp_s: float, in_base: np.ndarray, predicted: PoseInSpace, remarks: list[str]
    ) -> CloudMatch | None:
        if self.planes.is_empty:
            if len(in_base) < POINTS_MIN:
                remarks.append("The cloud tells no place: nothing has been in range yet.")
            return None
        points, weights = self._weighed(in_base)
        prior, freed = np.linalg.inv(self._covariance), self._covariance.copy()
        freed[2, 2] = max(freed[2, 2], FREE_HEIGHT_M**2)
        found = match(self.planes, points, weights, self._lidar_m, predicted, np.linalg.inv(freed), self._p)
        if (
            found.found < POINTS_MIN
            or found.agreement < self._p.agreement_min
            or not np.isfinite(found.pose.place).all()
        ):
            remarks.append(
                f"The cloud does not match: {found.near} of {found.points} points lie on the map's planes."
            )
            if stamp_s - self._matched_s > LOST_S and len(in_base) >= POINTS_MIN:
                self._say("No cloud has matched for 2 s; the map begins anew at the predicted place.")
                self.planes = PlaneMap(self._p)
                self._map_covariance += self._covariance
            return None
        self._covariance = np.linalg.inv(found.information + prior)
        rise_m = self._levelling.rise_m(found.pose.place)
        if self._is_by_range(stamp_s):
            height_m, variance_m2 = found.height_alone()
            self.height.on_height(stamp_s, height_m + rise_m, variance_m2)
            x, y, _ = found.pose.place
            z = self.height.at(stamp_s)[0] + self.height.map_m - rise_m
            found = replace(found, pose=PoseInSpace(np.array((x, y, z)), found.pose.rotation))
        else:
            height_m = float(found.pose.place[2]) + rise_m
            self.height.on_height(stamp_s, height_m, float(self._covariance[2, 2]))
        self._matched_s = stamp_s
        untold = found.untold(self._p.told_m)
        if len(untold) > 1 or (len(untold) and abs(untold[0, 2]) < 0.7):
            remarks.append("The cloud tells no place along some direction: its surfaces are parallel to it.")
        self._untold = untold if not self._is_by_range(stamp_s) else _level(untold)
        return found

    def _weighed(self, in_base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the points (n, 3) that are matched and their weights (n,), 1/m2.

        Over a slope the end of the newest range is one of them: walls alone do not tell the height.
        """
        points = thinned(in_base, self._p.thinned_m)
        weights = np.full(len(points), 1.0 / (self._p.points_per_reading * self._p.point_noise_m**2))
        if self.height.is_sloping and self._sensors.below_m is not None:
            points = np.vstack((points, self._sensors.below_m))
            weights = np.append(weights, RANGE_SIGMA_M**-2)
        return points, weights

    def _move(self, stamp_s: float, found: CloudMatch | None, predicted: PoseInSpace) -> None:
        pose = found.pose if found else predicted
        if self._stamp_s is not None:
            dt_s = stamp_s - self._stamp_s
            if found:
                self._velocity = (pose.place - self._pose.place) / dt_s
                self._rates = vector_of(self._pose.rotation.T @ pose.rotation) / dt_s
                if self._is_by_range(stamp_s):
                    self._velocity[2] = self.height.at(stamp_s)[1]
                self._velocity_covariance = 2.0 * self._covariance[PLACE, PLACE] / dt_s**2
            else:
                self._velocity *= math.exp(-dt_s / self._p.rest_time_s)
                self._velocity_covariance = (
                    self._velocity_covariance + self._p.speed_noise** 2 * dt_s * np.eye(3)
                )
        self._pose = pose

    def _follow_slope(self, stamp_s: float, pose: PoseInSpace) -> None:
        """Tell whether the floor below a pose slopes, by the planes. Where none are, it is as before."""
        below_m = self._sensors.below_m
        if below_m is None or not self.height.is_known_at(stamp_s):
            return
        here = pose.place
        floor = here + pose.rotation @ below_m
        slope, is_sloping = self.planes.slope_at(floor, here), self.height.is_sloping
        if slope is not None:
            self._slope, self._slope_s = slope, stamp_s
            is_sloping = bool(np.linalg.norm(slope) > LEVEL_SLOPE)
        elif stamp_s - self._slope_s > SLOPE_UNKNOWN_S:
            is_sloping = False
        rise_m = float(self._slope @ (floor - self._floor)[:2])
        missed_m = float(np.linalg.norm(self._slope)) * self.planes.slopes_late_m
        self.height.on_slope(stamp_s, is_sloping, rise_m, missed_m)
        self._floor = floor

    def _is_by_range(self, stamp_s: float) -> bool:
        """Whether the range finder tells the height: it has counted lately, and the floor below is level."""
        return self.height.is_known_at(stamp_s) and not self.height.is_sloping

    def _is_keyframe_due(self, stamp_s: float, found: CloudMatch | None) -> bool:
        if self._keyframe is None or self.planes.is_empty:
            assert self._began_s is not None  # this cloud, if no other
            return self.height.is_known_at(stamp_s) or stamp_s - self._began_s >= FIRST_HEIGHT_S
        if found is None:
            return False
        change = self._pose.difference(self._keyframe)
        moved_m, turned_rad = np.linalg.norm(change[PLACE]), np.linalg.norm(change[TURN])
        is_new = found.known < self._p.known_min and moved_m > self._p.kept_m
        return bool(is_new or moved_m > self._p.keyframe_m or turned_rad > self._p.keyframe_rad)

    def _add_keyframe(self, stamp_s: float, in_base: np.ndarray) -> None:
        if self._keyframe is None:
            self._covariance = FIRST_VARIANCE * np.eye(6)  # by definition the map begins here
            if not self.height.is_known_at(stamp_s):
                self.height.on_height(stamp_s, float(self._pose.place[2]), FIRST_VARIANCE)
            self._levelling.begin(self._pose.place)
        rotation, place = self._pose.rotation, self._pose.place
        self.planes.add(in_base @ rotation.T + place, rotation @ self._lidar_m + place)
        self._keyframe = self._pose
        self._matched_s = stamp_s

    def _estimate(self, stamp_s: float, lean: Lean, share: float, remark: str) -> OdometryEstimate:
        pose = self._levelling.levelled(self._pose)
        rotation = pose.rotation
        covariance = 0.5 * (self._covariance + self._covariance.T)
        if self._keyframe is None and not self.height.is_known_at(stamp_s):
            covariance[2, 2] = max(covariance[2, 2], UNKNOWN_M2)  # the first range may put it elsewhere
        drifted = covariance + self._map_covariance
        drifted[PLACE, PLACE] += self._p.drift**2 * self._way_m * np.eye(3)
        drifted[2, 2] += self.height.floor_variance_m2 + self.height.wrong_m**2
        velocity_covariance = np.zeros((6, 6))
        velocity_covariance[PLACE, PLACE] = rotation.T @ self._velocity_covariance @ rotation
        velocity_covariance[TURN, TURN] = self._p.lean_noise_rad**2 * np.eye(3)
        x, y, z = pose.place.tolist()
        z -= self.height.map_m
        u, v, w = (self._pose.rotation.T @ self._velocity).tolist()
        return OdometryEstimate(
            stamp_s,
            (x, y, z),
            roll_pitch_yaw_of(rotation),
            (u, v, w),
            lean.rates_rad_s,
            drifted,
            covariance,
            velocity_covariance,
            share,
            remark,
        )


def _attitude(roll: float, pitch: float, yaw: float) -> np.ndarray:
    return matrix_of((0.0, 0.0, yaw)) @ matrix_of_lean(roll, pitch)


def _level(directions: np.ndarray) -> np.ndarray:
    """Return unit directions (k, 3) without those that are nearly vertical: the range finder tells these."""
    return directions[np.abs(directions[:, 2]) < 0.7] if len(directions) else directions
