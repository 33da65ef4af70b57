"""Views straight into holes and shafts: where no beam leads from any place, though nothing would stop it."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.kernels.views import mark_seen
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.views.scene import Scene
from exploration.next_view.views.view import View
from exploration.planning.if_free import clearances_if_free
from exploration.planning.space import Space
from exploration.planning.voxel_grid import FREE, OCCUPIED, UNKNOWN

DEEP_M = 1.0
"""A shaft goes on for so long at least where the UAV may not be yet."""
SEEN_M = 4.0
"""And so far where a range finder has seen that it goes on: then the UAV climbs or sinks it at once."""
BESIDE_M = 0.15
"""A range finder looks up and down so far beside the UAV's middle."""
WIDTH_WORTH = 5.0
"""A metre of width is worth so many metres of way."""
TRIES = 3
"""So many looks to about the same place: to fly there, to see it by the range finder, and to fly into it."""
SAME_M = 0.9
"""Ends nearer to each other are about the same: less than what a look leads on."""
SHAFTS = 20
"""So many columns are checked in one decision: the nearest and widest."""


class ShaftViews:
    """Leads straight down, or up, into a shaft that no level view shows.

    The beams of a level lidar enter a hole in the floor by little. Views around it show nothing more,
    however many there are. From above, a range finder sees how far it is free.
    """

    def __init__(self) -> None:
        self._attempts_m: list[np.ndarray] = []
        """Ends (x, y, z) of such views."""

    def note(self, looked: View) -> None:
        """The UAV is at the end of a view into a shaft, or has given it up."""
        if looked.column_m is not None:
            self._attempts_m.append(looked.place_m)

    def best(self, scene: Scene, roadmap: Roadmap) -> View | None:
        """Return the view into the nearest wide shaft; None: there is none."""
        space, deep = scene.space, round(DEEP_M / scene.space.grid.resolution_m)
        found = [_columns(space, roadmap, deep, sign) for sign in (1, -1)]
        columns, ways_m = (np.concatenate([each[part] for each in found]) for part in range(2))
        counts = [self._counts(space, end_m) for end_m in space.grid.centres_m(columns[:, -1])]
        columns, ways_m = columns[counts], ways_m[counts]
        if not len(columns):
            return None
        squares = clearances_if_free(space, 2 * (math.isqrt(space.need - 1) + 1))
        least = squares[tuple(np.moveaxis(columns, -1, 0))].min(axis=1).astype(np.int64)
        costs_m = ways_m - WIDTH_WORTH * np.sqrt(least) * space.grid.resolution_m
        fits = np.flatnonzero(least >= space.need)
        best = fits[np.argsort(costs_m[fits], kind="stable")[:SHAFTS]]
        best = best[~_is_shown(scene, roadmap, columns[best, -1])]
        if not len(best):
            return None
        column = _as_seen(space, squares, columns[best[0]])
        column_m = space.grid.centres_m(column)
        way_m = float(ways_m[best[0]]) + math.dist(column_m[0], column_m[-1])
        return View(column_m[-1], way_m, 0.0, column_m)

    def _counts(self, space: Space, end_m: np.ndarray) -> bool:
        is_closed = any(math.dist(end_m, closure.place_m) < closure.radius_m for closure in space.closed)
        tries = sum(math.dist(end_m, attempt_m) < SAME_M for attempt_m in self._attempts_m)
        return not is_closed and tries < TRIES


def _as_seen(space: Space, squares: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Return a column (k, 3), z, y, x, and what follows as far as a range finder has seen that it is free.

    squares: clearances if all that is unknown were free.
    """
    kinds, reach = space.grid.kinds, math.ceil(BESIDE_M / space.grid.resolution_m)
    sign = int(np.sign(column[-1, 0] - column[0, 0]))
    z, y, x = column[-1].tolist()
    longest = round(SEEN_M / space.grid.resolution_m) + 1
    found = column.tolist()
    while len(found) < longest and 0 <= z + sign < len(kinds):
        z += sign
        middle = kinds[z, max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1]
        if squares[z, y, x] < space.need or not (middle == FREE).any():
            break
        found.append([z, y, x])
    return np.array(found)


def _is_shown(scene: Scene, roadmap: Roadmap, voxels: np.ndarray) -> np.ndarray:
    """Return (n,) whether beams would meet voxels (n, 3) of the map if all that is unknown were free."""
    kinds = np.where(scene.kinds == UNKNOWN, np.uint8(FREE), scene.kinds)
    is_shown = np.zeros(len(voxels), bool)
    mark_seen(kinds, roadmap.nodes + 1, voxels + 1, *scene.sight, is_shown)
    return is_shown


def _columns(space: Space, roadmap: Roadmap, deep: int, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """Return columns above (sign 1) or below (-1) nodes, that lead where the UAV may not be yet.

    They begin at the last place where it may be. Nothing occupied is in their middle.

    Returns:
        (n, deep + 1, 3) z, y, x of their voxels; (n,) ways to there, m.
    """
    nodes = roadmap.ends_of_columns()
    at, ways_m = roadmap.nodes[nodes].copy(), roadmap.ways_m[nodes]
    for _ in range(roadmap.spacing - 1):  # between two nodes it may be, too
        ahead = np.clip(at + np.array((sign, 0, 0)), 0, np.array(space.squares.shape) - 1)
        is_clear = space.squares[tuple(ahead.T)] >= space.need
        at = np.where(is_clear[:, None], ahead, at)
    last = at[:, 0] + sign * deep
    is_inside = (last >= 0) & (last < len(space.squares))
    columns = np.repeat(at[is_inside, None], deep + 1, axis=1)
    columns[:, :, 0] += sign * np.arange(deep + 1)
    inside = tuple(np.moveaxis(columns, -1, 0))
    is_new = (space.squares[inside][:, 1:] < space.need).all(axis=1)
    is_open = (space.grid.kinds[inside] != OCCUPIED).all(axis=1)
    chosen = is_new & is_open
    return columns[chosen], ways_m[is_inside][chosen]
