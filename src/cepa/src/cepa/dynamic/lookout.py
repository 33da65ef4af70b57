"""What a UAV with a planar lidar knows of its surroundings: the scan, and what earlier scans have shown."""

from __future__ import annotations

import math
from collections import deque
from copy import copy
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cepa.kernels.field import stamp
from cepa.kernels.memory import MOST_TRUST, knows_near, recall, remember
from cepa.kernels.sight import bins_of, directions_of, fill_blind, points_of, reach_in_sight, was_seen_around
from cepa.motion import Motion, Quaternion, rotation_matrix
from cepa.parameters import CepaParameters
from cepa.scan import Beams

FIELD_WINDOW_M, FIELD_CELL_M = 15.0, 0.1
MEMORY_CELL_M = 0.1
SIGHT_BINS = 360
RANGE_MARGIN_M = 0.4
"""A path ends so far before the lidar's range at the latest: what stands there may not be seen yet."""
SEEN_FREE_M = 0.3
"""A remembered point was seen free when beams end so far beyond it."""
FRAMES, FRAME_PERIOD_S = 20, 0.1
BLIND_STEP_M, BLIND_REACH_M = 0.2, 3.0
OWN_PLACE_M = 0.25
"""The place that the body takes is free, and so much around it where nobody has looked yet."""
BLIND_WAY_M, BLIND_WAY_M_RAD = 0.5, 1.0
"""The UAV may go so far there, and so much farther for each rad that it has turned."""
ELSEWHERE_M = 1.0
"""A UAV that is so far from where it last looked has flown in the open since."""


LEVEL_M, SHOWN_M = 0.7, 1.5
"""A beam farther from the lidar's height may pass over a part of a thing; so far above it, over a wall."""
ANGLES_RAD = 2.0 * math.pi / SIGHT_BINS * np.arange(SIGHT_BINS)
DIRECTIONS = np.stack((np.cos(ANGLES_RAD), np.sin(ANGLES_RAD)))


def falls(rotation: np.ndarray) -> np.ndarray:
    """Return by how much (SIGHT_BINS,) beams fall for each metre in the plane.

    rotation (3, 3): of the lidar's frame into the odometry's.
    """
    return rotation[:2, 2] @ DIRECTIONS / rotation[2, 2]


class Seen:
    """How far a scan sees in SIGHT_BINS equal directions; worked out when it is first asked for."""

    def __init__(self, beams: Beams, orientation_xyzw: Quaternion, range_max: float):
        """Of the lidar: ``orientation_xyzw`` of the lidar's frame in the odometry's."""
        self._beams, self._orientation, self._range_max = beams, orientation_xyzw, range_max

    @cached_property
    def _rotation(self) -> np.ndarray:
        return rotation_matrix(self._orientation)

    @cached_property
    def reach_m(self) -> np.ndarray:
        """(SIGHT_BINS,) m: how far each direction is seen; -1 where no beam looks."""
        beams, reach_m = self._beams, np.empty(SIGHT_BINS)
        geometry = beams.ranges, beams.seen, beams.angle_0, beams.increment, self._rotation
        bins_of(*geometry, self._range_max - RANGE_MARGIN_M, reach_m)
        return reach_m

    @cached_property
    def _falls(self) -> np.ndarray:
        return falls(self._rotation)

    @cached_property
    def level_m(self) -> np.ndarray:
        """(SIGHT_BINS,) m: how far its beams stay within LEVEL_M of the lidar's height."""
        return LEVEL_M / np.maximum(np.abs(self._falls), 1e-6)

    @cached_property
    def shown_m(self) -> np.ndarray:
        """(SIGHT_BINS,) m: how far it shows that nothing stands there; -1 where no beam looks.

        What stands on the floor ends every beam that comes down to it.
        """
        return np.minimum(self.reach_m, SHOWN_M / np.maximum(-self._falls, 1e-6))


class Sight(NamedTuple):
    """What is known at a scan, along the odometry's axes with the lidar at the origin."""

    points: np.ndarray
    """(n, 2) m: ends of the beams."""
    obstacles: np.ndarray
    """(n + m, 2) m: with them, remembered points that the scan cannot see."""
    remembered: np.ndarray
    """(k, 2) m: all remembered points."""
    is_hidden: np.ndarray
    """(k,) bool: which of them are hidden."""
    reach: np.ndarray
    """(SIGHT_BINS,) m: how far the body's centre may go in each direction within what has been seen."""
    blind_way: np.ndarray
    """(2,): see `BlindWay`."""


