"""The improved proposal: draws poses from the Gaussian of motion and scan (2007, section III-B).

The paper samples the product of both densities around the scan matcher's mode. The samples give its mean and
covariance. Here the optimiser gives both: the product's maximum, and the inverse of its information.
"""

from __future__ import annotations

import numpy as np

from gridslam.filter.scan_matcher import BEAM_DEVIATION_M, Matches
from gridslam.kernels.least_squares import scatter

SPREAD = 1.0
"""Number of deviations by which particles are scattered."""


def propose(matches: Matches, noise: np.ndarray, delta_m: float) -> np.ndarray:
    """Return poses (particles, 3), in cells and rad, from standard normal noise (particles, 3)."""
    poses = matches.poses.copy()
    scatter(matches.factors, noise * (SPREAD * BEAM_DEVIATION_M / delta_m), poses)
    return poses
