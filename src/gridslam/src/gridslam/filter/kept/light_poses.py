"""Poses at processed scans that are not kept, because their places were known. The path stays whole."""

from __future__ import annotations

from array import array
from typing import NamedTuple

import numpy as np

from gridslam import se2
from gridslam.trajectory import Trajectory

COLUMNS = 7


class LightPose(NamedTuple):
    """One of them. It moves with a node of the same place, which loop closure may correct."""

    stamp_s: float
    nodes: int
    """Number of nodes before it."""
    anchor: int
    """The node of its place."""
    x_m: float
    y_m: float
    yaw_rad: float
    """The base in the anchor's frame."""
    climb_m: float
    """How much higher than the anchor; NaN: not known."""


class LightPoses:
    """All of a path: 56 bytes each."""

    def __init__(self) -> None:
        self._numbers = array("d")

    def __len__(self) -> int:
        return len(self._numbers) // COLUMNS

    @property
    def rows(self) -> np.ndarray:
        """(m, 7) a copy of all; the columns are the fields of `LightPose`."""
        return np.array(self._numbers, float).reshape(-1, COLUMNS)

    def add(self, pose: LightPose) -> None:
        """Add a pose, newer than all others."""
        self._numbers.extend(pose)

    def now(self, path: np.ndarray) -> np.ndarray:
        """Return the newest pose (3,) of all, along the nodes' path (k, 3)."""
        if len(self):
            newest = self._numbers[-COLUMNS:]
            if newest[1] == len(path):
                return se2.compose(path[int(newest[2])], newest[3:6])
        return path[-1]

    def merged(self, path: Trajectory) -> Trajectory:
        """Return the nodes' path with these poses in between."""
        if not len(self):
            return path
        rows = self.rows
        anchors = rows[:, 2].astype(int)
        stamps_s = np.concatenate([path.stamps_s, rows[:, 0]])
        poses = np.concatenate([path.poses_in_map, se2.compose(path.poses_in_map[anchors], rows[:, 3:6])])
        order = np.argsort(stamps_s, kind="stable")
        heights_m = path.heights_m
        if heights_m is not None:
            heights_m = np.concatenate([heights_m, heights_m[anchors] + rows[:, 6]])[order]
        return Trajectory(stamps_s[order], poses[order], heights_m)

    def restore(self, rows: np.ndarray, nodes: int) -> None:
        """Go on from saved rows (m, 7), on a path of so many nodes.

        Raises:
            ValueError: they are none.
        """
        if rows.ndim != 2 or rows.shape[1] != COLUMNS or not np.isfinite(rows[:, :6]).all():
            raise ValueError("the poses in known places are none")
        before, anchors = rows[:, 1], rows[:, 2]
        if ((anchors < 0) | (anchors >= before) | (before > nodes)).any():
            raise ValueError("the poses in known places are at nodes that are not there")
        self._numbers = array("d", rows.ravel().tolist())
