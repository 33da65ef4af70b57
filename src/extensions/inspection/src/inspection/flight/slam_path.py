"""Photographs' poses follow SLAM's path: when a loop closes, also those that were taken before it move.

SLAM's path has poses of the UAV in the map at the stamps of its scans. With odometry at the same stamps, each
tells where `odom` was in the map. Between two of them that changes evenly. A photograph was recorded with the
`odom` of its time; it moves as far as that has moved since. The map of voxels follows the path in the same
way.
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from flight_basics.geometry import Vector3
from inspection.photographs.record import PhotographRecord

EVERY_S = 0.1
"""So often a pose of odometry is kept. Between two, it changes evenly."""
SOONER_S = 0.2
"""Odometry is known at a pose of the path if it was told within this time."""
MOVED_M, MOVED_RAD = 0.01, math.radians(0.2)
"""A record that would move by less stays as it is."""


class LevelPose(NamedTuple):
    """Of one frame in another: place in m, and a turn about z."""

    place_m: Vector3
    yaw_rad: float


@dataclass(frozen=True, eq=False)
class SlamPath:
    """Of the UAV in the map. stamps_s: (n,), in order. poses: (n, 4) of x, y, z in m and yaw.

    A path whose heights are all 0 is one in the plane, and odometry tells the height.
    """

    stamps_s: np.ndarray
    poses: np.ndarray


class OdometryTrack:
    """Where odometry said that the UAV was. After a clock that was set back it begins anew."""

    def __init__(self) -> None:
        self._stamps_s: list[float] = []
        self._poses: list[tuple[float, float, float, float]] = []

    def note(self, stamp_s: float, pose_in_odom: LevelPose) -> bool:
        """Take a pose. Return whether the track begins anew with it."""
        is_back = bool(self._stamps_s) and stamp_s < self._stamps_s[-1]
        if is_back:
            self._stamps_s, self._poses = [], []
        if not self._stamps_s or stamp_s >= self._stamps_s[-1] + EVERY_S:
            self._stamps_s.append(stamp_s)
            self._poses.append((*pose_in_odom.place_m, pose_in_odom.yaw_rad))
        return is_back

    def at(self, stamps_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return which of the stamps (n,) are known, and the poses (k, 4) of x, y, z and yaw at these."""
        known_s, poses = np.array(self._stamps_s), np.array(self._poses).reshape(-1, 4)
        if len(known_s) < 2:
            return np.zeros(len(stamps_s), bool), np.zeros((0, 4))
        later = np.clip(np.searchsorted(known_s, stamps_s), 1, len(known_s) - 1)
        ways_s = np.stack([stamps_s - known_s[later - 1], known_s[later] - stamps_s])
        are_known = np.abs(ways_s).min(axis=0) <= SOONER_S
        poses[:, 3] = np.unwrap(poses[:, 3])
        wanted_s = stamps_s[are_known]
        return are_known, np.stack([np.interp(wanted_s, known_s, column) for column in poses.T], axis=1)


@dataclass(frozen=True)
class _Followed:
    """A stored photograph. odom_in_map: with which its record was made."""

    record: PhotographRecord
    odom_in_map: LevelPose


class FollowedRecords:
    """The records of the photographs of this flight. Any thread may call."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._track = OdometryTrack()
        self._followed: dict[Path, _Followed] = {}

    def note(self, stamp_s: float, pose_in_odom: LevelPose) -> None:
        """Take a pose of odometry."""
        with self._lock:
            if self._track.note(stamp_s, pose_in_odom):
                self._followed.clear()  # no path tells of stamps of two clocks

    def add(self, path: Path, record: PhotographRecord, odom_in_map: LevelPose) -> None:
        """Take a stored photograph. odom_in_map: with which its record was made."""
        with self._lock:
            self._followed[path] = _Followed(record, odom_in_map)

    def moved(self, slam_path: SlamPath) -> list[tuple[Path, PhotographRecord]]:
        """Return the photographs that are elsewhere by SLAM's path, with their new records.

        One that is not between the path's first and last pose stays where it is.
        """
        with self._lock:
            known_s, moves = corrections(slam_path, self._track)
            moved = []
            for path, followed in self._followed.items():
                record, before = followed.record, followed.odom_in_map
                if not len(known_s) or not known_s[0] <= record.stamp_s <= known_s[-1]:
                    continue
                x, y, z, yaw = (float(np.interp(record.stamp_s, known_s, each)) for each in moves.T)
                now = LevelPose((x, y, before.place_m[2] if np.isnan(z) else z), yaw)
                corrected = moved_record(record, before, now)
                if _is_elsewhere(record, corrected):
                    moved.append((path, corrected))
                    self._followed[path] = _Followed(corrected, now)
            return moved


def corrections(slam_path: SlamPath, track: OdometryTrack) -> tuple[np.ndarray, np.ndarray]:
    """Return the path's stamps (k,) at which odometry is known, and `odom` in the map (k, 4) then.

    Its z is NaN if the path is one in the plane.
    """
    are_known, in_odom = track.at(slam_path.stamps_s)
    in_map = slam_path.poses[are_known]
    yaw = np.unwrap(in_map[:, 3] - in_odom[:, 3])
    cos, sin = np.cos(yaw), np.sin(yaw)
    x = in_map[:, 0] - cos * in_odom[:, 0] + sin * in_odom[:, 1]
    y = in_map[:, 1] - sin * in_odom[:, 0] - cos * in_odom[:, 1]
    is_planar = not slam_path.poses[:, 2].any()
    z = np.full(len(yaw), np.nan) if is_planar else in_map[:, 2] - in_odom[:, 2]
    return slam_path.stamps_s[are_known], np.stack([x, y, z, yaw], axis=1)


def moved_record(record: PhotographRecord, before: LevelPose, now: LevelPose) -> PhotographRecord:
    """Return a record that was made with one pose of `odom` in the map, for another one.

    It keeps the pose that was told first.
    """
    turn = Rotation.from_rotvec((0.0, 0.0, now.yaw_rad - before.yaw_rad))
    x, y, z = (turn.apply(np.subtract(record.position_m, before.place_m)) + now.place_m).tolist()
    qx, qy, qz, qw = (turn * Rotation.from_quat(record.orientation_xyzw)).as_quat().tolist()
    return replace(
        record,
        position_m=(x, y, z),
        orientation_xyzw=(qx, qy, qz, qw),
        told_position_m=record.told_position_m or record.position_m,
        told_orientation_xyzw=record.told_orientation_xyzw or record.orientation_xyzw,
    )


def _is_elsewhere(record: PhotographRecord, corrected: PhotographRecord) -> bool:
    turn = Rotation.from_quat(corrected.orientation_xyzw) * Rotation.from_quat(record.orientation_xyzw).inv()
    return math.dist(record.position_m, corrected.position_m) > MOVED_M or turn.magnitude() > MOVED_RAD
