"""Views of the border behind which the UAV itself might fit, so that no room stays unknown."""

from __future__ import annotations

import math

import numpy as np

from inspection_tools.exploration.beyond import is_near_room
from inspection_tools.exploration.frontiers import Frontiers, in_cells
from inspection_tools.exploration.kernels.views import seen_from, sights_of
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.exploration.roadmap import Roadmap
from inspection_tools.exploration.views.tour import covering, first_of_tour
from inspection_tools.exploration.views.view import Look, View
from inspection_tools.planning.space import Space

NEAR, FAR = 1.0, 0.5
"""What a view in vain from the nearer half of the lidar's reach counts, and one from the other half."""
TRIES = 1.0
"""A cell is left after views in vain that count so much."""
SAME = 0.8
"""A cell has not changed if it still has this share of its frontier voxels."""
ROOM_CELL = 0.5
"""Side of a cell, as a share of `cell`: so that no small door is lost."""


class RoomViews:
    """Leads to few views that together show all of the border of room, by a short tour.

    Args:
        parameters: of the explorer.
    """

    def __init__(self, parameters: ExplorerParameters) -> None:
        self._p = parameters
        self._tried: dict[tuple[int, ...], tuple[int, float]] = {}
        """By cell: its frontier voxels when it was looked at, and what the views in vain count."""

    def best(
        self,
        space: Space,
        border: np.ndarray,
        roadmap: Roadmap,
        views: np.ndarray,
        looked: Look,
        home_m: np.ndarray,
        present: View | None,
    ) -> View | None:
        """Return the view to fly to. None: no view shows border of room that was not looked at in vain.

        Args:
            space: the map.
            border: (n, 3) frontier voxels of the map with a layer around it.
            roadmap: the ways from the UAV.
            views: its nodes that are tried first.
            looked: what the UAV looked at since the last decision.
            home_m: (x, y, z) of the tour's end.
            present: the view that the UAV flies to. It is kept while it shows anything: views of room are
                worth little, one like the other.
        """
        near = np.pad(is_near_room(space, roadmap.nodes, self._p.room_min), 1, mode="edge")
        side = max(1, round(ROOM_CELL * self._p.cell / space.grid.resolution_m))
        cells = in_cells(border[near[tuple(border.T)]], side, space.grid.corner[::-1] - 1)
        kinds = np.pad(space.grid.kinds, 1)
        keys = (cells.places + space.grid.corner[::-1] - 1) // side
        self._note(space, kinds, looked, cells, keys)
        cells = cells.chosen(~self._is_left(keys, cells.counts))
        if not len(cells.counts):
            return None
        kept = None if present is None else self._kept(space, kinds, roadmap, cells, present)
        return kept or self._first(space, kinds, roadmap, views, cells, home_m)

    def _first(
        self,
        space: Space,
        kinds: np.ndarray,
        roadmap: Roadmap,
        views: np.ndarray,
        cells: Frontiers,
        home_m: np.ndarray,
    ) -> View | None:
        """Return the first view of a tour that shows all cells, from near if that is possible."""
        (near, far), all_ = self._reaches(space), np.arange(len(roadmap.nodes))
        for nodes, reach in ((views, far / 2), (all_, far / 2), (all_, far)):
            places = roadmap.nodes[nodes] + 1
            sights = sights_of(kinds, places, cells.places, self._slopes, (near, reach))
            stops = covering(sights, roadmap.ways_m[nodes])
            if len(stops):
                first = first_of_tour(roadmap, nodes[stops], home_m)
                shown = int(cells.counts[sights[nodes == first][0]].sum())
                return self._view(space, roadmap, first, shown)
        return None

    def _kept(
        self, space: Space, kinds: np.ndarray, roadmap: Roadmap, cells: Frontiers, present: View
    ) -> View | None:
        """Return the present view if a way leads there and it shows anything."""
        node = roadmap.nearest(present.place_m)
        if math.dist(roadmap.place_m(node), present.place_m) >= self._p.spacing:
            return None
        shown = int(self._gains(space, kinds, roadmap.nodes[[node]], cells)[0][0])
        return self._view(space, roadmap, node, shown) if shown else None

    @staticmethod
    def _view(space: Space, roadmap: Roadmap, node: int, shown: int) -> View:
        """shown: frontier voxels."""
        volume_m3 = shown * space.grid.resolution_m**3
        return View(roadmap.place_m(node), float(roadmap.ways_m[node]), volume_m3)

    def _note(
        self, space: Space, kinds: np.ndarray, looked: Look, cells: Frontiers, keys: np.ndarray
    ) -> None:
        """Count the cells that were looked at in vain."""
        indices = [index for index in map(space.grid.index_of, looked.places_m) if index is not None]
        if not indices or not len(cells.counts):
            return
        is_seen = self._gains(space, kinds, np.array(indices), cells)[1]
        seen = zip(map(tuple, keys[is_seen].tolist()), cells.places[is_seen], cells.counts[is_seen].tolist())
        for key, place, count in seen:
            far_m = min(math.dist(index, place - 1) for index in indices) * space.grid.resolution_m
            counts = looked.counts * (NEAR if far_m <= self._p.reach / 2 else FAR)
            before, tries = self._tried.get(key, (count, 0.0))
            self._tried[key] = (count, (tries if count >= SAME * before else 0.0) + counts)

    def _is_left(self, keys: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """Return (m,) whether cells were looked at often enough, and have not changed."""
        is_left = np.zeros(len(counts), bool)
        for number, (key, count) in enumerate(zip(map(tuple, keys.tolist()), counts.tolist())):
            before, tries = self._tried.get(key, (0, 0.0))
            is_left[number] = tries >= TRIES and count >= SAME * before
        return is_left

    @property
    def _slopes(self) -> tuple[float, float]:
        return math.tan(self._p.elevation_min), math.tan(self._p.elevation_max)

    def _reaches(self, space: Space) -> tuple[float, float]:
        return self._p.near / space.grid.resolution_m, self._p.reach / space.grid.resolution_m

    def _gains(
        self, space: Space, kinds: np.ndarray, nodes: np.ndarray, cells: Frontiers
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return what nodes (n, 3) of the map show of cells (n,), and which cells are seen (m,).

        kinds: with a layer around the map.
        """
        is_seen = np.zeros(len(cells.counts), bool)
        gains = seen_from(kinds, nodes + 1, *cells, self._slopes, self._reaches(space), is_seen)
        return gains, is_seen