class BlindWay:
    """The way that the UAV has gone since all that its body takes was last seen.

    Its own place counts as free and goes with it, so that it can set off backwards. A UAV that turns to where
    it flies soon sees. One that does not turn would go on blindly into what stands there. The same would do
    one whose commands alternate between left and right.
    """

    def __init__(self) -> None:
        self._seen_xy = self._last_xy = (math.inf, math.inf)
        self._yaw_rad = 0.0
        self.is_too_long = False

    def follow(self, motion: Motion, is_seen: bool, bins: np.ndarray) -> np.ndarray:
        """Return the direction (2,) of a way that is too long, or 0; see `leads_back`.

        is_seen: whether all that the body takes was seen. bins (n,): how far each direction is seen, below 0
        where no beam looks. A way that leads where a beam looks is never too long.
        """
        here, yaw_rad = motion.position_m[:2], motion.yaw_rad
        if is_seen or math.dist(here, self._last_xy) > ELSEWHERE_M:
            self._seen_xy, self._yaw_rad = here, yaw_rad
        self._last_xy = here
        way = np.subtract(here, self._seen_xy)
        way_m = math.hypot(*way)
        turned_rad = abs(math.remainder(yaw_rad - self._yaw_rad, 2.0 * math.pi))
        ahead = round(math.atan2(way[1], way[0]) / (2.0 * math.pi) * len(bins)) % len(bins)
        is_blind = bins[ahead] < 0.0
        self.is_too_long = bool(is_blind and way_m > BLIND_WAY_M + BLIND_WAY_M_RAD * turned_rad)
        return way / way_m if self.is_too_long else np.zeros(2)


