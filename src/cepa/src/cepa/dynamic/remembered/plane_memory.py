"""What planar scans have shown: points of obstacles, and what was free."""

from __future__ import annotations

import math
from collections import deque
from copy import copy
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.distance_fields import FIELD_WINDOW_M
from cepa.dynamic.constants.free_space import (
    EARLIER_PERIOD_S,
    EARLIER_SCANS,
    NEWEST_SCANS,
    OWN_PLACE_M,
    RANGE_BINS,
)
from cepa.dynamic.constants.remembered import MOST_TRUST, POINT_CELL_M, SEEN_PAST_M
from cepa.dynamic.free_space.blind_way import BlindWay
from cepa.dynamic.free_space.earlier_scans import EarlierScans
from cepa.dynamic.free_space.free_ranges import FreeRanges
from cepa.dynamic.free_space.kernels.ranges import reach_in_sight
from cepa.dynamic.remembered.kernels.cells import knows_near, recall, remember
from cepa.motion import Motion
from cepa.parameters import CepaParameters


class RecalledPlane(NamedTuple):
    """What is known at a scan, along the odometry's axes with the lidar at the origin."""

    obstacles: np.ndarray
    """(n + m, 2) m: the ends of the beams, and remembered points that the scan cannot see."""
    remembered: np.ndarray
    """(k, 2) m: all remembered points."""
    is_hidden: np.ndarray
    """(k,) bool: which of them are hidden."""
    reach_m: np.ndarray
    """(RANGE_BINS,) m: how far the body's centre may go in each direction within what has been seen."""
    blind_way: np.ndarray
    """(2,): see `BlindWay`."""


class PlaneMemory:
    """Keeps what scans have shown, fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        p = parameters
        self._p = p
        self._window_m = max(FIELD_WINDOW_M, float(p.window_m))
        cells = round((self._window_m + 1.0) / POINT_CELL_M)
        self._xy = np.empty((cells, cells, 2))
        self._stamps_s = np.empty((cells, cells))
        self._trust = np.zeros((cells, cells), np.int64)
        self._earlier = EarlierScans()
        self._free_m = np.empty(RANGE_BINS)
        self._recalled = np.empty((cells * cells, 2))
        self._hidden = np.empty(cells * cells, np.bool_)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self._stamps_s[:] = -math.inf
        self._waiting: deque[tuple[np.ndarray, FreeRanges, Motion]] = deque()
        self._earlier.reset()
        self._kept_s = -math.inf
        self._blind_way = BlindWay()

    def take_over(self, earlier: PlaneMemory) -> None:
        """Take over what one with other parameters remembers."""
        earlier._take_in()
        known = np.isfinite(earlier._stamps_s)
        xy, cells = earlier._xy[known], len(self._stamps_s)
        columns, rows = (np.floor(xy / POINT_CELL_M).astype(int) % cells).T
        self._xy[rows, columns], self._stamps_s[rows, columns] = xy, earlier._stamps_s[known]
        self._trust[rows, columns] = earlier._trust[known]
        self._earlier.take_over(earlier._earlier)
        self._kept_s = earlier._kept_s
        self._blind_way = earlier._blind_way

    def keep(self, standing: np.ndarray, free: FreeRanges, motion: Motion) -> None:
        """Keep what stands still (n, 3), m, and what a scan sees free.

        It waits until somebody asks for the memory, which nobody does in the open.
        """
        if self._p.memory_s == 0.0 or motion.stamp_s - self._kept_s < EARLIER_PERIOD_S - 1e-6:
            return
        self._kept_s = motion.stamp_s
        self._waiting.append((standing, free, motion))
        oldest_s = motion.stamp_s - self._p.memory_s
        if len(self._waiting) > EARLIER_SCANS and self._waiting[0][2].stamp_s < oldest_s:
            self._waiting.popleft()

    def _take_in(self) -> None:
        """Take what waits into the memory."""
        while self._waiting:
            standing, free, motion = self._waiting.popleft()
            x, y, _ = motion.position_m
            remember(standing, x, y, motion.stamp_s, POINT_CELL_M, *self._cells)
            self._earlier.take_in(x, y, free.free_m)

    @property
    def _cells(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._xy, self._stamps_s, self._trust

    def knows_near(self, way_m: np.ndarray, motion: Motion) -> bool:
        """Return whether anything is remembered within r_UB of the straight way (2,), m, from the UAV."""
        if self._p.memory_s == 0.0:
            return False
        self._take_in()
        (x, y, _), (end_x, end_y) = motion.position_m, way_m.tolist()
        oldest_s = motion.stamp_s - self._p.memory_s
        near = end_x, end_y, x, y, oldest_s, float(self._p.r_ub), POINT_CELL_M
        return bool(knows_near(*near, self._xy, self._stamps_s))

    def recall(
        self,
        standing: np.ndarray,
        free: FreeRanges,
        motion: Motion,
        forgets: bool = True,
        patience: int = MOST_TRUST,
        must_flee: bool = False,
    ) -> RecalledPlane:
        """Return what is known: what stands still (n, 3) in the scan, m, what it sees free, and the memory.

        forgets: what is seen free or too old leaves the memory. Otherwise nothing changes. patience: so many
        scans at most may see past a point before it is forgotten. must_flee: something comes, so older scans
        tell, too, what is free where no beam looks. Otherwise the UAV rather turns and looks again.
        """
        self._take_in()
        p, (x, y, _) = self._p, motion.position_m
        free_m = self._free_m
        free_m[:] = free.free_m
        cells = self._cells
        if forgets and p.memory_s > 0.0:
            remember(standing, x, y, motion.stamp_s, POINT_CELL_M, *cells)
        elif not forgets:
            cells = self._xy, self._stamps_s.copy(), self._trust.copy()
        window = x, y, motion.stamp_s - p.memory_s, 0.5 * self._window_m
        found = recall(*window, free_m, SEEN_PAST_M, patience, *cells, self._recalled, self._hidden)
        remembered, is_hidden = self._recalled[:found], self._hidden[:found]
        obstacles = np.concatenate((standing[:, :2], remembered[is_hidden]))
        scans = EARLIER_SCANS if must_flee else NEWEST_SCANS
        blind_way = self._follow_blind_way(free_m, motion, forgets, scans)
        self._earlier.fill(free_m, x, y, p.body_radius + OWN_PLACE_M, scans)
        reach_m = np.empty(RANGE_BINS)
        reach_in_sight(free_m, float(p.body_radius), reach_m)
        return RecalledPlane(obstacles, remembered, is_hidden, reach_m, blind_way)

    def _follow_blind_way(self, free_m: np.ndarray, motion: Motion, forgets: bool, scans: int) -> np.ndarray:
        """Return the direction (2,) of a way that was gone too far without a look; see `BlindWay`."""
        p, (x, y, _) = self._p, motion.position_m
        radius_m = float(p.body_radius)
        is_seen = p.memory_s == 0.0 or self._earlier.have_seen_around(free_m, x, y, radius_m, scans)
        return (self._blind_way if forgets else copy(self._blind_way)).follow(motion, is_seen, free_m)

    @property
    def is_astray(self) -> bool:
        """Whether the UAV had gone too far where nobody has looked, at the last `recall` that may forget."""
        return self._blind_way.is_too_long
