"""The shortest way out of the window around the UAV, through what is remembered."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.remembered.mouths import Mouths
from cepa.kernels.field import close, favour, stamp, trace, ways_out, widest
from cepa.kernels.layers import best_layers
from cepa.motion import Motion
from cepa.parameters import CepaParameters

CELL_M = 0.25
CLOSED_M = 0.0
"""The way keeps so much more than r_LB. With less than 0, an opening of 2 r_LB + 0.2 m has a cell in it."""
ROUNDS = 8
NO_WAY_M = 10.0
"""Where no way begins, progress counts as if the way were so much longer than from here."""
OWN_CELLS, OWN_SLOWNESS = 2, 3.0
FAVOUR = 0.8
"""A metre along the last way counts so much: of two ways of almost one length the UAV keeps to the first."""
HYSTERESIS_M, STAY_S, STAY_CELLS = 0.04, 3.0, 64
"""What is narrow stays open or closed within so much, for so long. The UAV flies fewer cells in this time."""
GIVEN_UP_UNTIL = 2
"""Column of a cell's state."""
LAYER_PENALTY_1_M = 0.5
"""A metre costs so much more for each metre off the height that is asked for."""
STALL_S, STALL_M, GIVEN_UP_M, NARROW_M = 3.0, 0.5, 2.0, 0.1
"""A UAV that stays within STALL_M for so long gives up what is narrow in the next GIVEN_UP_M of its way."""
PAUSE_S = 0.5
"""A UAV that wants no way for so long hovers: it was not kept from going on."""
AHEAD_M, SLOW_AHEAD = 2.0, 6.0
NARROWER_M, SLOW_NARROW = 0.1, 6.0
"""If there is no other way, openings that leave so much less than r_LB count, and a metre there so much."""
CELLS_AHEAD = 2
"""A way leads away if it is no shorter from so many cells ahead."""
LEADS_BACK_M = 15.0
"""A way so much longer than the straight one leads back."""
END_HORIZONS = 2.0
"""An end counts if the reference leads there within so many of the cost's horizons. A reference that brakes
evenly ends at half the way that its gain tells."""
NO_END = np.full(2, math.inf)


class Layers(NamedTuple):
    """Distances to obstacles in layers of heights, around the UAV."""

    distance: np.ndarray
    """(layers, m, m) m"""
    cell_m: float
    detours_m: np.ndarray
    """(layers,) m: of each from the height that is asked for; inf: it is forbidden."""


class Ways(NamedTuple):
    """The lengths of the shortest ways out."""

    length: np.ndarray
    """(n, n) m: from each cell."""
    offset_x: float
    """m: of the UAV from the grid's middle."""
    offset_y: float
    slowing: float
    """1/s: the reference's speed for each metre that is left; inf: the ways have no end."""


class Course(NamedTuple):
    """Where the reference leads."""

    direction: np.ndarray
    """(2,) unit vector; zeros for a reference of zero."""
    end: np.ndarray = NO_END
    """(2,) m: from the UAV; inf: it is not in sight."""
    slowing: float = math.inf
    """1/s: the reference's speed for each metre to the end."""


def course_of(v_ref: np.ndarray, gain_1_s: float, horizon_s: float) -> tuple[float, Course]:
    """Return the reference's speed, m/s, and where it leads.

    v_ref: (2,) m/s. gain_1_s: how much slower it is for each metre of way, see `Destination`. horizon_s: the
    cost's.
    """
    speed = math.hypot(v_ref[0], v_ref[1])
    if speed == 0.0:
        return speed, Course(np.zeros(2))
    direction = v_ref / speed
    if gain_1_s * END_HORIZONS * horizon_s <= 1.0:
        return speed, Course(direction)
    return speed, Course(direction, v_ref / gain_1_s, gain_1_s)


NO_WAY_SEARCHED = Ways(np.empty((0, 0)), 0.0, 0.0, math.inf)


