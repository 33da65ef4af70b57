"""Plates of an explored map in place of the faces of its voxels."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from gridslam.volume.plates import Plates

THICK_M = 0.03
"""Of a plate that was seen from one side only."""
BEHIND_VOXELS = (0.5, 1.0, 1.5, 2.0)
"""A plate is thin if there is air so far behind it, or one voxel beside that place: a web has a wall at its
foot."""
AIRY = 12
"""Air is a free voxel if so many of the 27 voxels around it, with itself, are free: as in a corner of three
plates. A layer of single voxels behind a wall is noise."""
SEEN_M, BESIDE_VOXELS = 0.05, 0.6
"""A plate is the back of another one if it is not so far before it, and no farther beside it."""
NEAR_VOXELS, OFF_VOXELS, COUNT = 1.8, 1.1, 24
"""A face of a voxel is that of a plate if one of so many plates is so near, and its plane nearer still."""
ACROSS = (-0.375, -0.125, 0.125, 0.375)
"""Places on a plate, as shares of its sides from its middle."""
THROUGH_VOXELS = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""One sees through a plate at a place if the voxels so far before and behind it are free."""
SOLID_M = 0.045
"""One does not see through a place so near to a point of a cloud."""
BARS_M, HOLES = 0.45, 0.1
"""Plates are bars where, so far around, one sees through so many of their places."""
AWAY, OPPOSITE = -0.2, -0.8
"""Cosine between the normals of a face and a plate that is not its; and of the two sides of one."""


@dataclass(frozen=True)
class Kinds:
    """Kinds of voxels (x, y, z). low_m: (3,) where the first one begins."""

    values: np.ndarray
    low_m: np.ndarray
    side_m: float

    def at(self, places_m: np.ndarray, values: np.ndarray | None = None) -> np.ndarray:
        """Return the values of the voxels with places (n, 3); 0 outside."""
        values = self.values if values is None else values
        index = np.floor((places_m - self.low_m) / self.side_m).astype(np.int64)
        inside = ((index >= 0) & (index < values.shape)).all(axis=1)
        found = np.zeros(len(index), values.dtype)
        found[inside] = values[tuple(index[inside].T)]
        return found


def standing(plates: Plates, kinds: Kinds, occupied: int) -> Plates:
    """Return the plates beside which a voxel is occupied: others have gone since they were seen."""
    grown = ndimage.maximum_filter(kinds.values == occupied, 3)
    return plates.only(kinds.at(plates.centres_m, grown))


def with_backs(plates: Plates, kinds: Kinds, free: int) -> Plates:
    """Return the plates, and the backs of those that have air behind them and whose backs nobody has seen."""
    centres, normals = plates.centres_m, plates.normals
    along = np.argmin(np.abs(normals), axis=1)
    first = np.cross(normals, np.eye(3)[along])
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normals, first)
    is_free = kinds.values == free
    air = is_free & (27.0 * ndimage.uniform_filter(is_free.astype(np.float32), 3) > AIRY - 0.5)
    has_air = np.zeros(len(plates), bool)
    for voxels, i, j in itertools.product(BEHIND_VOXELS, (-1, 0, 1), (-1, 0, 1)):
        way = i * first + j * second - voxels * normals
        has_air |= kinds.at(centres + kinds.side_m * way, air)
    one, other = _pairs(centres, centres, NEAR_VOXELS * kinds.side_m)
    faces = (normals[one] * normals[other]).sum(axis=1) < OPPOSITE
    off_m = ((centres[other] - centres[one]) * normals[one]).sum(axis=1)
    across_m = np.sqrt(np.maximum(((centres[other] - centres[one]) ** 2).sum(axis=1) - off_m**2, 0.0))
    is_back = faces & (off_m < SEEN_M) & (across_m < BESIDE_VOXELS * kinds.side_m)
    has_back = np.zeros(len(plates), bool)
    has_back[one[is_back]] = True
    those = has_air & ~has_back
    backs = plates.corners_m[those][:, ::-1] - THICK_M * normals[those][:, None]
    return Plates(np.concatenate((plates.corners_m, backs)), np.concatenate((normals, -normals[those])))


