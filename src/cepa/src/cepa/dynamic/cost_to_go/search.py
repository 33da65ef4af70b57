"""Searches the cost-to-go: the shortest way out of the window around the UAV, through what is remembered."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.cost_to_go import (
    AHEAD_M,
    CELLS_AHEAD,
    CLOSED_M,
    FAVOUR,
    LAYER_PENALTY_1_M,
    LEADS_BACK_M,
    NO_WAY_M,
    OWN_CELLS,
    OWN_SLOWNESS,
    RETURN_NARROW_S,
    ROUNDS,
    SLOW_AHEAD,
    WAY_CELL_M,
)
from cepa.dynamic.cost_to_go.course import Course
from cepa.dynamic.cost_to_go.dead_ends import DeadEnds
from cepa.dynamic.cost_to_go.kernels.slowness import best_layers, favour
from cepa.dynamic.cost_to_go.kernels.sweeping import sweep
from cepa.dynamic.cost_to_go.kernels.ways import shortest_way
from cepa.dynamic.cost_to_go.openings import Openings
from cepa.dynamic.cost_to_go.place import Place, place_of
from cepa.dynamic.cost_to_go.returns import Returns
from cepa.dynamic.cost_to_go.side import ChosenSide
from cepa.dynamic.kernels.distance_field import fill_distances, widest
from cepa.dynamic.kernels.surroundings import CostToGo
from cepa.motion import Motion
from cepa.parameters import CepaParameters

NO_CELLS = np.empty((0, 2), np.int64)


class Layers(NamedTuple):
    """Distances to obstacles in layers of heights, around the UAV."""

    distance: np.ndarray
    """(layers, m, m) m"""
    cell_m: float
    detours_m: np.ndarray
    """(layers,) m: of each from the height that is asked for; inf: it is forbidden."""


class Solution(NamedTuple):
    """The cost-to-go for one slowness of the cells."""

    slowness: np.ndarray
    """(n, n): cost of a metre; inf: closed."""
    length_m: np.ndarray
    """(n, n): of the shortest way out from each cell; inf: there is none."""
    way_cells: np.ndarray
    """(k, 2): column and row of the way's cells from here, among all of the plane; empty: there is none."""

    @property
    def here_m(self) -> float:
        """The length of the way from here; inf: there is none."""
        middle = len(self.length_m) // 2
        return float(self.length_m[middle, middle])


class Found(NamedTuple):
    """What came of a search."""

    cost_to_go: CostToGo | None
    """None: there is no way from here."""
    leads_back: bool
    """Whether the way is much longer than the straight one."""


