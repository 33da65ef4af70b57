"""The room in which the UAV flies: the air around the surfaces, and where the body has its clearance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from inspection_tools.errors import SurveyError
from inspection_tools.planning.kernels.distances import REACH_MAX, squared_clearances
from inspection_tools.planning.space import LEAST_NEED

AIR, OTHER = 1, 0
MOST_VOXELS = 120_000_000


@dataclass(frozen=True)
class Room:
    """Voxels, z first. Voxel (i, j, k) begins at corner_m + voxel_m * (k, j, i).

    Attributes:
        voxel_m: side. corner_m: (3,) x, y, z of the first voxel's corner.
        air: (d, h, w) uint8, AIR where light passes and a way leads to the UAV, however narrow.
        flyable: (d, h, w) bool, where the UAV's centre may be and gets to from its home.
        squares: (d, h, w) uint16, squared clearance in voxels, cut beyond what the UAV needs.
        need: least of them that the UAV keeps. home_m: (3,) where it takes off.
    """

    voxel_m: float
    corner_m: np.ndarray
    air: np.ndarray
    flyable: np.ndarray
    squares: np.ndarray
    need: int
    home_m: np.ndarray

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

    def clearances_m(self, places_m: np.ndarray) -> np.ndarray:
        """Return how far places (n, 3) in the air are from what is none, m, to a voxel; 0 elsewhere."""
        return self.at(self.voxel_m * ndimage.distance_transform_edt(self.air == AIR), places_m)


def room_of(
    blocked: np.ndarray, corner_m: np.ndarray, voxel_m: float, clearance_m: float, home_m: np.ndarray | None
) -> Room:
    """Return the room of a UAV among blocked voxels (d, h, w). home_m: None: in the largest closed one.

    Raises:
        SurveyError: the UAV fits nowhere, or not at its home.
    """
    need = max(math.ceil((clearance_m / voxel_m) ** 2 - 1e-9), LEAST_NEED)
    reach = min(math.isqrt(need) + 2, REACH_MAX)
    squares = squared_clearances(blocked, reach)
    fits = squares >= need
    numbers, count = ndimage.label(fits)
    if not count:
        raise SurveyError(
            f"A UAV that needs {clearance_m:.2f} m to each side fits nowhere: give another radius or margin."
        )
    if home_m is None:
        sizes = np.bincount(numbers.ravel())
        sizes[0] = 0
        closed = sizes.copy()
        closed[_at_borders(numbers)] = 0
        sizes = closed if closed.any() else sizes
        number = int(sizes.argmax())
        flyable = numbers == number
        home_m = _lowest_middle(flyable) * voxel_m + corner_m
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
    return Room(voxel_m, np.asarray(corner_m, float), air, flyable, squares, need, home_m)


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
    steps = math.ceil((clearance_m + 0.5) / voxel_m)
    low = np.maximum(index - (0, 1, 1), 0)
    high = np.minimum(index + np.array((steps + 1, 2, 2)), numbers.shape)
    part = numbers[tuple(map(slice, low.tolist(), high.tolist()))]
    there = np.argwhere(part) + low
    if not len(there):
        place = ", ".join(f"{v:.2f}" for v in home_m)
        raise SurveyError(f"The UAV has no room of {clearance_m:.2f} m to each side at its home ({place}).")
    best = there[((there - index) ** 2).sum(axis=1).argmin()]
    return int(numbers[tuple(best)]), (best[::-1] + 0.5) * voxel_m + corner_m
