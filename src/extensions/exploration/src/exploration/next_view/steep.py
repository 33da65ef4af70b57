"""Straight up and straight down, where a level lidar does not look: steps that only range finders see."""

from __future__ import annotations

import math
from collections import Counter
from typing import Callable

import numpy as np
from scipy.spatial import cKDTree

from exploration.next_view.roadmap import Roadmap
from exploration.next_view.unknown_room import unknown_room
from exploration.planning import PathPlanner
from exploration.planning.if_free import clearances_if_free
from exploration.planning.space import Space
from exploration.planning.voxel_grid import FREE

FAR_M = 1.0
"""Unknown room counts if it begins so near above or below a place where the UAV may be."""
STEP_M = 0.4
"""The UAV goes so far into it, and looks again."""
TRIES = 3
"""A step is tried so often to about the same place: from below, to look up, and twice to fly it."""
STEPS = 3
"""So many steps to which there is no way are tried at one look: more would take too long."""
BESIDE_M = 0.15
"""A range finder looks up and down so far beside the UAV's middle."""
WIDTH_WORTH = 5.0
"""A metre of width is worth so many metres of way."""


class SteepSteps:
    """Chooses a step, and lets the planner fly what range finders have seen of it: not every CEPA looks up.

    What the UAV does not fly, stays unknown.

    Args:
        planner: knows the map. steps_of: the steps from a place (x, y, z) in a space, as `steep_steps`.
        spacing_m: steps that lead to the same cell of this side are one.
    """

    def __init__(
        self,
        planner: PathPlanner,
        steps_of: Callable[[Space, np.ndarray], np.ndarray],
        spacing_m: float,
    ) -> None:
        self._planner, self._steps_of, self._spacing_m = planner, steps_of, spacing_m
        self._attempts: Counter[tuple[int, ...]] = Counter()
        self._step_m = np.zeros((0, 3))
        self._is_flown = np.zeros(0, bool)

    def note(self, place_m: np.ndarray) -> None:
        """Take a place (x, y, z) where the UAV was."""
        self._is_flown |= np.linalg.norm(self._step_m - place_m, axis=1) < STEP_M / 2

    def settle(self) -> None:
        """End the step: its places where the UAV was not count as unknown again."""
        self._planner.settle(self._is_flown.tolist())
        self._step_m, self._is_flown = np.zeros((0, 3)), np.zeros(0, bool)

    def set_out(self, stamp_s: float, here_m: np.ndarray, plan: Callable[[np.ndarray], bool]) -> bool:
        """Let the UAV set out for a step. Return whether it did, or more are to be tried at the next look.

        plan: sets out for an end (x, y, z); returns whether there is a way.
        """
        for _ in range(STEPS):
            end_m = self.begin(stamp_s, here_m)
            if end_m is None:
                return False
            if plan(end_m):
                return True
            self.settle()
        return True

    def climb(self, column_m: np.ndarray, space: Space) -> np.ndarray:
        """Open a column (k, 3) up to where a range finder has seen; return the end (x, y, z) to fly to."""
        return self._open(column_m[: _seen(column_m, space)], space)

    def _open(self, seen_m: np.ndarray, space: Space) -> np.ndarray:
        self._step_m, self._is_flown = seen_m, np.zeros(len(seen_m), bool)
        self._planner.venture(seen_m, space.clearance_m + space.grid.resolution_m)
        end_m: np.ndarray = seen_m[-1]
        return end_m

    def begin(self, stamp_s: float, here_m: np.ndarray) -> np.ndarray | None:
        """Open the best step that was not tried often; return the end (x, y, z) of what was seen of it.

        That is where it begins, as long as no range finder has looked from there. None: there is no step.
        """
        space = self._planner.space(stamp_s, here_m)
        for step_m in self._steps_of(space, here_m):
            if any(math.dist(step_m[-1], closure.place_m) < closure.radius_m for closure in space.closed):
                continue
            cell = tuple(np.floor(step_m[-1] / self._spacing_m).astype(int).tolist())
            if self._attempts[cell] >= TRIES:
                continue
            self._attempts[cell] += 1
            seen_m = step_m[: _seen(step_m, space)]
            if math.dist(seen_m[-1], here_m) > space.grid.resolution_m:
                return self._open(seen_m, space)
        return None


def _seen(column_m: np.ndarray, space: Space) -> int:
    """Return how many places of a column (k, 3) are surely free in their middle, at least one."""
    reach = math.ceil(BESIDE_M / space.grid.resolution_m)
    for number, place_m in enumerate(column_m):
        z, y, x = np.floor(space.inner(place_m)).astype(int).tolist()
        around = space.grid.kinds[z, max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1]
        if not (around == FREE).any():
            return max(number, 1)
    return len(column_m)


def steep_steps(space: Space, roadmap: Roadmap, least_m3: float) -> np.ndarray:
    """Return (n, k, 3) steps into unknown room above and below, the best first: k places, x, y, z, m.

    A step begins where the UAV may be and a way leads to, and goes straight up or down through what nothing
    occupied is near. Whether it is free must be seen by range finders, before the UAV flies it.

    least_m3: less room for the UAV's centre in one piece does not count.
    """
    squares = clearances_if_free(space, 2 * (math.isqrt(space.need - 1) + 1))
    room = unknown_room(space, squares >= space.need, roadmap.nodes, least_m3)
    found = [_columns(space, squares, room, sign) for sign in (1, -1)]
    bases = np.concatenate([base for base, _ in found])
    signs = np.repeat((1, -1), [len(base) for base, _ in found])
    widths = np.sqrt(np.concatenate([width for _, width in found])) * space.grid.resolution_m
    off, node = cKDTree(roadmap.nodes).query(bases)
    costs = roadmap.ways_m[node] + off * space.grid.resolution_m - WIDTH_WORTH * widths
    order = np.argsort(costs, kind="stable")
    length = max(1, round(STEP_M / space.grid.resolution_m)) + 1
    columns = np.repeat(bases[order, None, :], length, axis=1)
    columns[:, :, 0] += np.arange(length) * signs[order, None]
    return space.grid.centres_m(columns.reshape(-1, 3)).reshape(-1, length, 3)


def _columns(space: Space, squares: np.ndarray, room: np.ndarray, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where columns begin (n, 3), z, y, x, and their least squared clearances, voxels.

    sign: 1: the room is above, -1: below.
    """
    at = np.argwhere(room)
    least = squares[room].astype(np.int64)
    bases, widths = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for _ in range(round(FAR_M / space.grid.resolution_m)):
        at = at - (sign, 0, 0)
        is_inside = (at[:, 0] >= 0) & (at[:, 0] < room.shape[0])
        at, least = at[is_inside], least[is_inside]
        least = np.minimum(least, squares[tuple(at.T)])
        is_open = (least >= space.need) & ~room[tuple(at.T)]
        at, least = at[is_open], least[is_open]
        is_base = space.squares[tuple(at.T)] >= space.need
        bases.append(at[is_base])
        widths.append(least[is_base])
        at, least = at[~is_base], least[~is_base]
    return np.concatenate(bases), np.concatenate(widths)
