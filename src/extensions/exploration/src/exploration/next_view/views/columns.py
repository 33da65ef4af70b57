"""Views straight above and below places where the UAV may be, in what no beam of the lidar has shown."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from exploration.next_view.views.view import View
from exploration.planning.kernels.distances import squared_clearances
from exploration.planning.space import Space


class Candidates(NamedTuple):
    """Views to choose from: (n,) of their ends, voxels z, y, x, and of where ways to them end.

    places: (m, 3) from which they look. views: (m,) the view that each place belongs to.
    """

    bases: np.ndarray
    ends: np.ndarray
    ways_m: np.ndarray
    places: np.ndarray
    views: np.ndarray


class Climbs(NamedTuple):
    """far_m: the UAV climbs or sinks so far, at most. step_m: between the heights to which it could."""

    far_m: float
    step_m: float


def columns(
    space: Space, is_blocked: np.ndarray, bases: np.ndarray, ways_m: np.ndarray, climbs: Climbs
) -> Candidates:
    """Return the views straight above and below bases (n, 3), to which ways (n,) lead.

    is_blocked: (d, h, w) what counts as occupied. All else counts as free, but for what is closed.
    """
    fits = squared_clearances(is_blocked, math.isqrt(space.need - 1) + 1) >= space.need
    for closure in space.closed:
        fits &= ~_ball(space, closure.place_m, closure.radius_m)
    return joined([_one_way(space, fits, bases, ways_m, sign, climbs) for sign in (1, -1)])


def _one_way(
    space: Space, fits: np.ndarray, bases: np.ndarray, ways_m: np.ndarray, sign: int, climbs: Climbs
) -> Candidates:
    """Return the views above (sign 1) or below (-1) bases (n, 3), and at all heights up to them.

    The highest place, or the lowest, is one of them, though a way may lead there: near a ceiling or a floor a
    lattice leaves out the places that show most of it. fits: (d, h, w) where the UAV would fit if all were
    empty that seems so.
    """
    voxel_m, is_clear = space.grid.resolution_m, space.squares >= space.need
    step = max(1, round(climbs.step_m / voxel_m))
    at, is_open, is_new = bases.copy(), np.ones(len(bases), bool), np.zeros(len(bases), bool)
    passed: list[np.ndarray] = []
    found = []
    for length in range(1, round(climbs.far_m / voxel_m) + 1):
        before, was_open = at.copy(), is_open.copy()
        at[:, 0] += sign
        is_open &= (at[:, 0] >= 0) & (at[:, 0] < len(fits))
        inside = tuple(np.where(is_open[:, None], at, 0).T)
        is_open &= fits[inside]
        is_new |= is_open & ~is_clear[inside]
        if (length - 1) % step:
            is_last = np.flatnonzero(was_open & ~is_open)
            found.append(_ends(bases, [*passed, before], ways_m + (length - 1) * voxel_m, is_last))
        if length % step == 0:
            passed.append(at.copy())
            found.append(_ends(bases, passed, ways_m + length * voxel_m, np.flatnonzero(is_open & is_new)))
    return joined(found)


def _ends(
    bases: np.ndarray, passed: Sequence[np.ndarray], ways_m: np.ndarray, which: np.ndarray
) -> Candidates:
    """Return the views at the last of the passed places, for those of the bases that count."""
    places = np.concatenate([places[which] for places in passed])
    views = np.tile(np.arange(len(which)), len(passed))
    return Candidates(bases[which], passed[-1][which], ways_m[which], places, views)


def joined(found: Sequence[Candidates]) -> Candidates:
    """Return all views as one."""
    begins = np.cumsum([0, *(len(each.ways_m) for each in found)])
    bases, ends, ways_m, places = (np.concatenate([each[part] for each in found]) for part in range(4))
    views = np.concatenate([begin + each.views for begin, each in zip(begins, found)])
    return Candidates(bases, ends, ways_m, places, views)


def view_of(space: Space, found: Candidates, number: int, gain_m3: float) -> View:
    """Return one of the views."""
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
