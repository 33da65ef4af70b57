"""Where the map's path has been: from SLAM's poses and odometry to corrections in three dimensions."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.errors import PoseError
from gridslam.volume.clouds import Pose

SOONER_S = 0.2
"""Odometry is known at a path's pose if it was told within this time."""
JUMP_M, JUMP_RAD = 0.5, 0.5
"""If odometry and the path differ by more between two poses of the path, odometry may have jumped."""
EXPLAINED = 0.5
"""A step of odometry was a jump if without it they differ by less than this share."""


class OdometryHistory:
    """The base's level poses in odom, at the clouds: x, y, yaw and z."""

    def __init__(self) -> None:
        self._stamps_s: list[float] = []
        self._poses: list[tuple[float, float, float, float]] = []

    def add(self, stamp_s: float, base_in_odom: Pose) -> None:
        """Take note of a pose; an older one than the last is left out."""
        if not self._stamps_s or stamp_s > self._stamps_s[-1]:
            rotation, (x, y, z) = base_in_odom.rotation, base_in_odom.translation
            yaw = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
            self._stamps_s.append(stamp_s)
            self._poses.append((float(x), float(y), yaw, float(z)))

    @classmethod
    def of(cls, stamps_s: np.ndarray, poses: np.ndarray) -> OdometryHistory:
        """Return the history of stamps (n,) and poses (n, 4); raises ValueError if they make no sense."""
        if poses.shape != (len(stamps_s), 4) or not (np.diff(stamps_s) > 0.0).all():
            raise ValueError("the odometry's history makes no sense")
        if not (np.isfinite(stamps_s).all() and np.isfinite(poses).all()):
            raise ValueError("the odometry's history is not finite")
        history = cls()
        history._stamps_s = stamps_s.tolist()
        history._poses = [(x, y, yaw, z) for x, y, yaw, z in poses.tolist()]
        return history

    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the stamps (n,) and the poses (n, 4)."""
        return np.array(self._stamps_s, float), np.array(self._poses, float).reshape(-1, 4)

    def take_over(self, other: OdometryHistory) -> None:
        """Become another history."""
        self._stamps_s, self._poses = other._stamps_s, other._poses

    def clear(self) -> None:
        """Forget all poses, as after a clock that jumped back."""
        self._stamps_s, self._poses = [], []

    def at(self, stamps_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return which of the stamps (n,) are known, and the poses (k, 4) at these."""
        if len(self._stamps_s) < 2:
            return np.zeros(len(stamps_s), bool), np.zeros((0, 4))
        known_s, poses = np.array(self._stamps_s), np.array(self._poses)
        later = np.clip(np.searchsorted(known_s, stamps_s), 1, len(known_s) - 1)
        ways = np.stack([stamps_s - known_s[later - 1], known_s[later] - stamps_s])
        are_known = np.abs(ways).min(axis=0) <= SOONER_S
        poses[:, 2] = np.unwrap(poses[:, 2])
        wanted_s = stamps_s[are_known]
        return are_known, np.stack([np.interp(wanted_s, known_s, column) for column in poses.T], axis=1)


