"""A scan as the kernels' input: in cells, in the base frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.surfaces import surface_normals, thin_out
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

BEAMS_MAX = 2000
"""The map gets all beams of a scan with at most this many. Of more beams, it gets the means of neighbours, as
scan matching does."""
THIN_SPACING = 0.5
"""Cells: beams that end within this on one surface are averaged for scan matching."""
THIN_DEPTH = 2.0
"""Cells: greatest difference of their ranges."""
BACK_STEP = math.sqrt(2.0)
"""Cells: where a beam fits, the cell this much before its end is not occupied."""
ALONG_WEIGHT = 0.0
"""Weight of an offset along a flat surface; across it: 1. The map has only samples of the surface, so this
offset says nothing. Any weight would hold the pose where the search began, against odometry."""
NOT_MATCHED = np.empty((0, 7))


class Directions(NamedTuple):
    """Where the beams of scans with the same angles point, in ascending order."""

    order: np.ndarray
    """(n,) the scan's beams in this order."""
    bearings: np.ndarray
    """(n,) rad"""
    units: np.ndarray
    """(n, 2) unit vectors."""

    @classmethod
    def of(cls, angles_rad: np.ndarray) -> Directions:
        """Return the directions of beams at these angles (n,)."""
        order = np.argsort(angles_rad, kind="stable")
        bearings = angles_rad[order]
        return cls(order, bearings, _units(bearings))


@dataclass(frozen=True, eq=False)
class Beams:
    """One scan's beams, in cells and in the base frame."""

    lidar: np.ndarray
    """(2,) where the beams begin."""
    ends: np.ndarray
    """(n, 2) their ends, cut off at maxUrange."""
    hits: np.ndarray
    """(n,) bool: whether a beam ends at something."""
    matching: np.ndarray
    """(m, 7) the hits for scan matching, see kernels/nearest.py; none if the scan is not matched."""

    @classmethod
    def from_scan(
        cls,
        scan: PlanarScan,
        parameters: SlamParameters,
        is_matched: bool = True,
        directions: Directions | None = None,
    ) -> Beams:
        """Prepare a scan; readings beyond maxRange are left out.

        Args:
            scan: of any lidar.
            parameters: the filter's.
            is_matched: the beams are not only for a map.
            directions: of the scan's angles; None: they are not known yet.
        """
        usable, greatest = parameters.ranges_for(scan.range_max_m)
        order, bearings, units = directions or Directions.of(scan.angles_rad)
        ranges = scan.ranges_m[order]
        valid = (ranges <= greatest) & (ranges > 0.0)
        bearings, units, ranges = bearings[valid], units[valid], ranges[valid]
        scale = 1.0 / parameters.delta
        lidar = np.array(scan.lidar_in_base) * (scale, scale, 1.0)
        hits, ranges = ranges <= usable, np.minimum(ranges, usable) * scale
        matching = NOT_MATCHED
        if is_matched:
            matching = _matching_beams(bearings[hits], ranges[hits], lidar, parameters.lskip + 1)
        if len(ranges) > BEAMS_MAX:
            kept = [_thinned(bearings[each], ranges[each]) for each in (hits, ~hits)]
            bearings, ranges = np.concatenate(kept, axis=1)
            hits, units = np.arange(len(ranges)) < len(kept[0][0]), _units(bearings)
        ends = se2.transform(lidar, ranges[:, None] * units)
        return cls(lidar[:2].copy(), ends, hits, matching)

    @classmethod
    def none(cls) -> Beams:
        """Return a scan without beams."""
        return cls(np.zeros(2), np.empty((0, 2)), np.zeros(0, bool), NOT_MATCHED)


def beams_for_map(scans: Sequence[PlanarScan | None], parameters: SlamParameters) -> list[Beams]:
    """Return what each scan enters into a map: nothing for None.

    Scans in a row that share their angles share the work on these, and one that comes again is the same.
    """
    found: list[Beams] = []
    last: PlanarScan | None = None
    directions, none = Directions.of(np.empty(0)), Beams.none()
    for scan in scans:
        if scan is None:
            found.append(none)
            continue
        if last is None or scan.angles_rad is not last.angles_rad:
            directions = Directions.of(scan.angles_rad)
        is_again = scan is last and found[-1] is not none
        found.append(found[-1] if is_again else Beams.from_scan(scan, parameters, False, directions))
        last = scan
    return found


def _units(bearings: np.ndarray) -> np.ndarray:
    return np.stack((np.cos(bearings), np.sin(bearings)), axis=1)


def _points(bearings: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    return ranges[:, None] * _units(bearings)


def _thinned(bearings: np.ndarray, ranges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means of neighbouring beams that end close together; ranges in cells."""
    thin_bearings, thin_ranges = np.empty_like(bearings), np.empty_like(ranges)
    count = thin_out(bearings, ranges, THIN_SPACING, THIN_DEPTH, thin_bearings, thin_ranges)
    return thin_bearings[:count], thin_ranges[:count]


def _matching_beams(bearings: np.ndarray, ranges: np.ndarray, lidar: np.ndarray, every: int) -> np.ndarray:
    """Return (m, 7): ends, steps, normals, and the weight along the surface."""
    bearings, ranges = _thinned(bearings, ranges)
    points, count = _points(bearings, ranges), len(bearings)
    normals, flat = np.empty_like(points), np.empty(count, np.bool_)
    surface_normals(points, np.empty(count, np.bool_), normals, flat, True)
    turn = (0.0, 0.0, lidar[2])
    beams = np.empty((count, 7))
    beams[:, 0:2] = se2.transform(lidar, points)
    beams[:, 2:4] = se2.transform(turn, _points(bearings, np.full(count, BACK_STEP)))
    beams[:, 4:6] = se2.transform(turn, normals)
    beams[:, 6] = np.where(flat, ALONG_WEIGHT, 1.0)
    return np.ascontiguousarray(beams[::every])
