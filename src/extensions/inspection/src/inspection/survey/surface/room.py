"""The room in which the UAV flies: the air around the surfaces, and where the body has its clearance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from exploration.planning.kernels.distances import FACE_REACH_MAX, squared_clearances
from exploration.planning.space import LEAST_NEED
from flight_basics.errors import SurveyError

AIR, OTHER = 1, 0
MOST_VOXELS = 120_000_000
LEAST_SIDES = 5
"""A place is sheltered if something blocks so many of its six sides; an open-topped tank has no lid."""
BESIDE_M = 2.0
"""A UAV that surveys from outside takes off so far beside all that is above the ground."""
HOME_M = 0.5
"""The UAV's room may begin so far above its clearance over the place of take-off, which is on the ground."""
MOST_REGIONS, LEAST_M3 = 6, 0.5
"""So many rooms are told, if the UAV's centre has so much space in them."""


class Region(NamedTuple):
    """A room in which the UAV fits. flyable_m3: where its centre may be. is_open: it reaches the outside.

    sheltered_m3: of that, what surfaces enclose to five of the six sides at least.
    """

    flyable_m3: float
    sheltered_m3: float
    is_open: bool


@dataclass(frozen=True)
class Room:
    """Voxels, z first. Voxel (i, j, k) begins at corner_m + voxel_m * (k, j, i).

    Attributes:
        voxel_m: side. corner_m: (3,) x, y, z of the first voxel's corner.
        air: (d, h, w) uint8, AIR where light passes and a way leads to the UAV, however narrow.
        flyable: (d, h, w) bool, where the UAV's centre may be and gets to from its home.
        squares: (d, h, w) uint16, squared distances from voxels' centres to the faces of blocked ones, in
            half voxels, cut beyond what the UAV needs.
        need: least of them that the UAV keeps. home_m: (3,) where it takes off.
        regions: the largest rooms of the mesh in which the UAV fits, this one first.
    """

    voxel_m: float
    corner_m: np.ndarray
    air: np.ndarray
    flyable: np.ndarray
    squares: np.ndarray
    need: int
    home_m: np.ndarray
    regions: tuple[Region, ...] = ()

    def inner(self, places_m: np.ndarray) -> np.ndarray:
        """Return places (..., 3), x, y, z, as z, y, x in voxels."""
        return ((np.asarray(places_m) - self.corner_m) / self.voxel_m)[..., ::-1]

    def outer(self, inner: np.ndarray) -> np.ndarray:
        """Return the places (..., 3), x, y, z, m, of z, y, x in voxels."""
        return np.asarray(inner)[..., ::-1] * self.voxel_m + self.corner_m

    def at(self, values: np.ndarray, places_m: np.ndarray) -> np.ndarray:
        """Return the values of the voxels that hold places (n, 3); 0 outside."""
        index = np.floor(self.inner(places_m)).astype(np.int64)
        inside = ((index >= 0) & (index < values.shape)).all(axis=-1)
        found = np.zeros(index.shape[:-1], values.dtype)
        found[inside] = values[tuple(index[inside].T)]
        return found

    def away_m(self, square: int) -> float:
        """Return the distance, m, whose square in half voxels this is."""
        return 0.5 * math.sqrt(square) * self.voxel_m

    def clearances_m(self, places_m: np.ndarray) -> np.ndarray:
        """Return how far places (n, 3) in the air are from what is none, m, to a voxel; 0 elsewhere."""
        return self.at(self.voxel_m * ndimage.distance_transform_edt(self.air == AIR), places_m)


