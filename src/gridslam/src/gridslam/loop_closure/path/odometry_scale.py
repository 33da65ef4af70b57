"""Learns from links of scans how long odometry's metre is.

If wheels are larger than assumed, or an optical flow sees a floor that is nearer, every way of odometry is
wrong by the same share. Scans measure it wherever they see enough. So odometry is right in bare
corridors, too, where nothing but odometry tells how far the vehicle has come. Compare A. Censi et al.,
"Simultaneous calibration of odometry and sensor parameters for mobile robots" (T-RO 2013).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gridslam import se2
from gridslam.loop_closure.edges import Edges

WAY_MIN_M, LINKS_MIN = 0.3, 20
"""Shorter ways, and fewer links, tell nothing. Nor do links that are less certain than odometry."""
SCALE_SIGMA = 0.05
"""Standard deviation of the scale before any link is known. The mean is 1."""
HUBER, ROUNDS = 1.3, 10
"""From this many standard deviations on, a link loses weight; rounds of weighing them."""


class Scale(NamedTuple):
    """By what odometry's ways are to be multiplied, and the standard deviation of that."""

    mean: float = 1.0
    sigma: float = SCALE_SIGMA

    @property
    def share_off(self) -> float:
        """How much of its way odometry may err by, as it is: what is known of its scale, and what is not."""
        return math.hypot(self.mean - 1.0, self.sigma)


UNKNOWN_SCALE = Scale()


def odometry_scale(links: Edges, odometry: np.ndarray, m_per_sqrt_m: float, links_per_scan: int) -> Scale:
    """Return odometry's scale as links tell it.

    Args:
        links: of scans with those just before them.
        odometry: (k, 3) poses of the base in the odometry's frame, at the nodes.
        m_per_sqrt_m: odometry's standard deviation after one metre, without its scale.
        links_per_scan: so many links span the same way, and count as one.
    """
    measured = se2.between(odometry[links.older], odometry[links.newer])
    way_m = np.hypot(measured[:, 0], measured[:, 1])
    along = measured[:, :2] / np.maximum(way_m, 1e-9)[:, None]
    ratios = (links.newer_in_older[:, :2] * along).sum(axis=1) / np.maximum(way_m, 1e-9)
    # The covariance is in the newer scan's frame.
    turned = se2.transform_each(links.newer_in_older * (0.0, 0.0, -1.0), along)
    by_link = np.einsum("ni,nij,nj->n", turned, links.covariance[:, :2, :2], turned)
    by_odometry = m_per_sqrt_m**2 * way_m
    kept = (way_m > WAY_MIN_M) & (by_link < by_odometry)
    if np.count_nonzero(kept) < LINKS_MIN:
        return UNKNOWN_SCALE
    weights = way_m[kept] ** 2 / (by_link + by_odometry)[kept]
    return _robust_mean(ratios[kept], weights / links_per_scan)


def _robust_mean(values: np.ndarray, weights: np.ndarray) -> Scale:
    """Return the mean of values with these weights, inverse variances, and of 1 with `SCALE_SIGMA`."""
    mean, known, firmness = 1.0, 1.0 / SCALE_SIGMA**2, np.sqrt(weights)
    shares = np.ones_like(values)
    for _ in range(ROUNDS):
        mean = (known + (shares * weights) @ values) / (known + shares @ weights)
        off = firmness * np.abs(values - mean)
        shares = np.minimum(1.0, HUBER * 1.48 * np.median(off) / np.maximum(off, 1e-12))
    return Scale(float(mean), 1.0 / math.sqrt(known + float(shares @ weights)))