def are_bars(plates: Plates, kinds: Kinds, free: int, points_m: np.ndarray) -> np.ndarray:
    """Return which plates (n,) are bars, as a ladder's: around them one sees through their plane.

    points_m: (k, 3) of the clouds. A thin web may be free in the map, but not without points.
    """
    holes, centres_m, normals = _holes(plates, kinds, free, points_m), plates.centres_m, plates.normals
    one, other = cKDTree(centres_m).query_pairs(BARS_M, output_type="ndarray").T
    off_m = np.abs(((centres_m[other] - centres_m[one]) * normals[one]).sum(axis=1))
    joined = (np.abs((normals[one] * normals[other]).sum(axis=1)) > -OPPOSITE) & (off_m < 0.5 * kinds.side_m)
    one, other = one[joined], other[joined]
    count = len(plates)

    def around(values: np.ndarray) -> np.ndarray:
        sums = values + np.bincount(one, values[other], count) + np.bincount(other, values[one], count)
        return np.asarray(sums)

    core = around(holes) >= HOLES * around(np.ones(count))
    return around(core.astype(float)) > 0.0


def _holes(plates: Plates, kinds: Kinds, free: int, points_m: np.ndarray) -> np.ndarray:
    """Return (n,) the share of each plate's places at which one sees through it."""
    points = cKDTree(points_m)
    first, third = plates.corners_m[:, 0], plates.corners_m[:, 2]
    along, up = plates.corners_m[:, 1] - first, plates.corners_m[:, 3] - first
    holes = np.zeros(len(plates))
    for i, j in itertools.product(ACROSS, ACROSS):
        place_m = 0.5 * (first + third) + i * along + j * up
        is_hole = np.ones(len(plates), bool)
        for voxels in THROUGH_VOXELS:
            is_hole &= kinds.at(place_m + voxels * kinds.side_m * plates.normals) == free
        is_hole[is_hole] = points.query(place_m[is_hole], distance_upper_bound=SOLID_M)[0] > SOLID_M
        holes += is_hole / len(ACROSS) ** 2
    return holes


def beside(plates: Plates, faces_m: np.ndarray, side_m: float) -> np.ndarray:
    """Return which faces (n, 4, 3) of voxels lie near a plate, however they face."""
    one, _ = _pairs(faces_m.mean(axis=1), plates.centres_m, NEAR_VOXELS * side_m)
    are_near = np.zeros(len(faces_m), bool)
    are_near[one] = True
    return are_near


def not_of(plates: Plates, faces_m: np.ndarray, side_m: float) -> np.ndarray:
    """Return which faces (n, 4, 3) of voxels belong to no plate."""
    middles = faces_m.mean(axis=1)
    across = np.cross(faces_m[:, 2] - faces_m[:, 0], faces_m[:, 3] - faces_m[:, 1])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-12)[:, None]
    one, other = _pairs(middles, plates.centres_m, NEAR_VOXELS * side_m)
    towards = plates.normals[other]
    off_m = ((middles[one] - plates.centres_m[other]) * towards).sum(axis=1)
    belongs = (np.abs(off_m) < OFF_VOXELS * side_m) & ((across[one] * towards).sum(axis=1) > AWAY)
    left = np.ones(len(faces_m), bool)
    left[one[belongs]] = False
    return left


def _pairs(places_m: np.ndarray, others_m: np.ndarray, apart_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (k,) of places and of the nearest others, at most so far apart."""
    _, found = cKDTree(others_m).query(places_m, COUNT, distance_upper_bound=apart_m)
    one, column = np.nonzero(found < len(others_m))
    return one, found[one, column]
