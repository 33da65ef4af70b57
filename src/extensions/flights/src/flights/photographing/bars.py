"""Bars of an explored map, as a ladder's: beams went through the plates that were fitted to them."""

from __future__ import annotations

from typing import Iterable, NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from gridslam.volume import CloudNode
from gridslam.volume.plates import Plates

EVERY = 3
"""One of so many beams is followed."""
AT_M, BEYOND_M = 0.06, 0.12
"""A beam that ends so near a plate's plane has met the plate; one that ends so far behind it went through."""
FLAT = 0.2
"""A beam counts if the sine of its angle with the plane is greater. A pose that is off moves others far."""
PLATES, ON_M = 6, 0.01
"""A beam is followed through so many plates, and goes on so far behind each."""
AROUND_M, OFF_M, ALIKE = 0.45, 0.1, 0.8
"""Plates go together up to this distance, if they are so little off one plane, and face so much alike."""
OPEN, WIDE_M = 0.65, 0.1
"""Plates are bars if so many of the beams around them went through, and if those that go together spread so
much, as a standard deviation, also across their longest way. Beside a stanchion beams pass, too."""
PASSED = 0.1
"""Plates beside those are bars, too, whichever way they face, if more of the beams on them went through. The
deck at a ladder's foot is none."""
THICK = 0.5
"""Side of a bar's cube, as a share of the voxel's. Between the cubes one sees their other sides, too."""


class Beams(NamedTuple):
    """Beams (n,) that went through each plate, and that met it."""

    through: np.ndarray
    met: np.ndarray


def beams_on(plates: Plates, nodes: Iterable[CloudNode], every: int = EVERY) -> Beams:
    """Return how many beams of clouds, where they are in the map, met plates or went through."""
    count = len(plates)
    through, met = np.zeros(count, np.int64), np.zeros(count, np.int64)
    if not count:
        return Beams(through, met)
    scene = EmbreeScene()
    corners = plates.corners_m[:, [0, 1, 2, 0, 2, 3]].astype(np.float32)
    TriangleMesh(scene, corners.reshape(-1, 3, 3))
    for node in nodes:
        pose = node.sensor_in_map
        ways = node.cloud.points()[::every] @ pose.rotation.T.astype(np.float32)
        range_m = np.linalg.norm(ways, axis=1)
        is_long = range_m > AT_M
        range_m, ways = range_m[is_long], ways[is_long] / range_m[is_long, None]
        gone_m = np.zeros(len(ways), np.float32)
        for _ in range(PLATES):
            if not len(ways):
                break
            begins = pose.translation.astype(np.float32) + gone_m[:, None] * ways
            hits = scene.run(begins, np.ascontiguousarray(ways), output=True)
            there_m, plate = gone_m + hits["tfar"], hits["primID"] // 2
            sine = np.abs((plates.normals[plate] * ways).sum(axis=1))
            behind_m = np.where(hits["primID"] >= 0, (range_m - there_m) * sine, -np.inf)
            is_steep = sine > FLAT
            through += np.bincount(plate[is_steep & (behind_m > BEYOND_M)], minlength=count)
            met += np.bincount(plate[is_steep & (np.abs(behind_m) < AT_M)], minlength=count)
            goes_on = behind_m > AT_M
            ways, range_m, gone_m = ways[goes_on], range_m[goes_on], there_m[goes_on] + ON_M
    return Beams(through, met)


def are_bars(plates: Plates, beams: Beams) -> np.ndarray:
    """Return which plates (n,) are bars: those that one sees through, and those beside them in their plane.

    Of the latter those count that face the same way, and those that some beams passed, as the sides of rails.
    """
    count, centres_m, normals = len(plates), plates.centres_m, plates.normals
    pairs = cKDTree(centres_m).query_pairs(AROUND_M, output_type="ndarray")
    own = np.repeat(np.arange(count), 2).reshape(-1, 2)
    one, other = np.concatenate((pairs, pairs[:, ::-1], own)).T
    is_beside = np.abs(((centres_m[other] - centres_m[one]) * normals[one]).sum(axis=1)) < OFF_M
    one, other = one[is_beside], other[is_beside]
    is_alike = np.abs((normals[one] * normals[other]).sum(axis=1)) > ALIKE
    alike = _sums(one[is_alike], other[is_alike], count)
    all_beams = beams.through + beams.met
    is_open = alike @ beams.through > OPEN * (alike @ all_beams)
    is_middle = is_open & (_across_m(alike, centres_m) > WIDE_M)
    is_passed = beams.through > PASSED * all_beams
    found = np.zeros(count, bool)
    found[other[is_middle[one] & (is_alike | is_passed[other])]] = True
    return found


def _sums(one: np.ndarray, other: np.ndarray, count: int) -> csr_matrix:
    """Return the matrix (count, count) that adds up, for each one, the values of the others."""
    return csr_matrix((np.ones(len(one)), (one, other)), shape=(count, count))


def _across_m(together: csr_matrix, places_m: np.ndarray) -> np.ndarray:
    """Return (n,) how far places (n, 3) that are together spread across their longest way, m."""
    numbers = np.asarray(together.sum(axis=1))
    middles_m = together @ places_m / numbers
    products = (places_m[:, :, None] * places_m[:, None]).reshape(len(places_m), 9)
    spread = (together @ products / numbers).reshape(-1, 3, 3) - middles_m[:, :, None] * middles_m[:, None]
    return np.sqrt(np.maximum(np.linalg.eigvalsh(spread)[:, 1], 0.0))


def cubes_of(
    faces_m: np.ndarray, side_m: float, low_m: np.ndarray, points_m: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return corners (8 n, 3) and quads (6 n, 4), which face out, of a cube for each voxel of bars.

    It is where the voxel's points are, in the mean; without points in its middle.

    faces_m: (k, 4, 3) of the voxels, which face away from them. low_m: (3,) a corner of one.
    """
    across = np.cross(faces_m[:, 1] - faces_m[:, 0], faces_m[:, 3] - faces_m[:, 0])
    inside_m = faces_m.mean(axis=1) - 0.5 * across / side_m
    voxels = np.unique(np.floor((inside_m - low_m) / side_m).astype(np.int64), axis=0)
    middles_m = low_m + side_m * (voxels + 0.5)
    apart_m, voxel = cKDTree(middles_m).query(points_m, p=np.inf, distance_upper_bound=0.5 * side_m)
    points_m, voxel = points_m[np.isfinite(apart_m)], voxel[np.isfinite(apart_m)]
    numbers = np.bincount(voxel, minlength=len(voxels))
    sums_m = np.stack([np.bincount(voxel, points_m[:, k], len(voxels)) for k in range(3)], axis=1)
    middles_m[numbers > 0] = sums_m[numbers > 0] / numbers[numbers > 0, None]
    corner = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = np.array(((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)))
    corners_m = middles_m[:, None] + THICK * side_m * corner
    of_cubes = quads + len(corner) * np.arange(len(voxels))[:, None, None]
    return corners_m.reshape(-1, 3), of_cubes.reshape(-1, 4)
