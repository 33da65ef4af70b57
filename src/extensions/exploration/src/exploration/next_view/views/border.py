"""Next best view by the border: the view that shows most of the border of what is known for its time."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.frontiers import Frontiers
from exploration.next_view.kernels.best_view import best_view
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.views.border_without_gain import BorderWithoutGain
from exploration.next_view.views.kept_gains import KeptGains
from exploration.next_view.views.scene import Scene
from exploration.next_view.views.view import Look, View
from exploration.planning.space import Space


class BorderViews:
    """Looks for views: the border for the way's cost (Gonzalez-Banos and Latombe, 2002).

    Args:
        parameters: of the explorer.
    """

    def __init__(self, parameters: ExplorerParameters) -> None:
        self._p, self._no_gain = parameters, BorderWithoutGain(parameters.cell, parameters.reach)
        self._gains = KeptGains(parameters.cell)

    def note(self, scene: Scene, looked: Look) -> None:
        """Take what the UAV looked at since the last decision."""
        if looked.places_m:
            self._no_gain.note(scene, looked, scene.cells(self._p.cell))

    def is_left(self, scene: Scene, cells: Frontiers) -> np.ndarray:
        """Return (m,) whether cells of the border, of the side `cell`, were looked at without gain."""
        return self._no_gain.is_left(scene, cells)

    def news_voxels(self, space: Space) -> float:
        """Return how many voxels must be new before a view may be worth it again."""
        return self._p.worth_min / space.grid.resolution_m**2

    def best(
        self, scene: Scene, roadmap: Roadmap, nodes: np.ndarray, here_m: np.ndarray, present: View | None
    ) -> View | None:
        """Return the view that shows most for its time; None: none is worth it.

        Args:
            scene: the map.
            roadmap: the ways from the UAV.
            nodes: of the roadmap that are looked from.
            here_m: (x, y, z) of the UAV.
            present: the view that the UAV flies to. It is kept unless another is worth `keep` times more.
        """
        cells = scene.cells(self._p.cell)
        cells = cells.chosen(~self.is_left(scene, cells))
        if not len(cells.counts):
            return None
        times_s, face_m2 = self._times_s(roadmap.ways_m[nodes]), scene.space.grid.resolution_m**2
        least = self._p.worth_min / face_m2, self._p.rate_min / face_m2
        places = roadmap.nodes[nodes]
        gains = self._gains.of(scene, places, cells)
        best, gain = best_view(scene.kinds, places + 1, times_s, *cells, *scene.sight, least, gains)
        self._gains.keep(gains)
        if best < 0:
            return None
        kept = None if present is None else self._kept(scene, roadmap, cells, present, gain / times_s[best])
        return kept or self._view(scene, roadmap, int(nodes[best]), gain)

    def _times_s(self, ways_m: np.ndarray) -> np.ndarray:
        times_s: np.ndarray = ways_m / self._p.speed + self._p.pause
        return times_s

    def _kept(
        self, scene: Scene, roadmap: Roadmap, cells: Frontiers, present: View, rate: float
    ) -> View | None:
        """Return the present view if a rate, in voxels a second, is not worth the change."""
        node = roadmap.nearest(present.place_m)
        if math.dist(roadmap.place_m(node), present.place_m) >= self._p.spacing:
            return None
        gain = int(scene.gains(roadmap.nodes[[node]], cells)[0][0])
        is_kept = gain and self._p.keep * gain / self._times_s(roadmap.ways_m[node]) > rate
        return self._view(scene, roadmap, node, gain) if is_kept else None

    @staticmethod
    def _view(scene: Scene, roadmap: Roadmap, node: int, gain: int) -> View:
        voxel_m3 = scene.space.grid.resolution_m**3
        return View(roadmap.place_m(node), float(roadmap.ways_m[node]), gain * voxel_m3)
