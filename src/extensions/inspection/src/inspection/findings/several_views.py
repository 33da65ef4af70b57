"""Places what several photographs show where their lines of sight cross: the surface of a map may be off.

A line of sight that ends too early, on a voxel before a plate or on a beam that is not there, puts a spot far
from where it is. Where the lines of sight of most photographs come together, it is.
"""

from __future__ import annotations

from typing import Iterator, NamedTuple, Sequence

import numpy as np
from scipy.spatial import cKDTree

from inspection.findings.kinds import kind_of
from inspection.findings.linking import pieces_of
from inspection.findings.placing import Placed

JUMP_M = 0.15
"""Points of one candidate that are farther apart than this lie on two surfaces."""
NEAREST_M = 0.3
"""No surface is nearer to a camera."""
LEAST_ANGLE = np.sin(np.radians(8.0))
"""Lines of sight that differ by less do not tell where they cross."""
SHIFT_M = 0.05
"""A surface that is off by less stays: the poses are no better."""
TIMES = 2
"""Where a spot is put, so many times as many other photographs must see it as on the surface."""
WIDE = 0.5
"""A line of sight to a spot meets the others by this share of its radius farther off."""
LARGE_M = 0.25
"""Radius from which a spot stays on the surface: where its middle is depends on what a photograph shows."""


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
    """Return candidates, each where most photographs see one of its kind; lines stay where they are.

    A candidate with points on two surfaces comes in parts. Each part moves along its line of sight only. One
    that turns out to be too far away is left out.

    gap_m: lines of sight that pass each other by less cross. most_m: greatest distance from the camera.
    """
    moved = [each for each in placed if kind_of(each.kind).is_line]
    for kind in sorted({each.kind for each in placed if not kind_of(each.kind).is_line}):
        spots = [spot for each in placed if each.kind == kind for spot in _on_one_surface(each)]
        votes = Votes(spots, gap_m, most_m)
        depths_m = np.array([votes.depth_m(k) for k in range(len(spots))])
        middles_m = votes.sights.eyes_m + votes.sights.far_m[:, None] * votes.sights.ways
        for k in np.flatnonzero(depths_m <= most_m):
            way, spot = votes.sights.ways[k], spots[k]
            is_there = np.linalg.norm(middles_m - spot.eye_m - depths_m[k] * way, axis=1) < JUMP_M
            facing = [spots[m].normal for m in np.flatnonzero(is_there)] or [spot.normal]
            times = depths_m[k] / votes.sights.far_m[k]
            moved.append(_moved(spot, times, np.mean(facing, axis=0), way))
    return moved


class Votes:
    """Photographs vote on where spots of one kind are. Arguments: as of `where_sights_cross`."""

    def __init__(self, spots: Sequence[Placed], gap_m: float, most_m: float) -> None:
        self.sights, self._gap_m, self._most_m = _sights(spots), gap_m, most_m
        self._is_large = self.sights.wide * self.sights.far_m > LARGE_M
        large = [spots[k] for k in np.flatnonzero(self._is_large)]
        points_m = np.concatenate([np.zeros((0, 3)), *(each.points_m for each in large)])
        self._of_large = np.repeat(
            self.sights.photographs[self._is_large], [len(each.points_m) for each in large]
        )
        self._large = cKDTree(points_m)

    def depth_m(self, k: int) -> float:
        """Return the distance from its camera at which most photographs see what line of sight k shows, m.

        It is that of the surface, unless others cross elsewhere in clearly more photographs; a single one
        must have the spot there on the surface. It may be farther than the greatest distance, which holds for
        the others.
        """
        eye_m, way, surface_m = self.sights.eyes_m[k], self.sights.ways[k], float(self.sights.far_m[k])
        own = self.sights.photographs[k]
        if self._is_large[k]:
            return surface_m
        others = self.sights.only((self.sights.photographs != own) & ~self._is_large)
        own_m, others_m, apart_m, sines = _closest(eye_m, way, others)
        with np.errstate(invalid="ignore"):
            crosses = (sines > LEAST_ANGLE) & (apart_m < self._gap_m) & (own_m > NEAREST_M)
            crosses &= (others_m > NEAREST_M) & (others_m < self._most_m)
            beside = others.only(~(apart_m > self._gap_m + WIDE * others.wide * self._most_m))
        if not crosses.any():
            return surface_m
        most, best_m = TIMES * self._seen_by(eye_m + surface_m * way, beside, own), [surface_m]
        beside_m = beside.eyes_m + beside.far_m[:, None] * beside.ways
        for depth_m in np.sort(own_m[crosses]):
            place_m = eye_m + depth_m * way
            count = self._seen_by(place_m, beside, own)
            if count < max(most, 1) or abs(depth_m - surface_m) <= SHIFT_M:
                continue
            if count == 1 and np.linalg.norm(beside_m - place_m, axis=1).min() > JUMP_M:
                continue  # two lines of sight may cross by chance
            if count > most:
                most, best_m = count, [depth_m]
            elif surface_m not in best_m:
                best_m.append(depth_m)
        return float(best_m[len(best_m) // 2])

    def _seen_by(self, place_m: np.ndarray, others: Sights, own: int) -> int:
        """Return how many photographs, but for the own one, show a spot at a place.

        They do if their lines of sight pass there, or if a large spot of theirs lies there.
        """
        off_m = place_m - others.eyes_m
        along_m = (off_m * others.ways).sum(axis=1)
        aside_m = np.linalg.norm(off_m - along_m[:, None] * others.ways, axis=1)
        sees = (along_m > NEAREST_M) & (along_m < self._most_m)
        sees &= aside_m < self._gap_m + WIDE * others.wide * along_m
        large = self._of_large[self._large.query_ball_point(place_m, self._gap_m)]
        return len({*others.photographs[sees].tolist(), *large.tolist()} - {own})


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
    for own in pieces_of(points_m, JUMP_M):
        yield placed._replace(points_m=points_m[np.sort(own)], area_m2=len(own) / count * placed.area_m2)


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
