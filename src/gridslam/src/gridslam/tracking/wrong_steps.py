"""Which steps of the filter are wrong: odometry and a link between the two scans contradict them."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverses

APART_M, APART_RAD = 0.3, 0.1
"""Steps that differ by less than this never contradict each other."""
CHI_SQUARE_MIN = 25.0
"""A link contradicts a step by at least five standard deviations."""
NEARER = 0.5
"""A link speaks for odometry if it differs from odometry by less than this share of the step's difference."""
MATCH_SIGMA = np.array((0.02, 0.02, 0.005))
"""m, m, rad: to be added to a link's deviations, because the step's match with the map errs, too."""


def apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return how far steps (n, 3) differ (n,), as multiples of APART_M or APART_RAD."""
    error = se2.between(one, other)
    return np.maximum(np.hypot(error[:, 0], error[:, 1]) / APART_M, np.abs(error[:, 2]) / APART_RAD)


def are_wrong(
    steps: np.ndarray, odometry: np.ndarray, links: np.ndarray, covariances: np.ndarray
) -> np.ndarray:
    """Return for each step (n,) whether it is far from its link, and odometry near the link.

    Args:
        steps: (n, 3) of the filter: x, y in m and yaw in rad of a scan's pose in that of the one before.
        odometry: (n, 3) the same by odometry.
        links: (n, 3) the same, measured by aligning the two scans.
        covariances: (n, 3, 3) of the links.
    """
    error = se2.between(links, steps)
    chi_square = np.einsum("ni,nij,nj->n", error, inverses(covariances), error)
    return (
        (apart(links, steps) > 1.0)
        & (chi_square > CHI_SQUARE_MIN)
        & (apart(odometry, links) < NEARER * apart(odometry, steps))
    )
