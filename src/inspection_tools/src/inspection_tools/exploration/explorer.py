"""Next-best-view exploration: the view that shows most of the border of what is known, for its time.

References: Yamauchi 1997 (frontiers); Gonzalez-Banos and Latombe 2002 (information for the way's cost).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from inspection_tools.exploration.frontiers import Frontiers, frontier_voxels, in_cells
from inspection_tools.exploration.kernels.views import seen_from
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.exploration.roadmap import Roadmap
from inspection_tools.planning.space import Space

NEAR, FAR = 1.0, 0.5
"""What a view in vain from the nearer half of the lidar's reach counts, and one from the other half."""
TRIES = 1.0
"""A cell is left after views in vain that count so much."""
SAME = 0.8
"""A cell has not changed if it still has this share of its frontier voxels."""
VIEWS_M = 1.2
"""At first one place in each cube of this side is tried: the one with the most room. In the end, all."""
NODES_VOXELS_MIN = 2


class Why(Enum):
    """Why a part of the border stays unknown."""

    SMALL = "too small to matter"
    IN_VAIN = "looked at, but no beam told what is there"
    NO_BEAM = "no beam of the lidar points there from where the UAV fits"
    NO_ROOM = "no place with enough room for the UAV sees it"


@dataclass(frozen=True)
class Leftover:
    """A part of the border that stays unknown.

    place_m: (x, y, z) in the map's frame. area_m2: of its voxels' faces.
    """

    place_m: tuple[float, float, float]
    area_m2: float
    why: Why


@dataclass(frozen=True)
class Decision:
    """What to do next.

    goal_m: (x, y, z) of the next view in the map's frame; None: nothing is left to see. way_m: to it.
    worth_m2: what it shows of the border. leftovers: what stays unknown, when nothing is left to see.
    is_shut_in: the UAV fits nowhere from where it is, so nothing can be said of what is left.
    """

    goal_m: tuple[float, float, float] | None
    way_m: float = 0.0
    worth_m2: float = 0.0
    leftovers: tuple[Leftover, ...] = ()
    is_shut_in: bool = False


