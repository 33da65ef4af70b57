"""What a cloud shows near the height of flight, as a level scan for the tracks of what moves."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np

from cepa.dynamic.constants.free_space import (
    SLAB_BEHIND_M,
    SLAB_BINS,
    SLAB_GAP_BINS,
    SLAB_MORE_M,
    SLAB_OWN_M,
    SLAB_RANGE_M,
)
from cepa.dynamic.free_space.kernels.clouds import slab_ranges
from cepa.motion import Cloud, Motion
from cepa.parameters import CepaParameters
from cepa.scan import Beams

HaveStood = Callable[[np.ndarray], np.ndarray]
INCREMENT_RAD = 2.0 * math.pi / SLAB_BINS
ANGLES_RAD = (np.arange(SLAB_BINS) + 0.5) * INCREMENT_RAD - math.pi


class Slab:
    """Reads all channels of a lidar. So what is lower or higher than its level beams is tracked, too.

    The slab reaches a little beyond the UAV's body, and leaves out floor and ceiling. What has stood for long
    above or below the body, such as the sill of a manhole, does not hide what is behind it.
    """

    def __init__(self, parameters: CepaParameters) -> None:
        self._p = parameters

    def beams(self, cloud: Cloud, scan: Beams, motion: Motion, have_stood: HaveStood | None = None) -> Beams:
        """Return the nearest of the slab's points in each direction, along the odometry's axes.

        scan: of the same instant, perhaps of another lidar. What either shows counts (see `_merge`).
        have_stood: tells at which points (n, 3), m, from the lidar something has stood for long (n,).
        """
        p, z = self._p, motion.position_m[2]
        low_m = max(-p.body_below - SLAB_MORE_M, p.floor_height + SLAB_MORE_M - z)
        high_m = min(p.body_above + SLAB_MORE_M, p.ceiling_height - SLAB_MORE_M - z)
        ranges = np.full(SLAB_BINS, math.inf)
        limits = cloud.range_min_m, min(cloud.range_max_m, SLAB_RANGE_M), low_m, high_m
        points = np.asarray(cloud.points_m, np.float32)
        slab_ranges(points, motion.rotation(), *limits, ranges)
        if have_stood is not None:
            own_m = np.full(SLAB_BINS, math.inf)
            own = max(low_m, -p.body_below - SLAB_OWN_M), min(high_m, p.body_above + SLAB_OWN_M)
            slab_ranges(points, motion.rotation(), *limits[:2], *own, own_m)
            _see_past(ranges, own_m, have_stood)
        if scan.nearest < SLAB_RANGE_M:
            met = scan.seen & (scan.ranges < SLAB_RANGE_M)
            angles, range_m = scan.angles[met], scan.ranges[met]
            ends = np.column_stack(
                (range_m * np.cos(angles), range_m * np.sin(angles), np.zeros(len(angles)))
            )
            scan_m = np.full(SLAB_BINS, math.inf)
            slab_ranges(ends.astype(np.float32), motion.rotation(), 0.0, *limits[1:], scan_m)
            _merge(ranges, scan_m)
        seen = np.ones(SLAB_BINS, np.bool_)
        return Beams(ranges, seen, float(ANGLES_RAD[0]), INCREMENT_RAD, float(ranges.min()))


def _merge(ranges: np.ndarray, scan_m: np.ndarray) -> None:
    """Shorten a cloud's ``ranges`` (bins,), m, to those of a planar scan.

    Between the columns of a sparse cloud, a scan looks over a low thing at what is behind it. Such an end
    does not count. Else the thing falls apart, and nobody sees it move.
    """
    between = np.flatnonzero((scan_m < math.inf) & (ranges == math.inf))
    if len(between):
        steps = np.arange(1, SLAB_GAP_BINS + 1)[:, None]
        left_m, right_m = (ranges[(between + way * steps) % SLAB_BINS].min(axis=0) for way in (-1, 1))
        beside_m = np.maximum(left_m, right_m)
        is_past = scan_m[between] > beside_m + SLAB_BEHIND_M
        scan_m[between[is_past]] = beside_m[is_past]
    np.minimum(ranges, scan_m, out=ranges)


def _see_past(ranges: np.ndarray, own_m: np.ndarray, have_stood: HaveStood) -> None:
    """Lengthen ``ranges`` (bins,), m, to those at the body's heights where what hides these has stood."""
    hides = np.flatnonzero((own_m < math.inf) & (own_m > ranges + SLAB_BEHIND_M))
    if not len(hides):
        return
    near_m, angles = ranges[hides], ANGLES_RAD[hides]
    places = np.column_stack((near_m * np.cos(angles), near_m * np.sin(angles), np.zeros(len(hides))))
    past = hides[have_stood(places)]
    ranges[past] = own_m[past]