class PathCorrections:
    """The poses of odom in the map along a path. Between two of its poses, the correction changes evenly.

    If odometry has jumped between them, as when it begins anew, the correction changes with that step alone.

    Args:
        path_stamps_s: (n,) of the path's poses, in order.
        path_poses: (n, 3) x, y and yaw of the base in the map.
        history: of odometry.
        heights_m: (n,) z of the base in the map; None: the path is one in the plane, and odometry tells z.

    Raises:
        PoseError: the path is empty, makes no sense, or odometry is known at none of its poses.
    """

    def __init__(
        self,
        path_stamps_s: np.ndarray,
        path_poses: np.ndarray,
        history: OdometryHistory,
        heights_m: np.ndarray | None = None,
    ):
        is_sound = (
            len(path_stamps_s)
            and np.isfinite(path_poses).all()
            and (heights_m is None or np.isfinite(heights_m).all())
            and (np.diff(path_stamps_s) > 0.0).all()
        )
        if not is_sound:
            raise PoseError(
                "The path is empty, not in the order of time, or not finite; the map stays as it is."
            )
        are_known, base_in_odom = history.at(np.asarray(path_stamps_s, float))
        if not are_known.any():
            raise PoseError(
                "No pose of the path is of a time at which odometry is known; the map stays as it is."
            )
        planar = zip(path_poses[are_known], base_in_odom[:, :3])
        corrections = np.array([se2.compose(pose, se2.inverse(base)) for pose, base in planar])
        corrections[:, 2] = np.unwrap(corrections[:, 2])
        rises_m = np.zeros(len(base_in_odom))
        if heights_m is not None:
            rises_m = heights_m[are_known] - base_in_odom[:, 3]
        stamps_s = np.asarray(path_stamps_s, float)[are_known]
        known = np.column_stack([corrections, rises_m])
        self._jumps_s = _jumps(stamps_s, path_poses[are_known], base_in_odom[:, :3], history)
        after = np.searchsorted(stamps_s, self._jumps_s.mean(axis=1))
        knots_s = np.insert(stamps_s, np.repeat(after, 2), self._jumps_s.ravel())
        around = np.stack([known[after - 1], known[after]], axis=1).reshape(-1, 4)
        self._stamps_s, self._corrections = knots_s, np.insert(known, np.repeat(after, 2), around, axis=0)

    def cover(self, stamp_s: float) -> bool:
        """Return whether a time lies between the first and the last pose of the path, and in no jump."""
        if ((self._jumps_s[:, 0] < stamp_s) & (stamp_s < self._jumps_s[:, 1])).any():
            return False
        return bool(self._stamps_s[0] <= stamp_s <= self._stamps_s[-1])

    def at(self, stamp_s: float) -> Pose:
        """Return the pose of odom in the map at a time; before and after the path, that of its end."""
        return Pose.level(
            *(float(np.interp(stamp_s, self._stamps_s, column)) for column in self._corrections.T)
        )


def _jumps(
    stamps_s: np.ndarray, path: np.ndarray, base_in_odom: np.ndarray, history: OdometryHistory
) -> np.ndarray:
    """Return (j, 2) the stamps of odometry before and after each jump, one between two poses of a path."""
    motion, told = (se2.between(poses[:-1], poses[1:]) for poses in (path, base_in_odom))
    differences, jumps_s = _difference(told, motion), []
    for n in np.flatnonzero(differences > 1.0):
        known_s, poses = history.arrays()
        inside = np.flatnonzero((known_s > stamps_s[n]) & (known_s < stamps_s[n + 1]))
        times_s = np.array([stamps_s[n], *known_s[inside], stamps_s[n + 1]])
        track = np.vstack([base_in_odom[n], poses[inside, :3], base_in_odom[n + 1]])
        steps = se2.between(track[:-1], track[1:])
        jump = int(np.argmax(np.hypot(*steps[:, :2].T) + np.abs(steps[:, 2])))
        steps[jump] = 0.0
        end = np.zeros(3)
        for step in steps:
            end = se2.compose(end, step)
        if _difference(end, motion[n]) < EXPLAINED * differences[n]:
            jumps_s.append(times_s[jump : jump + 2])
    return np.array(jumps_s).reshape(-1, 2)


def _difference(told: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Return by how much motions (..., 3) differ, as shares of `JUMP_M` and `JUMP_RAD`."""
    off = se2.between(told, motion)
    return np.maximum(np.hypot(off[..., 0], off[..., 1]) / JUMP_M, np.abs(off[..., 2]) / JUMP_RAD)


def odom_in_map(
    path_stamps_s: np.ndarray,
    path_poses: np.ndarray,
    history: OdometryHistory,
    stamps_s: np.ndarray,
    heights_m: np.ndarray | None = None,
) -> list[Pose]:
    """Return the poses of odom in the map at times (k,), after a path; see `PathCorrections`.

    Raises:
        PoseError: the path cannot be used.
    """
    corrections = PathCorrections(path_stamps_s, path_poses, history, heights_m)
    return [corrections.at(stamp_s) for stamp_s in stamps_s.tolist()]
