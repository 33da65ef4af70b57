"""Next best view by volume: the view that reveals most of the unknown for its time, also above and below."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.frontiers import Frontiers
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.views.columns import Candidates, Climbs, columns, joined, view_of
from exploration.next_view.views.no_gain import CellsWithoutGain
from exploration.next_view.views.prospect import Prospect
from exploration.next_view.views.scene import Scene
from exploration.next_view.views.view import Look, View
from exploration.planning.space import Space

CLIMBS = Climbs(far_m=2.0, step_m=0.2)
PROMISING = 20
"""So many of the views above and below are looked at with all beams."""
STILL = 0.5
"""The UAV goes on to a view that shows this share of `volume_min`."""
SMALL = 0.3
"""Before the UAV flies far, it takes the near views that show this share of `volume_min`."""


class RevealingViews:
    """Looks for views.

    References: Bircher et al. 2016 (gain by volume).

    Args:
        parameters: of the explorer. is_steep: the UAV may climb and sink into what only range finders see.
    """

    def __init__(self, parameters: ExplorerParameters, is_steep: bool) -> None:
        self._p, self._is_steep, self._no_gain = parameters, is_steep, CellsWithoutGain()
        self._prospect: Prospect | None = None
        """Of the present decision."""

    def note(self, scene: Scene, looked: Look) -> None:
        """Take what the UAV looked at since the last decision."""
        self._prospect = self._of(scene)
        for at in filter(None, map(scene.space.grid.index_of, looked.places_m)):
            self._prospect.note(np.array(at), looked.counts)

    def is_left(self, scene: Scene, cells: Frontiers) -> np.ndarray:
        """Return (m,) whether cells of the border were looked at without gain."""
        return self._of(scene).is_without_gain(cells.places - 1)

    def news_voxels(self, space: Space) -> float:
        """Return how many voxels must be new before a view may be worth it again."""
        return self._p.volume_min / space.grid.resolution_m**3

    def _of(self, scene: Scene) -> Prospect:
        p = self._p
        return Prospect(scene.space, (p.elevation_min, p.elevation_max), (p.near, p.reach), self._no_gain)

    def best(
        self, scene: Scene, roadmap: Roadmap, nodes: np.ndarray, here_m: np.ndarray, present: View | None
    ) -> View | None:
        """Return the view that reveals most for its time; None: none is worth it.

        Args:
            scene: the map. `note` was called with it.
            roadmap: the ways from the UAV.
            nodes: of the roadmap that are looked from.
            here_m: (x, y, z) of the UAV.
            present: the view that the UAV flies to. It is kept unless another is worth `keep` times more.
        """
        assert self._prospect is not None, "note first"
        space, prospect = scene.space, self._prospect
        found = [_level(roadmap, nodes)]
        if self._is_steep:
            steep = _columns(space, prospect, roadmap, here_m)
            found.append(_promising(prospect, steep, self._times_s(steep)))
        goes_on = None
        if present is not None and present.column_m is None:
            goes_on = _again(space, roadmap, present, self._p.spacing)
        all_ = joined(found if goes_on is None else [*found, goes_on])
        times_s = self._times_s(all_)
        gains = prospect.gains_m3(all_.places, all_.views)
        best = self._choose(all_.ways_m, gains, times_s, goes_on is not None)
        return None if best is None else view_of(space, all_, best, float(gains[best]))

    def _times_s(self, found: Candidates) -> np.ndarray:
        times_s: np.ndarray = found.ways_m / self._p.speed + self._p.pause
        return times_s

    def _choose(
        self, ways_m: np.ndarray, gains: np.ndarray, times_s: np.ndarray, goes_on: bool
    ) -> int | None:
        """Return the best view's number; None: none is worth it. goes_on: the last one is the present one."""
        rates = gains / times_s
        is_worth = (gains >= self._p.volume_min) & (rates >= self._p.volume_rate)
        if goes_on:
            is_worth[-1] = gains[-1] >= STILL * self._p.volume_min
            rates[-1] *= self._p.keep
        best = int(np.argmax(np.where(is_worth, rates, -1.0)))
        if is_worth[best] and ways_m[best] <= self._p.near_first:
            return best
        is_small = (ways_m <= self._p.near_first) & (gains >= SMALL * self._p.volume_min)
        if is_small.any():
            return int(np.argmax(np.where(is_small, rates, -1.0)))
        return best if is_worth[best] else None


def _level(roadmap: Roadmap, nodes: np.ndarray) -> Candidates:
    places = roadmap.nodes[nodes]
    return Candidates(places, places, roadmap.ways_m[nodes], places, np.arange(len(nodes)))


def _again(space: Space, roadmap: Roadmap, present: View, spacing_m: float) -> Candidates | None:
    """Return the view that the UAV flies to; None: no way leads there."""
    node, at = roadmap.nearest(present.place_m), space.grid.index_of(present.place_m)
    if at is None or math.dist(roadmap.place_m(node), present.place_m) >= spacing_m:
        return None
    places = np.array([at])
    return Candidates(places, places, roadmap.ways_m[[node]], places, np.zeros(1, np.int64))


def _columns(space: Space, prospect: Prospect, roadmap: Roadmap, here_m: np.ndarray) -> Candidates:
    """Return the views straight above and below nodes, and the UAV, in what no beam has shown."""
    nodes = roadmap.spread(roadmap.ends_of_columns())
    bases, ways_m = roadmap.nodes[nodes], roadmap.ways_m[nodes]
    here = space.grid.index_of(here_m)
    if here is not None:
        bases, ways_m = np.vstack((bases, here)), np.append(ways_m, 0.0)
    return columns(space, prospect.is_blocked, bases, ways_m, CLIMBS)


def _promising(prospect: Prospect, found: Candidates, times_s: np.ndarray) -> Candidates:
    """Return the views that seem to reveal most for their time at a first look, by fewer beams."""
    roughly = prospect.gains_m3(found.places, found.views, roughly=True)
    kept = np.sort(np.argsort(-roughly / times_s, kind="stable")[:PROMISING])
    which = np.isin(found.views, kept)
    views = np.searchsorted(kept, found.views[which])
    return Candidates(found.bases[kept], found.ends[kept], found.ways_m[kept], found.places[which], views)
