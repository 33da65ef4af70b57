"""Next-best-view exploration: the view that shows most of the border of what is known, for its time.

References: Yamauchi 1997 (frontiers); Gonzalez-Banos and Latombe 2002 (information for the way's cost).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from inspection_tools.exploration.beyond import is_near_room
from inspection_tools.exploration.frontiers import Frontiers, frontier_voxels, in_cells
from inspection_tools.exploration.kernels.views import best_view, seen_from
from inspection_tools.exploration.leftovers import Leftover, Sight, leftovers_of, with_refused
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.exploration.roadmap import Roadmap
from inspection_tools.exploration.steep import steep_steps
from inspection_tools.planning.space import Space

NEAR, FAR = 1.0, 0.5
"""What a view in vain from the nearer half of the lidar's reach counts, and one from the other half."""
PASSING = 0.25
"""What a view from the way counts, as a share of one from its goal."""
TRIES = 1.0
"""A cell is left after views in vain that count so much."""
SAME = 0.8
"""A cell has not changed if it still has this share of its frontier voxels."""
VIEWS_M = 1.2
"""One place in each cube of this side is tried: the one with the most room. For room itself, then all."""
NODES_VOXELS_MIN = 2
ROOM_CELL = 0.5
"""Side of a cell with the border of room for the UAV, as a share of `cell`: so that no small door is lost."""


@dataclass(frozen=True)
class Decision:
    """What to do next.

    goal_m: (x, y, z) of the next view in the map's frame; None: nothing is left to see. way_m: to it.
    worth_m2: what it shows of the border. leftovers: what stays unknown, when nothing is left to see.
    is_shut_in: the UAV fits nowhere from where it is, so nothing can be said of what is left. column_m:
    (k, 3) the last part of the way, straight up or down through what no beam of the lidar has shown; None:
    there is no such part.
    """

    goal_m: tuple[float, float, float] | None
    way_m: float = 0.0
    worth_m2: float = 0.0
    leftovers: tuple[Leftover, ...] = ()
    is_shut_in: bool = False
    column_m: np.ndarray | None = None