class CostToGoSearch:
    """Searches again at every call. The grid's cells are fixed to the odometry's frame.

    leads_away: whether the newest way does not begin towards the reference, or there is none.
    """

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self._side = 2 * round(0.5 * parameters.window_m / WAY_CELL_M) + 1
        self._finer, self._distance = np.empty((2 * self._side,) * 2), np.empty((self._side,) * 2)
        self._openings = Openings(parameters, self._side)
        self.reset()

    def reset(self) -> None:
        """Forget the last way, and where it led."""
        self._openings.reset()
        self._dead_ends, self._returns, self._side_kept = DeadEnds(), Returns(), ChosenSide()
        self._way_cells = NO_CELLS
        self._back_until_s = -math.inf
        self.leads_away = False

    def take_over(self, earlier: CostToGoSearch) -> None:
        """Take over the last way, and what was open, from one with a window of the same size."""
        if self._openings.has_same_size(earlier._openings):
            self._openings.take_over(earlier._openings)
            self._dead_ends, self._returns = earlier._dead_ends, earlier._returns
            self._side_kept = earlier._side_kept
            self._way_cells = earlier._way_cells
            self._back_until_s, self.leads_away = earlier._back_until_s, earlier.leads_away

    def search(self, obstacles: np.ndarray, course: Course, motion: Motion) -> Found:
        """Return the cost-to-go around obstacles (n, 2), m, relative to the UAV.

        A metre within r_UB counts up to three times, for the UAV is slower there. The UAV closes dead ends
        behind itself.
        """
        x_m, y_m, _ = motion.position_m
        place, distance = place_of(x_m, y_m), self._distance
        offset, half_cell_m = (place.offset_x_m, place.offset_y_m), 0.5 * WAY_CELL_M
        fill_distances(obstacles, *offset, self._finer, half_cell_m, self._p.r_ub)
        widest(self._finer, distance)
        self._openings.give_up_if_stalled(motion, distance, place, self._way_cells)
        slowness = self._openings.slowness(distance, place, motion.stamp_s)
        course = self._kept_course(slowness, course, place, motion)
        if motion.stamp_s - self._returns.last_s() < RETURN_NARROW_S:
            slowness = self._openings.with_narrow(slowness, distance, place, motion.stamp_s)
        solution, leads_back = self._best(slowness, course, place, motion.stamp_s, distance)
        self._keep(solution, course)
        if not len(solution.way_cells):
            self._dead_ends.reset()
            self._openings.reopen()
        elif self.leads_away:
            cell = place.column, place.row
            self._dead_ends.leave(solution.length_m, solution.slowness, cell, (x_m, y_m), motion.stamp_s)
        return Found(_cost_to_go(solution, course, place), leads_back)

    def search_layers(self, layers: Layers, course: Course, motion: Motion) -> Found:
        """Return the cost-to-go through layers of heights; a column of cells is as open as its best layer."""
        p, place = self._p, place_of(*motion.position_m[:2])
        slowness = np.empty((self._side, self._side))
        cushions = p.r_lb + CLOSED_M, p.r_lb, p.r_ub
        extra, offset = LAYER_PENALTY_1_M * layers.detours_m, np.array([place.offset_x_m, place.offset_y_m])
        best_layers(layers.distance, layers.cell_m, extra, *cushions, WAY_CELL_M, offset, slowness)
        course = self._kept_course(slowness, course, place, motion)
        solution, leads_back = self._best(slowness, course, place, motion.stamp_s)
        self._keep(solution, course)
        return Found(_cost_to_go(solution, course, place), leads_back)

    def fly_clear(self, stamp_s: float) -> None:
        """Take in that the UAV flies the reference, because nothing is in its way."""
        self._returns.fly_clear(stamp_s)

    def returns(self, stamp_s: float) -> int:
        """Return how often the UAV has come back to where it was, lately."""
        return self._returns.number(stamp_s)

    def _kept_course(self, slowness: np.ndarray, course: Course, place: Place, motion: Motion) -> Course:
        """Return the course that ways are searched for: along the side that a UAV which wavered keeps to.

        slowness (n, n): cost of a metre in each cell; inf: closed.
        """
        x_m, y_m, _ = motion.position_m
        if self._returns.meets(motion.stamp_s, x_m, y_m):
            self._side_kept.choose(
                self._returns.number(motion.stamp_s), self._returns.direction(), motion.stamp_s
            )
        if not self._side_kept.is_chosen:
            return course
        closed = self._without_dead_ends(slowness, place, motion.stamp_s)
        return self._side_kept.course(closed, course, motion.stamp_s)

    def _keep(self, solution: Solution, course: Course) -> None:
        """Keep the way for the next search, and whether it leads away."""
        self._way_cells = solution.way_cells
        is_away = self._side_kept.is_chosen or not len(solution.way_cells)
        self.leads_away = is_away or _is_longer_ahead(solution.length_m, course)

    def _best(
        self,
        slowness: np.ndarray,
        course: Course,
        place: Place,
        stamp_s: float,
        distance: np.ndarray | None = None,
    ) -> tuple[Solution, bool]:
        """Return the solution where a metre costs ``slowness`` (n, n), and whether its way leads back.

        distance (n, n): m, to what is around. If there is no way, or all ways lead back, narrower openings
        count, too. If they still lead back, what is closed farther ahead than AHEAD_M counts as slow only,
        for the goal may lie before it. When that leads back, too, it counts as closed for memory_s.
        """
        longest_m = _longest_m(len(slowness), course)
        usual = self._solved(
            self._without_dead_ends(slowness, place, stamp_s), course, place, self._way_cells
        )
        if usual.here_m <= longest_m:
            return usual, False
        tried = usual
        if distance is not None:
            narrow = self._openings.with_narrow(slowness, distance, place, stamp_s)
            narrow = self._without_dead_ends(narrow, place, stamp_s)
            tried = self._solved(narrow, course, place, tried.way_cells)
            if tried.here_m <= longest_m:
                return tried, False
        knows_better = stamp_s < self._back_until_s or self._dead_ends.are_any(stamp_s)
        if not knows_better or math.isfinite(course.end[0]):
            tried = self._solved(_soft_ahead(slowness, course), course, place, tried.way_cells)
            if tried.here_m <= longest_m:
                return tried, False
            self._back_until_s = stamp_s + self._p.memory_s
        return usual, True

    def _without_dead_ends(self, slowness: np.ndarray, place: Place, stamp_s: float) -> np.ndarray:
        """Return ``slowness`` (n, n) where the dead ends that are known are closed."""
        closed = slowness.copy()
        self._dead_ends.close(closed, place.column, place.row, stamp_s)
        return closed

    def _solved(self, slowness: np.ndarray, course: Course, place: Place, favoured: np.ndarray) -> Solution:
        """Return the solution for ``slowness`` (n, n), which is changed: favoured cells (k, 2) cost less."""
        favour(favoured, place.column, place.row, FAVOUR, slowness)
        here = len(slowness) // 2
        own = slice(here - OWN_CELLS, here + OWN_CELLS + 1)
        slowness[own, own] = np.minimum(slowness[own, own], OWN_SLOWNESS)  # the UAV is there: it can leave
        end, length_m = course.end + np.array((place.offset_x_m, place.offset_y_m)), np.empty_like(slowness)
        sweep(slowness, WAY_CELL_M, course.direction, end, length_m, ROUNDS)
        if math.isinf(length_m[here, here]):
            return Solution(slowness, length_m, NO_CELLS)
        cells = np.empty((8 * len(slowness), 2), np.int64)
        return Solution(slowness, length_m, cells[: shortest_way(length_m, place.column, place.row, cells)])


