"""What a cloud shows near the height of flight, as a level scan for the tracks of what moves."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.free_space import SLAB_BINS, SLAB_MORE_M, SLAB_RANGE_M
from cepa.dynamic.free_space.kernels.clouds import slab_ranges
from cepa.motion import Cloud, Motion
from cepa.parameters import CepaParameters
from cepa.scan import Beams


class Slab:
    """Reads all channels of a lidar. So what is lower or higher than its level beams is tracked, too.

    The slab reaches a little beyond the UAV's body, and leaves out floor and ceiling.
    """

    def __init__(self, parameters: CepaParameters) -> None:
        self._p = parameters

    def beams(self, cloud: Cloud, scan: Beams, motion: Motion) -> Beams:
        """Return the nearest of the slab's points in each direction, along the odometry's axes.

        scan: of the same instant, perhaps of another lidar. What either shows counts.
        """
        p, z = self._p, motion.position_m[2]
        low_m = max(-p.body_below - SLAB_MORE_M, p.floor_height + SLAB_MORE_M - z)
        high_m = min(p.body_above + SLAB_MORE_M, p.ceiling_height - SLAB_MORE_M - z)
        ranges = np.full(SLAB_BINS, math.inf)
        limits = cloud.range_min_m, min(cloud.range_max_m, SLAB_RANGE_M), low_m, high_m
        points = np.asarray(cloud.points_m, np.float32)
        slab_ranges(points, motion.rotation(), *limits, ranges)
        if scan.nearest < SLAB_RANGE_M:
            met = scan.seen & (scan.ranges < SLAB_RANGE_M)
            angles, range_m = scan.angles[met], scan.ranges[met]
            ends = np.column_stack(
                (range_m * np.cos(angles), range_m * np.sin(angles), np.zeros(len(angles)))
            )
            slab_ranges(ends.astype(np.float32), motion.rotation(), 0.0, *limits[1:], ranges)
        increment_rad = 2.0 * math.pi / SLAB_BINS
        seen = np.ones(SLAB_BINS, np.bool_)
        return Beams(ranges, seen, 0.5 * increment_rad - math.pi, increment_rad, float(ranges.min()))