class Explorer:
    """Decides, again and again, which place the UAV flies to.

    Args:
        parameters: see there.
    """

    def __init__(self, parameters: ExplorerParameters | None = None):
        self._p = parameters or ExplorerParameters()
        self._goal_m: np.ndarray | None = None
        self._has_given_up = False
        """Its present goal."""
        self._looked_m: np.ndarray | None = None
        """Where the last view was that counted."""
        self._seeks_room = False
        self._known = 0
        """Voxels of the map when all views were looked at last."""
        self._tried: dict[tuple[float, ...], tuple[int, float]] = {}
        """By cell: its frontier voxels when it was looked at, and what the views in vain count."""

    @property
    def parameters(self) -> ExplorerParameters:
        """As given."""
        return self._p

    def give_up_goal(self) -> None:
        """The UAV comes no nearer to its goal: for the next decision it looks from where it is."""
        self._has_given_up = True

    def decide(self, space: Space, place_m: np.ndarray) -> Decision:
        """Return what to do from a place (x, y, z).

        What shows enough for its time comes first. Then all of the border counts behind which the UAV itself
        might fit. What is left after that is too small to matter, or no view shows it.

        space: what the planner lets the UAV fly through now.
        """
        kinds = np.pad(space.grid.kinds, 1)
        border = frontier_voxels(kinds)
        everything = self._cells(space, border, self._p.cell)
        roadmap = self._roadmap(space, place_m)
        if not len(roadmap.nodes):
            self._goal_m = None
            return Decision(None, is_shut_in=True)
        is_near = self._goal_m is not None and math.dist(place_m, self._goal_m) <= self._p.spacing
        is_there, self._has_given_up = is_near or (self._goal_m is not None and self._has_given_up), False
        views_m, view = self._views_from(place_m, is_there)
        self._note_view(space, kinds, views_m, view, everything, 1.0)
        present_m = None if is_there else self._goal_m
        is_left = self._is_left(space, everything, 1.0)
        seeks_room, has_news = self._seeks_room, self._has_news(space)
        self._seeks_room, chosen = False, None
        if is_there or has_news:
            chosen = self._best(
                space, kinds, roadmap, everything.chosen(~is_left), self._least(space), present_m
            )
        if chosen is None:
            self._seeks_room = True
            near = np.pad(is_near_room(space, roadmap.nodes, self._p.room_min), 1, mode="edge")
            room = self._cells(space, border[near[tuple(border.T)]], ROOM_CELL * self._p.cell)
            if seeks_room:
                self._note_view(space, kinds, views_m, view, room, ROOM_CELL)
            open_room = room.chosen(~self._is_left(space, room, ROOM_CELL))
            chosen = self._best(
                space, kinds, roadmap, open_room, (1.0, 0.0), present_m if seeks_room else None
            )
        if chosen is None:
            self._goal_m = None
            sight = self._sight(space)
            return Decision(
                None, leftovers=leftovers_of(space, kinds, roadmap.nodes, everything, is_left, sight)
            )
        goal, gain = chosen
        self._goal_m = roadmap.place_m(goal)
        x, y, z = self._goal_m.tolist()
        return Decision((x, y, z), float(roadmap.ways_m[goal]), gain * space.grid.resolution_m**2)

    def with_refused(
        self, leftovers: Sequence[Leftover], opened: Space, place_m: np.ndarray
    ) -> tuple[Leftover, ...]:
        """Return leftovers with those named that only closed ways keep unknown.

        opened: the space without what is closed. place_m: (x, y, z) of the UAV.
        """
        nodes = self._roadmap(opened, place_m).nodes
        return with_refused(leftovers, opened, nodes, self._sight(opened)) if len(nodes) else tuple(leftovers)

    def steep_steps(self, space: Space, place_m: np.ndarray) -> np.ndarray:
        """Return (n, k, 3) steps straight up or down from a place (x, y, z) of the UAV; see `steep_steps`.

        Ask when no view shows more. The lidar does not see whether a step is free; range finders do.
        """
        roadmap = self._roadmap(space, place_m)
        return steep_steps(space, roadmap, self._p.room_min) if len(roadmap.nodes) else np.zeros((0, 1, 3))

    def _roadmap(self, space: Space, place_m: np.ndarray) -> Roadmap:
        spacing = self._p.way_spacing or self._p.spacing
        return Roadmap(space, place_m, self._voxels(space, spacing, NODES_VOXELS_MIN))

    def _sight(self, space: Space) -> Sight:
        return Sight(self._slopes, self._reaches(space))

    def _least(self, space: Space) -> tuple[float, float]:
        """Return the voxels, and voxels a second, that a view must show."""
        face_m2 = space.grid.resolution_m**2
        return self._p.worth_min / face_m2, self._p.rate_min / face_m2

    def _has_news(self, space: Space) -> bool:
        """Whether so much is new since a search for room began that a view may be worth its time again."""
        known = int(np.count_nonzero(space.grid.kinds))
        if self._seeks_room and abs(known - self._known) < self._least(space)[0]:
            return False
        self._known = known
        return True

    @staticmethod
    def _voxels(space: Space, length_m: float, least: int = 1) -> int:
        return max(least, round(length_m / space.grid.resolution_m))

    def _cells(self, space: Space, border: np.ndarray, side_m: float) -> Frontiers:
        """Return the cells of a border (n, 3) of the map with a layer around it."""
        return in_cells(border, self._voxels(space, side_m), space.grid.corner[::-1] - 1)

    def _views_from(self, place_m: np.ndarray, is_there: bool) -> tuple[list[np.ndarray], float]:
        """Return the places from which the UAV looks, and what a view counts; none: it has hardly moved."""
        if is_there:
            assert self._goal_m is not None
            self._looked_m = place_m
            return [place_m, self._goal_m], 1.0
        if self._looked_m is not None and math.dist(place_m, self._looked_m) < self._p.spacing:
            return [], 0.0
        self._looked_m = place_m
        return [place_m], PASSING

    def _note_view(
        self,
        space: Space,
        kinds: np.ndarray,
        views_m: list[np.ndarray],
        view: float,
        cells: Frontiers,
        share: float,
    ) -> None:
        """Count the cells that were looked at in vain."""
        indices = [index for index in map(space.grid.index_of, views_m) if index is not None]
        if not indices or not len(cells.counts):
            return
        is_seen = np.zeros(len(cells.counts), bool)
        self._gains(space, kinds, np.array(indices), cells, is_seen)
        for place, count in zip(cells.places[is_seen], cells.counts[is_seen].tolist()):
            key = self._key(space, place, share)
            far_m = math.dist(indices[0], place - 1) * space.grid.resolution_m
            counts = view * (NEAR if far_m <= self._p.reach / 2 else FAR)
            before, tries = self._tried.get(key, (count, 0.0))
            self._tried[key] = (count, (tries if count >= SAME * before else 0.0) + counts)

    def _key(self, space: Space, place: np.ndarray, share: float) -> tuple[float, ...]:
        side = self._voxels(space, share * self._p.cell)
        return (share, *((place + space.grid.corner[::-1] - 1) // side).tolist())

    def _is_left(self, space: Space, cells: Frontiers, share: float) -> np.ndarray:
        """Return (m,) whether cells were looked at often enough, and have not changed."""
        is_left = np.zeros(len(cells.counts), bool)
        for number, (place, count) in enumerate(zip(cells.places, cells.counts.tolist())):
            before, tries = self._tried.get(self._key(space, place, share), (0, 0.0))
            is_left[number] = tries >= TRIES and count >= SAME * before
        return is_left

    def _views(self, space: Space, roadmap: Roadmap) -> np.ndarray:
        """Return one node of each cube: the one with the most room."""
        cubes = roadmap.nodes // self._voxels(space, VIEWS_M)
        size = cubes.max(axis=0) + 1
        cube = (cubes[:, 0] * size[1] + cubes[:, 1]) * size[2] + cubes[:, 2]
        order = np.lexsort((-roadmap.clearances, cube))
        first = np.concatenate(([True], np.diff(cube[order]) > 0))
        return order[first]

    def _best(
        self,
        space: Space,
        kinds: np.ndarray,
        roadmap: Roadmap,
        cells: Frontiers,
        least: tuple[float, float],
        present_m: np.ndarray | None,
    ) -> tuple[int, int] | None:
        """Return the node with the most to see a second, and how many voxels it shows.

        least: voxels, and voxels a second, that a view must show. present_m: the goal that the UAV flies to.
        None: no view shows so much.
        """
        if not len(cells.counts):
            return None
        places = [self._views(space, roadmap)]
        if least[1] == 0.0:  # then no place may be left out
            places.append(np.arange(len(roadmap.nodes)))
        for nodes in places:
            times_s = roadmap.ways_m[nodes] / self._p.speed + self._p.pause
            best, gain = best_view(
                kinds, roadmap.nodes[nodes] + 1, times_s, *cells, self._slopes, self._reaches(space), least
            )
            if best >= 0:
                kept = self._kept(space, kinds, roadmap, cells, gain / times_s[best], present_m)
                return kept or (int(nodes[best]), int(gain))
        return None

    def _kept(
        self,
        space: Space,
        kinds: np.ndarray,
        roadmap: Roadmap,
        cells: Frontiers,
        rate: float,
        present_m: np.ndarray | None,
    ) -> tuple[int, int] | None:
        """Return the node of the present goal, and what it shows, if a rate is not worth the change."""
        if present_m is None:
            return None
        off = np.linalg.norm(space.grid.centres_m(roadmap.nodes) - present_m, axis=1)
        node = int(np.argmin(off))
        if off[node] >= self._p.spacing:
            return None
        is_seen = np.zeros(len(cells.counts), bool)
        gain = int(self._gains(space, kinds, roadmap.nodes[node : node + 1], cells, is_seen)[0])
        time_s = roadmap.ways_m[node] / self._p.speed + self._p.pause
        # Views of room are worth little, one like the other: then the goal would change at each look.
        is_kept = self._seeks_room or self._p.keep * gain / time_s > rate
        return (node, gain) if gain and is_kept else None

    @property
    def _slopes(self) -> tuple[float, float]:
        return math.tan(self._p.elevation_min), math.tan(self._p.elevation_max)

    def _reaches(self, space: Space) -> tuple[float, float]:
        return self._p.near / space.grid.resolution_m, self._p.reach / space.grid.resolution_m

    def _gains(
        self, space: Space, kinds: np.ndarray, nodes: np.ndarray, cells: Frontiers, is_seen: np.ndarray
    ) -> np.ndarray:
        """Return what nodes (n, 3) of the map show of cells, by kinds with a layer around the map."""
        gains: np.ndarray = seen_from(kinds, nodes + 1, *cells, self._slopes, self._reaches(space), is_seen)
        return gains
