"""Places what several photographs show where their lines of sight cross: the surface of a map may be off.

A line of sight that ends too early, on a voxel before a plate or on a beam that is not there, puts a spot far
from where it is. Where the lines of sight of most photographs come together, it is.
"""

from __future__ import annotations

from typing import Iterator, NamedTuple, Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from inspection_tools.findings.placing import Placed

JUMP_M = 0.15
"""Points of one candidate that are farther apart than this lie on two surfaces."""
NEAREST_M = 0.3
"""No surface is nearer to a camera."""
LEAST_ANGLE = np.sin(np.radians(8.0))
"""Lines of sight that differ by less do not tell where they cross."""
SHIFT_M = 0.05
"""A surface that is off by less stays: the poses are no better."""
FAR_SHIFT_M = 1.0
"""Farther than this from the surface, one other photograph is not enough."""
TIMES = 2
"""Where a spot is put, so many times as many other photographs must see it as on the surface."""
WIDE = 0.5
"""A line of sight to a large spot meets the others by this share of its radius farther off."""


class Sights(NamedTuple):
    """Lines of sight to the middles of spots.

    eyes_m: (n, 3). ways: (n, 3), unit. far_m: (n,), to the surface. wide: (n,), radius of each spot, rad.
    photographs: (n,), a number for each.
    """

    eyes_m: np.ndarray
    ways: np.ndarray
    far_m: np.ndarray
    wide: np.ndarray
    photographs: np.ndarray

    def only(self, are_meant: np.ndarray) -> Sights:
        """Return some of them."""
        return Sights(*(each[are_meant] for each in self))


def where_sights_cross(placed: Sequence[Placed], gap_m: float, most_m: float) -> list[Placed]:
    """Return candidates, each where most photographs see one of its kind; cracks stay where they are.

    A candidate with points on two surfaces comes in parts. Each part moves along its line of sight only. One
    that turns out to be too far away is left out.

    gap_m: lines of sight that pass each other by less cross. most_m: greatest distance from the camera.
    """
    moved = [each for each in placed if each.kind == "crack"]
    for kind in sorted({each.kind for each in placed} - {"crack"}):
        spots = [spot for each in placed if each.kind == kind for spot in _on_one_surface(each)]
        sights = _sights(spots)
        middles_m = sights.eyes_m + sights.far_m[:, None] * sights.ways
        for k, spot in enumerate(spots):
            far_m = depth_of(sights, k, gap_m, most_m)
            if far_m > most_m:
                continue
            place_m = sights.eyes_m[k] + far_m * sights.ways[k]
            is_there = np.linalg.norm(middles_m - place_m, axis=1) < JUMP_M
            facing = np.mean([spots[m].normal for m in np.flatnonzero(is_there)] or [spot.normal], axis=0)
            moved.append(_moved(spot, far_m / sights.far_m[k], facing, sights.ways[k]))
    return moved


def depth_of(sights: Sights, k: int, gap_m: float, most_m: float) -> float:
    """Return the distance from its camera, m, at which most photographs see what line of sight k shows.

    It is that of the surface, unless others cross elsewhere in clearly more photographs. It may be farther
    than most_m, which holds for the others.
    """
    eye_m, way, on_surface_m = sights.eyes_m[k], sights.ways[k], float(sights.far_m[k])
    others = sights.only(sights.photographs != sights.photographs[k])
    own_m, others_m, apart_m, sines = _closest(eye_m, way, others)
    with np.errstate(invalid="ignore"):
        crosses = (sines > LEAST_ANGLE) & (apart_m < gap_m)
        crosses &= (own_m > NEAREST_M) & (others_m > NEAREST_M) & (others_m < most_m)
    if not crosses.any():
        return on_surface_m

    def seen_by(depth_m: float) -> int:
        place_m = eye_m + depth_m * way
        off_m = place_m - others.eyes_m
        along_m = (off_m * others.ways).sum(axis=1)
        aside_m = np.linalg.norm(off_m - along_m[:, None] * others.ways, axis=1)
        sees = (along_m > NEAREST_M) & (along_m < most_m)
        sees &= aside_m < gap_m + WIDE * others.wide * along_m
        return len(np.unique(others.photographs[sees]))

    most, best_m = TIMES * seen_by(on_surface_m), [on_surface_m]
    for depth_m in np.sort(own_m[crosses]):
        shift_m, count = abs(depth_m - on_surface_m), seen_by(depth_m)
        if shift_m > SHIFT_M and (shift_m <= FAR_SHIFT_M or count > 1):
            if count > most:
                most, best_m = count, [depth_m]
            elif count == most and on_surface_m not in best_m:
                best_m.append(depth_m)
    return float(best_m[len(best_m) // 2])


def _closest(
    eye_m: np.ndarray, way: np.ndarray, others: Sights
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return where a line is closest to each other one; NaN if they are parallel.

    Returns: how far along the line, how far along the others, their distance there, m; sines between them.
    """
    cosines = others.ways @ way
    squares = 1.0 - cosines**2
    between_m = others.eyes_m - eye_m
    a, b = between_m @ way, (between_m * others.ways).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        own_m, others_m = (a - b * cosines) / squares, (a * cosines - b) / squares
        off_m = between_m + others_m[:, None] * others.ways - own_m[:, None] * way
    return own_m, others_m, np.linalg.norm(off_m, axis=1), np.sqrt(np.maximum(squares, 0.0))


def _on_one_surface(placed: Placed) -> Iterator[Placed]:
    """Yield the parts of a candidate between which its points jump, with their shares of its area."""
    points_m, count = placed.points_m, len(placed.points_m)
    pairs = cKDTree(points_m).query_pairs(JUMP_M, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    parts, of = connected_components(graph, directed=False)
    for number in range(parts):
        own = of == number
        yield placed._replace(points_m=points_m[own], area_m2=float(own.mean()) * placed.area_m2)


def _sights(spots: Sequence[Placed]) -> Sights:
    eyes_m = np.array([each.eye_m for each in spots])
    ways = np.array([each.points_m.mean(axis=0) for each in spots]) - eyes_m
    far_m = np.linalg.norm(ways, axis=1)
    ways /= far_m[:, None]
    aside_m = [
        np.cross(each.points_m - eye_m, way) for each, eye_m, way in zip(spots, eyes_m, ways)
    ]  # fmt: skip
    wide = np.array([np.sqrt((each**2).sum(axis=1).mean()) for each in aside_m]) / far_m
    names = np.unique([each.photograph for each in spots], return_inverse=True)[1]
    return Sights(eyes_m, ways, far_m, wide, names)


def _moved(spot: Placed, times: float, facing: np.ndarray, way: np.ndarray) -> Placed:
    """Return a spot so many times as far from its camera, on a surface that faces there."""
    if times == 1.0:
        return spot
    normal = facing / max(float(np.linalg.norm(facing)), 1e-9)
    flatter = max(float(-spot.normal @ way), 0.1) / max(float(-normal @ way), 0.1)
    points_m = spot.eye_m + times * (spot.points_m - spot.eye_m)
    area_m2, detail_mm = times**2 * flatter * spot.area_m2, times * flatter * spot.detail_mm
    return spot._replace(points_m=points_m, normal=normal, area_m2=area_m2, detail_mm=detail_mm)