def room_of(
    blocked: np.ndarray,
    corner_m: np.ndarray,
    voxel_m: float,
    clearance_m: float,
    home_m: np.ndarray | None,
    outside: bool = False,
    kept_out: np.ndarray | None = None,
) -> Room:
    """Return the room of a UAV among blocked voxels (d, h, w).

    home_m: None: in the room of which surfaces enclose most, open to the outside or not. If they enclose
    nothing, as of a pillar on a field, in the largest. outside: in the largest that reaches the outside.
    kept_out: (d, h, w) air in which the UAV does not fly.

    Raises:
        SurveyError: the UAV fits nowhere, or not at its home.
    """
    need = max(math.ceil((2.0 * clearance_m / voxel_m) ** 2 - 1e-9), LEAST_NEED)
    reach = min(math.isqrt(need) // 2 + 2, FACE_REACH_MAX)
    squares = squared_clearances(blocked, reach, to_faces=True)
    fits = squares >= need
    if kept_out is not None:
        fits &= ~kept_out
    numbers, count = ndimage.label(fits)
    if not count:
        raise SurveyError(
            f"A UAV that needs {clearance_m:.2f} m to each side fits nowhere: give another radius or margin."
        )
    within_walls = fits & is_sheltered(blocked)
    sizes, sheltered = (_sizes(numbers, count, which) for which in (fits, within_walls))
    if home_m is None and outside:
        reaches = np.zeros_like(sizes)
        reaches[_at_borders(numbers)] = 1
        number = int((sizes * reaches).argmax())
        flyable = numbers == number
        home_m = _beside(flyable, blocked, BESIDE_M / voxel_m) * voxel_m + corner_m
    elif home_m is None:
        number = int((sheltered if sheltered.any() else sizes).argmax())
        flyable = numbers == number
        within = flyable & within_walls
        home_m = _lowest_middle(within if within.any() else flyable) * voxel_m + corner_m
    else:
        home_m = np.asarray(home_m, float)
        index = np.floor(((home_m - corner_m) / voxel_m)[::-1]).astype(np.int64)
        inside = ((index >= 0) & (index < fits.shape)).all()
        number = int(numbers[tuple(index)]) if inside else 0
        if not number:
            number, home_m = _near(numbers, index, voxel_m, corner_m, clearance_m, home_m)
        flyable = numbers == number
    airs, _ = ndimage.label(~blocked)
    inner = np.floor(((home_m - corner_m) / voxel_m)[::-1]).astype(np.int64)
    air = (airs == airs[tuple(inner)]).astype(np.uint8)
    regions = _regions(number, sizes, sheltered, _at_borders(numbers), voxel_m**3)
    return Room(voxel_m, np.asarray(corner_m, float), air, flyable, squares, need, home_m, regions)


def _sizes(numbers: np.ndarray, count: int, which: np.ndarray) -> np.ndarray:
    """Return (count + 1,) voxels of each room that are meant; 0 of what is none."""
    sizes = np.bincount(numbers[which], minlength=count + 1)
    sizes[0] = 0
    return sizes


def is_sheltered(blocked: np.ndarray) -> np.ndarray:
    """Return which voxels (d, h, w) have something blocked to five of their six sides at least."""
    sides = np.zeros(blocked.shape, np.uint8)
    for axis in range(3):
        for order in (slice(None), slice(None, None, -1)):
            along = tuple(order if k == axis else slice(None) for k in range(3))
            sides[along] += np.logical_or.accumulate(blocked[along], axis=axis)
    sheltered: np.ndarray = sides >= LEAST_SIDES
    return sheltered


def _regions(
    number: int, sizes: np.ndarray, sheltered: np.ndarray, at_borders: np.ndarray, voxel_m3: float
) -> tuple[Region, ...]:
    """Return the room with this number, and then the other ones that are large, the largest first."""
    others = np.argsort(-np.maximum(sheltered, 0.01 * sizes), kind="stable")
    large = [k for k in others.tolist() if k != number and sizes[k] * voxel_m3 >= LEAST_M3][
        : MOST_REGIONS - 1
    ]
    return tuple(
        Region(float(sizes[k] * voxel_m3), float(sheltered[k] * voxel_m3), bool(np.isin(k, at_borders)))
        for k in (number, *large[: MOST_REGIONS - 1])
    )


def _at_borders(numbers: np.ndarray) -> np.ndarray:
    """Return the numbers of the regions that reach the border of the voxels: they are outside."""
    sides = [numbers.take(k, axis).ravel() for axis in range(3) for k in (0, -1)]
    return np.unique(np.concatenate(sides))


def _lowest_middle(flyable: np.ndarray) -> np.ndarray:
    """Return x, y, z in voxels of the centre of the lowest layer's voxel that is nearest to its middle."""
    layer = int(flyable.any(axis=(1, 2)).argmax())
    there = np.argwhere(flyable[layer])
    nearest = there[((there - there.mean(axis=0)) ** 2).sum(axis=1).argmin()]
    return np.array((nearest[1], nearest[0], layer)) + 0.5


def _beside(flyable: np.ndarray, blocked: np.ndarray, away: float) -> np.ndarray:
    """Return x, y, z in voxels of a place in the lowest layer that has nothing above, nearest to the middle.

    away: so many voxels to the side nothing is above either; if it is so nowhere, the freest place counts.
    """
    layer = int(flyable.any(axis=(1, 2)).argmax())
    covered = blocked[layer:].any(axis=0)
    if not covered.any():
        return _lowest_middle(flyable)
    free = np.where(flyable[layer], ndimage.distance_transform_edt(~covered), -1.0)
    there = np.argwhere(free >= min(away, free.max()))
    middle = np.argwhere(covered).mean(axis=0)
    nearest = there[((there - middle) ** 2).sum(axis=1).argmin()]
    return np.array((nearest[1], nearest[0], layer)) + 0.5


def _near(
    numbers: np.ndarray,
    index: np.ndarray,
    voxel_m: float,
    corner_m: np.ndarray,
    clearance_m: float,
    home_m: np.ndarray,
) -> tuple[int, np.ndarray]:
    """Return the room above a home that stands on the ground, and where in it the UAV begins.

    Raises:
        SurveyError: the UAV has no room near its home.
    """
    steps = math.ceil((clearance_m + HOME_M) / voxel_m)
    low = np.maximum(index - (0, 1, 1), 0)
    high = np.minimum(index + np.array((steps + 1, 2, 2)), numbers.shape)
    part = numbers[tuple(map(slice, low.tolist(), high.tolist()))]
    there = np.argwhere(part) + low
    if not len(there):
        place = ", ".join(f"{v:.2f}" for v in home_m)
        raise SurveyError(f"The UAV has no room of {clearance_m:.2f} m to each side at its home ({place}).")
    best = there[((there - index) ** 2).sum(axis=1).argmin()]
    return int(numbers[tuple(best)]), (best[::-1] + 0.5) * voxel_m + corner_m
