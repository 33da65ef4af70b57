"""Earlier scans that are kept as evidence of what was free."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, NamedTuple, Sequence

import numpy as np

from cepa.dynamic.constants.free_space import RANGE_BINS
from cepa.dynamic.constants.obstacle_tracks import EVIDENCE_PERIOD_S, EVIDENCE_SCANS
from cepa.dynamic.free_space.free_ranges import FreeRanges


class _Held(NamedTuple):
    frame: int
    stamp_s: float
    height_m: float
    sensor_xy: Sequence[float]
    free: FreeRanges


class Frames:
    """A ring of EVIDENCE_SCANS scans, EVIDENCE_PERIOD_S apart."""

    def __init__(self) -> None:
        self.poses = np.zeros((EVIDENCE_SCANS, 3))
        """x, y in m and the turn in rad of each scan."""
        self.planes = np.zeros((EVIDENCE_SCANS, 3))
        """The plane of each scan: the lidar's height in m, and its falls per metre along x and y."""
        self._stamps_s = np.full(EVIDENCE_SCANS, -math.inf)
        self._shown_m = np.full((EVIDENCE_SCANS, RANGE_BINS), -1.0)
        self._unread: dict[int, FreeRanges] = {}
        """Of scans whose ranges nobody has asked for so far."""
        self._next, self._last_s = 0, -math.inf
        self._held: deque[_Held] = deque(maxlen=EVIDENCE_SCANS)

    def is_due(self, stamp_s: float) -> bool:
        """Whether a scan of this stamp is to be kept."""
        return stamp_s - self._last_s >= EVIDENCE_PERIOD_S - 1e-6

    def keep(self, stamp_s: float, height_m: float, pose: np.ndarray, free: FreeRanges) -> int:
        """Keep a scan from a pose (3,) and a height; return its place in the ring."""
        frame = self._take_place(stamp_s)
        self._write(frame, stamp_s, height_m, pose, free)
        return frame

    def hold(self, stamp_s: float, height_m: float, sensor_xy: Sequence[float], free: FreeRanges) -> None:
        """Keep a scan, if it is due, whose pose need not be known before `take_in_held`."""
        if self.is_due(stamp_s):
            self._held.append(_Held(self._take_place(stamp_s), stamp_s, height_m, sensor_xy, free))

    def take_in_held(self, pose_of: Callable[[Sequence[float]], np.ndarray]) -> None:
        """Take in the scans that were held. pose_of: gives the pose (3,) of a lidar at (x, y)."""
        for held in self._held:
            self._write(held.frame, held.stamp_s, held.height_m, pose_of(held.sensor_xy), held.free)
        self._held.clear()

    @property
    def shown_m(self) -> np.ndarray:
        """How far the scans have shown that nothing stands (EVIDENCE_SCANS, RANGE_BINS)."""
        for frame, free in self._unread.items():
            self._shown_m[frame] = free.shown_m
        self._unread.clear()
        return self._shown_m

    def ages_s(self, stamp_s: float) -> np.ndarray:
        """Return the ages (EVIDENCE_SCANS,) at a scan; inf where there is none."""
        return stamp_s - self._stamps_s

    def _take_place(self, stamp_s: float) -> int:
        frame, self._last_s = self._next, stamp_s
        self._next = (frame + 1) % EVIDENCE_SCANS
        return frame

    def _write(self, frame: int, stamp_s: float, height_m: float, pose: np.ndarray, free: FreeRanges) -> None:
        self._stamps_s[frame], self.planes[frame] = stamp_s, plane_of(height_m, free)
        self.poses[frame], self._unread[frame] = pose, free


def plane_of(height_m: float, free: FreeRanges) -> np.ndarray:
    """Return a scan's plane (3,): see `Frames.planes`."""
    return np.array([height_m, *free.slope])