class Lookout:
    """Keeps what scans have shown, fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        p = parameters
        self._p = p
        self.far_m = p.r_ub + FIELD_CELL_M
        """The greatest distance in the field."""
        side = 2 * round(0.5 * FIELD_WINDOW_M / FIELD_CELL_M) + 1
        self._field = np.empty((1, side, side))
        self._memory_m = max(FIELD_WINDOW_M, float(p.window_m))
        cells = round((self._memory_m + 1.0) / MEMORY_CELL_M)
        self._cells_xy = np.empty((cells, cells, 2))
        self._cells_s = np.empty((cells, cells))
        self._cells_trust = np.zeros((cells, cells), np.int64)
        self._frames_xy = np.empty((FRAMES, 2))
        self._frames_bins = np.empty((FRAMES, SIGHT_BINS))
        self._bins = np.empty(SIGHT_BINS)
        self._points = np.empty((0, 3))
        self._geometry, self._directions = (0, 0.0, 0.0), np.empty((0, 2))
        self._recalled = np.empty((cells * cells, 2))
        self._hidden = np.empty(cells * cells, np.bool_)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self._cells_s[:] = -math.inf
        self._waiting: deque[tuple[np.ndarray, Seen, Motion]] = deque()
        self._frames = 0
        self._frame_s = -math.inf
        self._blind_way = BlindWay()

    def take_over(self, earlier: Lookout) -> None:
        """Take over what one with other parameters remembers."""
        earlier._take_in()
        known = np.isfinite(earlier._cells_s)
        xy, cells = earlier._cells_xy[known], len(self._cells_s)
        columns, rows = (np.floor(xy / MEMORY_CELL_M).astype(int) % cells).T
        self._cells_xy[rows, columns], self._cells_s[rows, columns] = xy, earlier._cells_s[known]
        self._cells_trust[rows, columns] = earlier._cells_trust[known]
        self._frames_xy, self._frames_bins = earlier._frames_xy.copy(), earlier._frames_bins.copy()
        self._frames, self._frame_s = earlier._frames, earlier._frame_s
        self._blind_way = earlier._blind_way

    def see(self, beams: Beams, motion: Motion, range_max: float) -> tuple[np.ndarray, Seen]:
        """Return the ends of the beams that hit something (n, 3), m, and how far each direction is seen."""
        geometry = beams.ranges.size, beams.angle_0, beams.increment
        if geometry != self._geometry:
            self._geometry, self._directions = geometry, np.empty((beams.ranges.size, 2))
            directions_of(beams.angle_0, beams.increment, self._directions)
            self._points = np.empty((beams.ranges.size, 3))
        orientation = motion.orientation_xyzw
        seen = Seen(beams, orientation, range_max)
        if beams.nearest >= range_max:
            return self._points[:0], seen
        scan = beams.ranges, beams.seen, self._directions
        found = points_of(*scan, *orientation, range_max, self._points)
        return self._points[:found], seen

    def keep(self, points: np.ndarray, seen: Seen, motion: Motion) -> None:
        """Keep what stands still (n, 2), m, and what `see` found, for the memory.

        It waits until somebody asks for the memory, which nobody does in the open.
        """
        if self._p.memory_s == 0.0 or motion.stamp_s - self._frame_s < FRAME_PERIOD_S - 1e-6:
            return
        self._frame_s = motion.stamp_s
        self._waiting.append((points, seen, motion))
        oldest_s = motion.stamp_s - self._p.memory_s
        if len(self._waiting) > FRAMES and self._waiting[0][2].stamp_s < oldest_s:
            self._waiting.popleft()

    @property
    def _cells(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._cells_xy, self._cells_s, self._cells_trust

    def knows_near(self, way_m: np.ndarray, motion: Motion) -> bool:
        """Return whether anything is remembered within r_UB of the straight way (2,), m, from the UAV."""
        if self._p.memory_s == 0.0:
            return False
        self._take_in()
        (x, y, _), (end_x, end_y) = motion.position_m, way_m.tolist()
        oldest_s = motion.stamp_s - self._p.memory_s
        near = end_x, end_y, x, y, oldest_s, float(self._p.r_ub), MEMORY_CELL_M
        return bool(knows_near(*near, self._cells_xy, self._cells_s))

    def _take_in(self) -> None:
        """Take what waits into the memory."""
        while self._waiting:
            points, seen, motion = self._waiting.popleft()
            x, y, _ = motion.position_m
            remember(points, x, y, motion.stamp_s, MEMORY_CELL_M, *self._cells)
            frame = self._frames % FRAMES
            self._frames_xy[frame] = x, y
            self._frames_bins[frame] = seen.reach_m
            self._frames += 1

    def look(
        self,
        points: np.ndarray,
        seen: Seen,
        motion: Motion,
        forgets: bool = True,
        patience: int = MOST_TRUST,
    ) -> Sight:
        """Return what is known: what stands still (n, 2) in the scan, m, what `see` found, and the memory.

        forgets: what is seen free or too old leaves the memory. Otherwise the look changes nothing. patience:
        so many scans at most may see past a point before it is forgotten.
        """
        self._take_in()
        p, (x, y, _) = self._p, motion.position_m
        bins = self._bins
        bins[:] = seen.reach_m
        oldest_s = motion.stamp_s - p.memory_s
        window = x, y, oldest_s, 0.5 * self._memory_m
        cells = self._cells
        if forgets and p.memory_s > 0.0:
            remember(points, x, y, motion.stamp_s, MEMORY_CELL_M, *cells)
        elif not forgets:
            cells = self._cells_xy, self._cells_s.copy(), self._cells_trust.copy()
        found = recall(*window, bins, SEEN_FREE_M, patience, *cells, self._recalled, self._hidden)
        frames = self._frames_xy, self._frames_bins, min(self._frames, FRAMES)
        is_seen = p.memory_s == 0.0 or was_seen_around(bins, x, y, *frames, float(p.body_radius))
        way = (self._blind_way if forgets else copy(self._blind_way)).follow(motion, is_seen, bins)
        own_place_m = p.body_radius + OWN_PLACE_M
        fill_blind(bins, x, y, *frames, BLIND_STEP_M, BLIND_REACH_M, own_place_m)
        reach = np.empty(SIGHT_BINS)
        reach_in_sight(bins, float(p.body_radius), reach)
        remembered, is_hidden = self._recalled[:found], self._hidden[:found]
        obstacles = np.concatenate((points, remembered[is_hidden]))
        return Sight(points, obstacles, remembered, is_hidden, reach, way)

    @property
    def is_astray(self) -> bool:
        """Whether the UAV had gone too far where nobody has looked, when `look` was last called."""
        return self._blind_way.is_too_long

    def distances(self, sight: Sight) -> np.ndarray:
        """Return the field (1, n, n) of the distance to what is seen or hidden, m; it is overwritten."""
        stamp(sight.obstacles, 0.0, 0.0, self._field[0], FIELD_CELL_M, self.far_m)
        return self._field