def _cost_to_go(solution: Solution, course: Course, place: Place) -> CostToGo | None:
    """Return what paths are judged by; None: there is no way from here."""
    here_m = solution.here_m
    if math.isinf(here_m):
        return None
    length_m = np.where(np.isinf(solution.length_m), here_m + NO_WAY_M, solution.length_m)
    return CostToGo(length_m[None], WAY_CELL_M, place.offset_x_m, place.offset_y_m, course.slowing)


def _longest_m(cells: int, course: Course) -> float:
    """Return the length from which on a way leads back, m; cells: of the window along an edge."""
    half_m = WAY_CELL_M * (cells // 2)
    along_x, along_y = course.direction.tolist()
    return float(min(half_m * (abs(along_x) + abs(along_y)), math.hypot(*course.end)) + LEADS_BACK_M)


def _soft_ahead(slowness: np.ndarray, course: Course) -> np.ndarray:
    """Return ``slowness`` (n, n) where what is closed farther ahead than AHEAD_M is slow only."""
    along_x, along_y = course.direction.tolist()
    side = WAY_CELL_M * np.arange(len(slowness)) - WAY_CELL_M * (len(slowness) // 2)
    ahead = along_x * side[None, :] + along_y * side[:, None] > AHEAD_M
    return np.where(ahead & np.isinf(slowness), SLOW_AHEAD, slowness)


def _is_longer_ahead(length_m: np.ndarray, course: Course) -> bool:
    """Whether the way out is no shorter from the cells ahead than from here; lengths (n, n)."""
    here = len(length_m) // 2
    if math.hypot(*course.end) < CELLS_AHEAD * WAY_CELL_M:
        return False
    column, row = (here + round(CELLS_AHEAD * along) for along in course.direction.tolist())
    return bool(length_m[row, column] >= length_m[here, here])
