"""What stays unknown when an exploration ends, and why: unreachable, too small, looked at in vain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple, Sequence

import numpy as np

from exploration.next_view.frontiers import Frontiers
from exploration.next_view.kernels.views import mark_seen
from exploration.next_view.unknown.openings import Behind, Opening
from exploration.planning.space import Space

ANY_SLOPE = (-1e9, 1e9)


class Why(Enum):
    """Why a part of the border stays unknown."""

    SMALL = "too small to matter for its way"
    NOT_YET = "the exploration ended before it was looked at"
    IN_VAIN = "looked at, but no beam told what is there"
    NO_BEAM = "no beam of the lidar points there from where the UAV fits"
    NO_ROOM = "no place with enough room for the UAV sees it"
    REFUSED = "CEPA does not fly the way to where it is seen"
    NARROW = "it lies behind an opening that is too narrow for this UAV"
    FAR = "where it is seen, the lidar is too far from all that tells it its place"


@dataclass(frozen=True)
class Leftover:
    """A part of the border that stays unknown.

    place_m: (x, y, z) in the map's frame. area_m2: of its voxels' faces. opening: behind which it lies, if
    the UAV is too wide for that.
    """

    place_m: tuple[float, float, float]
    area_m2: float
    why: Why
    opening: Opening | None = None

    @property
    def words(self) -> str:
        """Why it stays unknown."""
        return self.why.value if self.opening is None else f"{self.why.value}: {self.opening}"


class Sight(NamedTuple):
    """What the lidar sees: slopes of its lowest and highest beam; nearest and farthest distance in voxels."""

    slopes: tuple[float, float]
    reaches: tuple[float, float]


def leftovers_of(
    space: Space,
    kinds: np.ndarray,
    nodes: np.ndarray,
    cells: Frontiers,
    is_left: np.ndarray,
    sight: Sight,
    worth: Why = Why.SMALL,
) -> tuple[Leftover, ...]:
    """Return what cells of the border stay unknown, the largest first.

    Args:
        space: what the UAV may fly through.
        kinds: of the voxels, with a layer around the map.
        nodes: (n, 3) voxels of the map where the UAV can be.
        cells: of the border.
        is_left: (m,) whether each was looked at often enough.
        sight: of the lidar.
        worth: why a cell that a beam would show was not looked at.
    """
    by_beam, in_sight = np.zeros(len(cells.counts), bool), np.zeros(len(cells.counts), bool)
    mark_seen(kinds, nodes + 1, cells.places, sight.slopes, sight.reaches, by_beam)
    hidden = ~by_beam
    seen = in_sight[hidden]
    mark_seen(kinds, nodes + 1, cells.places[hidden], ANY_SLOPE, (0.0, sight.reaches[1]), seen)
    in_sight[hidden] = seen
    where = space.grid.centres_m(cells.places - 1)
    areas = cells.counts * space.grid.resolution_m**2
    found = []
    for place, area_m2, left, beam, is_seen in zip(
        where.tolist(), areas.tolist(), is_left, by_beam, in_sight
    ):
        why = Why.NO_BEAM if is_seen else Why.NO_ROOM
        if beam:
            why = Why.IN_VAIN if left else worth
        found.append(Leftover(tuple(place), area_m2, why))
    return tuple(sorted(found, key=lambda leftover: -leftover.area_m2))


def named(
    why: Why,
    leftovers: Sequence[Leftover],
    opened: Space,
    nodes: np.ndarray,
    sight: Sight,
    instead_of: Sequence[Why] = (Why.NO_BEAM, Why.NO_ROOM),
) -> tuple[Leftover, ...]:
    """Return leftovers; those that the UAV would see in a wider space get this reason.

    opened: the space without what the reason forbids. nodes: (n, 3) voxels of the map where the UAV could be
    then. instead_of: only these reasons are named anew.
    """
    unseen = [number for number, left in enumerate(leftovers) if left.why in instead_of]
    places = [opened.grid.index_of(np.array(leftovers[number].place_m)) for number in unseen]
    inside = [(number, place) for number, place in zip(unseen, places) if place is not None]
    told = list(leftovers)
    if inside:
        is_seen = np.zeros(len(inside), bool)
        cells = np.array([place for _, place in inside]) + 1
        mark_seen(np.pad(opened.grid.kinds, 1), nodes + 1, cells, sight.slopes, sight.reaches, is_seen)
        for (number, _), seen in zip(inside, is_seen):
            told[number] = replace(told[number], why=why) if seen else told[number]
    return tuple(told)


def behind_openings(leftovers: Sequence[Leftover], behind: Behind, space: Space) -> tuple[Leftover, ...]:
    """Return leftovers; those that lie behind an opening that is too narrow name it."""
    told = list(leftovers)
    for number, left in enumerate(leftovers):
        voxel = space.grid.index_of(np.array(left.place_m))
        opening = None if voxel is None else behind.opening_of(space, voxel)
        if opening is not None:
            told[number] = replace(left, why=Why.NARROW, opening=opening)
    return tuple(told)
