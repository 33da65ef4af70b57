"""Views of the border behind which the UAV itself might fit, so that no room stays unknown."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.frontiers import Frontiers
from exploration.next_view.kernels.views import sights_of
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.unknown_room import is_near_room
from exploration.next_view.views.border_without_gain import BorderWithoutGain
from exploration.next_view.views.scene import Scene
from exploration.next_view.views.tour import covering, first_of_tour
from exploration.next_view.views.view import Look, View

LARGE_VOXELS = 5_000_000
"""In a map of more, room is looked for only at views: it takes 0.1 s of CPU time for each million."""
ROOM_CELL = 0.5
"""Side of a cell, as a share of `cell`: so that no small door is lost."""


class RoomViews:
    """Leads to few views that together show all of the border of room, by a short tour.

    Args:
        parameters: of the explorer.
    """

    def __init__(self, parameters: ExplorerParameters) -> None:
        self._p = parameters
        self._side_m = ROOM_CELL * parameters.cell
        self._no_gain = BorderWithoutGain(self._side_m, parameters.reach)
        self._near = np.zeros((0, 0, 0), bool)
        """What was near room at the last view, with a layer around the map."""
        self._corner = np.zeros(3, np.int64)

    def best(
        self,
        scene: Scene,
        roadmap: Roadmap,
        views: np.ndarray,
        looked: Look,
        home_m: np.ndarray,
        present: View | None,
    ) -> View | None:
        """Return the view to fly to. None: no view shows border of room that was not looked at without gain.

        Args:
            scene: the map.
            roadmap: the ways from the UAV.
            views: its nodes that are tried first.
            looked: what the UAV looked at since the last decision.
            home_m: (x, y, z) of the tour's end.
            present: the view that the UAV flies to. It is kept while it shows anything: views of room are
                worth little, one like the other.
        """
        grid = scene.space.grid
        is_same = self._near.shape == scene.kinds.shape and (self._corner == grid.corner).all()
        is_on_way = present is not None and looked.counts < 1.0
        if not (is_same and is_on_way and scene.kinds.size > LARGE_VOXELS):
            near = is_near_room(scene.space, roadmap.nodes, self._p.room_min)
            self._near, self._corner = np.pad(near, 1, mode="edge"), grid.corner
        cells = scene.cells(self._side_m, self._near[tuple(scene.border.T)])
        self._no_gain.note(scene, looked, cells)
        cells = cells.chosen(~self._no_gain.is_left(scene, cells))
        if not len(cells.counts):
            return None
        kept = None if present is None else self._kept(scene, roadmap, cells, present)
        return kept or self._first(scene, roadmap, views, cells, home_m)

    def _first(
        self, scene: Scene, roadmap: Roadmap, views: np.ndarray, cells: Frontiers, home_m: np.ndarray
    ) -> View | None:
        """Return the first view of a tour that shows all cells, from near if that is possible."""
        slopes, (near, far) = scene.sight
        all_ = np.arange(len(roadmap.nodes))
        for nodes, reach in ((views, far / 2), (all_, far / 2), (all_, far)):
            places = roadmap.nodes[nodes] + 1
            sights = sights_of(scene.kinds, places, cells.places, slopes, (near, reach))
            stops = covering(sights, roadmap.ways_m[nodes])
            if len(stops):
                first = first_of_tour(roadmap, nodes[stops], home_m)
                shown = cells.chosen(sights[nodes == first][0])
                self._no_gain.promise(scene, shown)
                return self._view(scene, roadmap, first, int(shown.counts.sum()))
        return None

    def _kept(self, scene: Scene, roadmap: Roadmap, cells: Frontiers, present: View) -> View | None:
        """Return the present view if a way leads there and it shows anything."""
        node = roadmap.nearest(present.place_m)
        if math.dist(roadmap.place_m(node), present.place_m) >= self._p.spacing:
            return None
        shown = int(scene.gains(roadmap.nodes[[node]], cells)[0][0])
        return self._view(scene, roadmap, node, shown) if shown else None

    @staticmethod
    def _view(scene: Scene, roadmap: Roadmap, node: int, shown: int) -> View:
        """shown: frontier voxels."""
        volume_m3 = shown * scene.space.grid.resolution_m**3
        return View(roadmap.place_m(node), float(roadmap.ways_m[node]), volume_m3)
