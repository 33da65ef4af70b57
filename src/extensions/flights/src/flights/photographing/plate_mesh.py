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
