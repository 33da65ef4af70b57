"""Chooses the view that reveals most of the unknown for its time, also straight above and below."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from inspection_tools.exploration.frontiers import Frontiers
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.exploration.roadmap import Roadmap
from inspection_tools.exploration.views.prospect import Prospect
from inspection_tools.exploration.views.scene import Scene
from inspection_tools.exploration.views.vain import Vain
from inspection_tools.exploration.views.view import Look, View
from inspection_tools.planning.kernels.distances import squared_clearances
from inspection_tools.planning.space import Space

CLIMB_M = 2.0
"""The UAV climbs or sinks so far into what no beam has shown, at most."""
CLIMB_STEP_M = 0.4
"""Between the heights to which it could climb."""
PROMISING = 20
"""So many of the views above and below are looked at with all beams."""
STILL = 0.5
"""The UAV goes on to a view that shows this share of `volume_min`."""
SMALL = 0.3
"""Before the UAV flies far, it takes the near views that show this share of `volume_min`."""


class Candidates(NamedTuple):
    """Views to choose from: (n,) of their ends, voxels z, y, x, and of where ways to them end.

    places: (m, 3) from which they look. views: (m,) the view that each place belongs to.
    """

    bases: np.ndarray
    ends: np.ndarray
    ways_m: np.ndarray
    places: np.ndarray
    views: np.ndarray


class RevealingViews:
    """Looks for views.

    References: Bircher et al. 2016 (gain by volume).

    Args:
        parameters: of the explorer. is_steep: the UAV may climb and sink into what only range finders see.
    """

    def __init__(self, parameters: ExplorerParameters, is_steep: bool) -> None:
        self._p, self._is_steep, self._vain = parameters, is_steep, Vain()
        self._prospect: Prospect | None = None
        """Of the present decision."""

    def note(self, scene: Scene, looked: Look) -> None:
        """Take what the UAV looked at since the last decision."""
        self._prospect = self._of(scene)
        for at in filter(None, map(scene.space.grid.index_of, looked.places_m)):
            self._prospect.note(np.array(at), looked.counts)

    def is_left(self, scene: Scene, cells: Frontiers) -> np.ndarray:
        """Return (m,) whether cells of the border were looked at in vain."""
        return self._of(scene).is_vain(cells.places - 1)

    def news_voxels(self, space: Space) -> float:
        """Return how many voxels must be new before a view may be worth it again."""
        return self._p.volume_min / space.grid.resolution_m**3

    def _of(self, scene: Scene) -> Prospect:
        p = self._p
        return Prospect(scene.space, (p.elevation_min, p.elevation_max), (p.near, p.reach), self._vain)

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
            columns = _columns(space, prospect, roadmap, nodes, here_m)
            found.append(_promising(prospect, columns, self._times_s(columns)))
        goes_on = None
        if present is not None and present.column_m is None:
            goes_on = _again(space, roadmap, present, self._p.spacing)
        all_ = _joined(found if goes_on is None else [*found, goes_on])
        times_s = self._times_s(all_)
        gains = prospect.gains_m3(all_.places, all_.views)
        best = self._choose(all_.ways_m, gains, times_s, goes_on is not None)
        return None if best is None else _view(space, all_, best, float(gains[best]))

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


def _columns(
    space: Space, prospect: Prospect, roadmap: Roadmap, nodes: np.ndarray, here_m: np.ndarray
) -> Candidates:
    """Return the views straight above and below nodes, and the UAV, in what no beam has shown."""
    fits = squared_clearances(prospect.is_blocked, math.isqrt(space.need - 1) + 1) >= space.need
    for closure in space.closed:
        fits &= ~_ball(space, closure.place_m, closure.radius_m)
    bases, ways_m = roadmap.nodes[nodes], roadmap.ways_m[nodes]
    here = space.grid.index_of(here_m)
    if here is not None:
        bases, ways_m = np.vstack((bases, here)), np.append(ways_m, 0.0)
    return _joined([_one_way(space, fits, bases, ways_m, sign) for sign in (1, -1)])


def _one_way(space: Space, fits: np.ndarray, bases: np.ndarray, ways_m: np.ndarray, sign: int) -> Candidates:
    """Return the views above (sign 1) or below (-1) bases (n, 3), and at all heights up to them.

    fits: (d, h, w) where the UAV would fit if all were empty that seems so.
    """
    voxel_m, is_clear = space.grid.resolution_m, space.squares >= space.need
    step = max(1, round(CLIMB_STEP_M / voxel_m))
    at, is_open, is_new = bases.copy(), np.ones(len(bases), bool), np.zeros(len(bases), bool)
    passed: list[np.ndarray] = []
    found = []
    for length in range(1, round(CLIMB_M / voxel_m) + 1):
        at[:, 0] += sign
        is_open &= (at[:, 0] >= 0) & (at[:, 0] < len(fits))
        inside = tuple(np.where(is_open[:, None], at, 0).T)
        is_open &= fits[inside]
        is_new |= is_open & ~is_clear[inside]
        if length % step:
            continue
        passed.append(at.copy())
        which = np.flatnonzero(is_open & is_new)
        places = np.concatenate([places[which] for places in passed])
        views = np.tile(np.arange(len(which)), len(passed))
        ways = ways_m[which] + length * voxel_m
        found.append(Candidates(bases[which], at[which], ways, places, views))
    return _joined(found)


def _joined(found: Sequence[Candidates]) -> Candidates:
    begins = np.cumsum([0, *(len(each.ways_m) for each in found)])
    bases, ends, ways_m, places = (np.concatenate([each[part] for each in found]) for part in range(4))
    views = np.concatenate([begin + each.views for begin, each in zip(begins, found)])
    return Candidates(bases, ends, ways_m, places, views)


def _promising(prospect: Prospect, found: Candidates, times_s: np.ndarray) -> Candidates:
    """Return the views that seem to reveal most for their time at a first look, by fewer beams."""
    roughly = prospect.gains_m3(found.places, found.views, roughly=True)
    kept = np.sort(np.argsort(-roughly / times_s, kind="stable")[:PROMISING])
    which = np.isin(found.views, kept)
    views = np.searchsorted(kept, found.views[which])
    return Candidates(found.bases[kept], found.ends[kept], found.ways_m[kept], found.places[which], views)


def _view(space: Space, found: Candidates, number: int, gain_m3: float) -> View:
    base, end = found.bases[number], found.ends[number]
    column_m = None
    if base[0] != end[0]:
        column = np.repeat(base[None], abs(end[0] - base[0]) + 1, axis=0)
        column[:, 0] += np.sign(end[0] - base[0]) * np.arange(len(column))
        column_m = space.grid.centres_m(column)
    return View(space.grid.centres_m(end[None])[0], float(found.ways_m[number]), gain_m3, column_m)


def _ball(space: Space, place_m: tuple[float, float, float], radius_m: float) -> np.ndarray:
    """Return (d, h, w) which voxels' centres are in a ball."""
    centre = space.inner(np.array(place_m))
    axes = [(np.arange(size) + 0.5 - at) ** 2 for size, at in zip(space.squares.shape, centre)]
    far: np.ndarray = axes[0][:, None, None] + axes[1][:, None] + axes[2]
    return far <= (radius_m / space.grid.resolution_m) ** 2
