"""Links: relative poses of two scans that see the same surfaces, measured by aligning them."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.kernels.links import measure_pairs
from gridslam.loop_closure.edges import Edge
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.maps.scan_surfaces import ScanSurfaces

LINK_SIGMA_M, LINK_SIGMA_RAD = 0.005, 0.001
"""Least standard deviations of a link."""
LEAST_COVARIANCE = np.diag([LINK_SIGMA_M**2, LINK_SIGMA_M**2, LINK_SIGMA_RAD**2])


def link_pairs(
    pairs: np.ndarray,
    scans: ScanSurfaces,
    predicted: np.ndarray,
    parameters: LoopClosureParameters,
    is_pass: bool = False,
    most: int | None = None,
) -> list[Edge | None]:
    """Align pairs of nodes' scans; None where too few of the newer one's points fit the older one's.

    Args:
        pairs: (m, 2), the older node and the newer one.
        scans: of these nodes at least.
        predicted: (m, k, 3) poses of the newer node in the older's. The one that makes the most points fit
            counts.
        parameters: the link's.
        is_pass: the nodes are of different passes of a place. The prediction may be wrong by more then, and
            more must fit.
        most: the pairs after this many links are left out (None).
    """
    p, poses, count = parameters, np.array(predicted, float), len(pairs)
    covariances, are_found = np.zeros((count, 3, 3)), np.zeros(count, bool)
    measure_pairs(
        scans.arrays,
        scans.places(pairs),
        poses,
        count if most is None else most,
        (p.link_pass_gate_m if is_pass else 0.0, p.link_gate_m),
        p.link_pass_share_min if is_pass else p.link_share_min,
        p.link_rms_max_m,
        p.match_points,
        p.match_sigma_m,
        covariances,
        are_found,
    )
    found = poses[:, 0].copy()
    found[:, 2] = se2.wrap(found[:, 2])
    return [  # copies, as a view would keep the arrays of all pairs
        Edge(older, newer, pose.copy(), covariance.copy()) if is_found else None
        for (older, newer), pose, covariance, is_found in zip(
            pairs.tolist(), found, covariances + LEAST_COVARIANCE, are_found.tolist()
        )
    ]