class WaysOut:
    """Searches again at every call. The grid's cells are fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        side = 2 * round(0.5 * parameters.window_m / CELL_M) + 1
        self._distance = np.empty((side, side))
        self._finer = np.empty((2 * side, 2 * side))
        self._length, self._slowness = np.empty((side, side)), np.empty((side, side))
        self._last = np.empty((8 * side, 2), np.int64)
        self._states = np.empty((side + STAY_CELLS, side + STAY_CELLS, 3))
        self._limits = parameters.r_lb + CLOSED_M + HYSTERESIS_M * np.array([-1.0, 0.0, 1.0])
        self.reset()

    def reset(self) -> None:
        """Forget the last way, and where it led.

        leads_back: whether the newest way is much longer than the straight one. leads_away: whether it does
        not begin towards the reference, or there is none.
        """
        self._last_count = 0
        self._mouths = Mouths()
        self._states[:] = -math.inf
        self._back_until_s = -math.inf
        self._stayed_xy, self._stayed_since_s = (math.inf, math.inf), math.inf
        self._searched_s = -math.inf
        self.leads_back = self.leads_away = False

    def take_over(self, earlier: WaysOut) -> None:
        """Take over the last way, and what was open, from one with a window of the same size."""
        if earlier._states.shape == self._states.shape:
            self._last, self._last_count = earlier._last, earlier._last_count
            self._states, self._back_until_s = earlier._states, earlier._back_until_s
            self._mouths = earlier._mouths
            self._stayed_xy, self._stayed_since_s = earlier._stayed_xy, earlier._stayed_since_s
            self._searched_s = earlier._searched_s
            self.leads_away = earlier.leads_away

    def search(self, obstacles: np.ndarray, course: Course, motion: Motion) -> Ways | None:
        """Return the ways out; None: there is none from here.

        obstacles: (n, 2) m, relative to the UAV. A metre within r_UB counts up to three times, for the UAV
        is slower there. The UAV closes the mouth of a dead end behind itself.
        """
        p, (x_m, y_m, _) = self._p, motion.position_m
        column, row, offset_x, offset_y = self._place(x_m, y_m)
        stamp(obstacles, offset_x, offset_y, self._finer, 0.5 * CELL_M, p.r_ub)
        widest(self._finer, self._distance)
        self._give_up_if_stalled(motion)
        slowness, room = np.empty_like(self._distance), (self._distance, self._limits)
        cushions, place = (float(p.r_lb), float(p.r_ub)), (column, row)
        close(*room, *cushions, *place, motion.stamp_s, STAY_S, self._states, slowness)
        ways = self._out(slowness, course, motion, self._distance)
        if ways is None:
            self._mouths.reset()
            self._states[:, :, GIVEN_UP_UNTIL] = -math.inf
        self.leads_away = ways is None or self._is_longer_ahead(ways.length, course)
        if self.leads_away and ways is not None:
            self._mouths.leave(self._length, self._slowness, (column, row), (x_m, y_m), motion.stamp_s)
        return ways

    @staticmethod
    def _is_longer_ahead(length: np.ndarray, course: Course) -> bool:
        here = len(length) // 2
        if math.hypot(*course.end) < CELLS_AHEAD * CELL_M:
            return False
        column, row = (here + round(CELLS_AHEAD * along) for along in course.direction.tolist())
        return bool(length[row, column] >= length[here, here])

    def _give_up_if_stalled(self, motion: Motion) -> None:
        """Close what is narrow in the way ahead for memory_s if the UAV has got nowhere for long."""
        x_m, y_m, _ = motion.position_m
        paused_s, self._searched_s = motion.stamp_s - self._searched_s, motion.stamp_s
        went_on = math.dist((x_m, y_m), self._stayed_xy) > STALL_M
        if went_on or not 0.0 <= paused_s <= PAUSE_S:
            self._stayed_xy, self._stayed_since_s = (x_m, y_m), motion.stamp_s
        if motion.stamp_s - self._stayed_since_s < STALL_S:
            return
        self._stayed_since_s = motion.stamp_s
        column, row, *_ = self._place(x_m, y_m)
        half, cells = len(self._distance) // 2, len(self._states)
        for way_column, way_row in self._last[: min(self._last_count, round(GIVEN_UP_M / CELL_M))]:
            i, j = way_row - row + half, way_column - column + half
            if self._distance[i, j] < self._p.r_lb + NARROW_M:
                rows, columns = ((k + np.arange(-1, 2)) % cells for k in (way_row, way_column))
                until = np.ix_(rows, columns, [GIVEN_UP_UNTIL])
                self._states[until] = motion.stamp_s + self._p.memory_s

    def search_layers(self, layers: Layers, course: Course, motion: Motion) -> Ways | None:
        """Return the ways out through layers of heights; a column of cells is as open as its best layer."""
        p, (x_m, y_m, _) = self._p, motion.position_m
        _, _, *offset = self._place(x_m, y_m)
        slowness = np.empty_like(self._distance)
        cushions = p.r_lb + CLOSED_M, p.r_lb, p.r_ub
        extra = LAYER_PENALTY_1_M * layers.detours_m
        best_layers(layers.distance, layers.cell_m, extra, *cushions, CELL_M, np.array(offset), slowness)
        ways = self._out(slowness, course, motion)
        self.leads_away = ways is None or self._is_longer_ahead(ways.length, course)
        return ways

    def _out(
        self, slowness: np.ndarray, course: Course, motion: Motion, distance: np.ndarray | None = None
    ) -> Ways | None:
        """Return the ways out where a metre costs ``slowness`` (n, n); inf: closed.

        distance (n, n): m, to what is around. If there is no way, or all ways lead back, narrower openings
        count, too. If they still lead back, what is closed farther ahead than AHEAD_M counts as slow only,
        for the goal may lie before it. When that leads back, too, it counts as closed for memory_s.
        """
        x_m, y_m, _ = motion.position_m
        half_m = CELL_M * (len(slowness) // 2)
        along_x, along_y = course.direction.tolist()
        longest_m = min(half_m * (abs(along_x) + abs(along_y)), math.hypot(*course.end)) + LEADS_BACK_M
        column, row, *_ = self._place(x_m, y_m)
        closed = slowness.copy()
        self._mouths.close(closed, column, row, motion.stamp_s)
        ways = self._ways(closed, course, x_m, y_m)
        self.leads_back = self._length_here(ways) > longest_m
        if not self.leads_back:
            return ways
        known = closed, self._length.copy(), self._last.copy(), self._last_count
        if distance is not None:
            narrow = self._with_narrow(slowness, distance, motion)
            self._mouths.close(narrow, column, row, motion.stamp_s)
            through = self._ways(narrow, course, x_m, y_m)
            if self._length_here(through) <= longest_m:
                self.leads_back = False
                return through
        knows_better = motion.stamp_s < self._back_until_s or self._mouths.are_any(motion.stamp_s)
        if not knows_better or math.isfinite(course.end[0]):
            side = CELL_M * np.arange(len(slowness)) - half_m
            ahead = along_x * side[None, :] + along_y * side[:, None] > AHEAD_M
            soft = np.where(ahead & np.isinf(slowness), SLOW_AHEAD, slowness)
            through = self._ways(soft, course, x_m, y_m)
            if self._length_here(through) <= longest_m:
                self.leads_back = False
                return through
            self._back_until_s = motion.stamp_s + self._p.memory_s
        self._slowness, self._length, self._last, self._last_count = known
        return ways

    def _with_narrow(self, slowness: np.ndarray, distance: np.ndarray, motion: Motion) -> np.ndarray:
        """Return ``slowness`` (n, n) where openings of LEAST_ROOM_M to both sides are passable, but slow."""
        column, row, *_ = self._place(*motion.position_m[:2])
        n, m = len(slowness), len(self._states)
        rows, columns = ((k + np.arange(n) - n // 2) % m for k in (row, column))
        is_given_up = self._states[np.ix_(rows, columns)][:, :, GIVEN_UP_UNTIL] > motion.stamp_s
        least_m = self._p.r_lb - NARROWER_M
        return np.where(np.isinf(slowness) & (distance >= least_m) & ~is_given_up, SLOW_NARROW, slowness)

    @staticmethod
    def _length_here(ways: Ways | None) -> float:
        if ways is None:
            return math.inf
        middle = len(ways.length) // 2
        return float(ways.length[middle, middle])

    @staticmethod
    def _place(x_m: float, y_m: float) -> tuple[int, int, float, float]:
        """Return the column and row that the UAV is in, and its offset from their middle, m."""
        column, row = round(x_m / CELL_M), round(y_m / CELL_M)
        return column, row, x_m - column * CELL_M, y_m - row * CELL_M

    def _ways(self, slowness: np.ndarray, course: Course, x_m: float, y_m: float) -> Ways | None:
        """Return the ways out where a metre costs ``slowness`` (n, n); inf: closed."""
        column, row, offset_x, offset_y = self._place(x_m, y_m)
        favour(self._last[: self._last_count], column, row, FAVOUR, slowness)
        here = len(slowness) // 2
        own = slice(here - OWN_CELLS, here + OWN_CELLS + 1)
        slowness[own, own] = np.minimum(slowness[own, own], OWN_SLOWNESS)  # the UAV is there: it can leave
        end = course.end + np.array((offset_x, offset_y))
        ways_out(slowness, CELL_M, course.direction, end, self._length, ROUNDS)
        self._slowness = slowness
        length = self._length[here, here]
        if math.isinf(length):
            self._last_count = 0
            return None
        self._last_count = trace(self._length, column, row, self._last)
        length_m = np.where(np.isinf(self._length), length + NO_WAY_M, self._length)
        return Ways(length_m, offset_x, offset_y, course.slowing)