class Explorer:
    """Decides, again and again, which place the UAV flies to.

    Args:
        parameters: see there.
    """

    def __init__(self, parameters: ExplorerParameters | None = None):
        self._p = parameters or ExplorerParameters()
        self._goal_m: np.ndarray | None = None
        self._tried: dict[tuple[int, ...], tuple[int, float]] = {}
        """By cell: its frontier voxels when it was looked at, and what the views in vain count."""

    def decide(self, space: Space, place_m: np.ndarray) -> Decision:
        """Return what to do from a place (x, y, z).

        space: what the planner lets the UAV fly through now.
        """
        resolution_m = space.grid.resolution_m
        side = max(1, round(self._p.cell / resolution_m))
        everything = in_cells(frontier_voxels(space.grid.kinds), side, space.grid.corner[::-1])
        self._note_view(space, place_m, everything, side)
        is_left = self._is_left(space, everything, side)
        cells = Frontiers(everything.places[~is_left], everything.counts[~is_left])
        roadmap = Roadmap(space, place_m, max(NODES_VOXELS_MIN, round(self._p.spacing / resolution_m)))
        reachable = roadmap.reachable
        if not len(reachable):
            self._goal_m = None
            return Decision(None, is_shut_in=True)
        chosen = self._best(space, roadmap, cells, self._views(space, roadmap, reachable))
        if chosen is None:
            chosen = self._best(space, roadmap, cells, reachable)
        if chosen is None:
            self._goal_m = None
            return Decision(
                None, leftovers=self._leftovers(space, roadmap.nodes[reachable], everything, is_left)
            )
        goal, gain = chosen
        self._goal_m = roadmap.place_m(goal)
        x, y, z = self._goal_m.tolist()
        return Decision((x, y, z), float(roadmap.ways_m[goal]), gain * resolution_m**2)

    def _note_view(self, space: Space, place_m: np.ndarray, cells: Frontiers, side: int) -> None:
        """At the goal: count the cells that were looked at in vain."""
        if self._goal_m is None or math.dist(place_m, self._goal_m) > self._p.spacing:
            return
        here, goal = space.grid.index_of(place_m), space.grid.index_of(self._goal_m)
        if here is None or goal is None:
            return
        is_seen = np.zeros(len(cells.counts), bool)
        self._gains(space, np.array((here, goal)), cells, is_seen)
        for number in np.flatnonzero(is_seen):
            one = Frontiers(cells.places[number : number + 1], cells.counts[number : number + 1])
            key, count = self._key(space, one.places[0], side), int(one.counts[0])
            far_m = math.dist(here, one.places[0]) * space.grid.resolution_m
            view = NEAR if far_m <= self._p.reach / 2 else FAR
            before, tries = self._tried.get(key, (count, 0.0))
            self._tried[key] = (count, (tries if count >= SAME * before else 0.0) + view)
        self._goal_m = None

    @staticmethod
    def _key(space: Space, place: np.ndarray, side: int) -> tuple[int, ...]:
        return tuple(((place + space.grid.corner[::-1]) // side).tolist())

    def _is_left(self, space: Space, cells: Frontiers, side: int) -> np.ndarray:
        """Return (m,) whether cells were looked at often enough, and have not changed."""
        is_left = np.zeros(len(cells.counts), bool)
        for number, (place, count) in enumerate(zip(cells.places, cells.counts.tolist())):
            before, tries = self._tried.get(self._key(space, place, side), (0, 0.0))
            is_left[number] = tries >= TRIES and count >= SAME * before
        return is_left

    def _views(self, space: Space, roadmap: Roadmap, reachable: np.ndarray) -> np.ndarray:
        """Return one node of each cube, the one with the most room, and that of the present goal."""
        side = max(1, round(VIEWS_M / space.grid.resolution_m))
        _, cube = np.unique(roadmap.nodes[reachable] // side, axis=0, return_inverse=True)
        order = np.lexsort((-roadmap.clearances[reachable].astype(np.int64), cube.reshape(-1)))
        first = np.concatenate(([True], np.diff(cube.reshape(-1)[order]) > 0))
        return reachable[order[first]]

    def _best(
        self, space: Space, roadmap: Roadmap, cells: Frontiers, nodes: np.ndarray
    ) -> tuple[int, int] | None:
        """Return the node with the most to see a second, and how many voxels it shows.

        None: no view is worth it.
        """
        gains = self._gains(space, roadmap.nodes[nodes], cells, np.zeros(len(cells.counts), bool))
        rates = gains / (roadmap.ways_m[nodes] / self._p.speed + self._p.pause)
        rates[gains * space.grid.resolution_m**2 < self._p.worth_min] = 0.0
        best = int(np.argmax(rates))
        if rates[best] <= 0.0:
            return None
        kept = self._present(roadmap, nodes)
        if kept is not None and rates[kept] > 0.0 and rates[best] < self._p.keep * rates[kept]:
            best = kept
        return int(nodes[best]), int(gains[best])

    def _present(self, roadmap: Roadmap, nodes: np.ndarray) -> int | None:
        if self._goal_m is None:
            return None
        off = np.array([math.dist(roadmap.place_m(node), self._goal_m) for node in nodes])
        nearest = int(np.argmin(off))
        return nearest if off[nearest] < self._p.spacing else None

    def _gains(self, space: Space, places: np.ndarray, cells: Frontiers, is_seen: np.ndarray) -> np.ndarray:
        slopes = math.tan(self._p.elevation_min), math.tan(self._p.elevation_max)
        reaches = (
            self._p.near / space.grid.resolution_m,
            self._p.reach / space.grid.resolution_m,
        )
        gains: np.ndarray = seen_from(space.grid.kinds, places, *cells, slopes, reaches, is_seen)
        return gains

    def _leftovers(
        self, space: Space, places: np.ndarray, cells: Frontiers, is_left: np.ndarray
    ) -> tuple[Leftover, ...]:
        by_beam, in_sight = np.zeros(len(cells.counts), bool), np.zeros(len(cells.counts), bool)
        self._gains(space, places, cells, by_beam)
        reach = 0.0, self._p.reach / space.grid.resolution_m
        seen_from(space.grid.kinds, places, *cells, (-1e9, 1e9), reach, in_sight)
        where = space.grid.centres_m(cells.places)
        areas = cells.counts * space.grid.resolution_m**2
        found = []
        for place, area_m2, left, beam, sight in zip(
            where.tolist(), areas.tolist(), is_left, by_beam, in_sight
        ):
            why = Why.NO_BEAM if sight else Why.NO_ROOM
            if beam:
                why = Why.IN_VAIN if left else Why.SMALL
            found.append(Leftover(tuple(place), area_m2, why))
        return tuple(sorted(found, key=lambda leftover: -leftover.area_m2))
