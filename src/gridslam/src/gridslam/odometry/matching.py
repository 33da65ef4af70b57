"""The pose at which a scan fits the local map and the prediction best, and what the scan tells of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam.kernels.least_squares import add_prior, factor, linearise, solve
from gridslam.kernels.nearest import NearestPoints
from gridslam.odometry.local_map import LocalMap
from gridslam.odometry.parameters import LidarOdometryParameters

LOOKS, STEPS = 6, 2
"""The nearest surfaces are searched for so often at most, with so many Gauss-Newton steps after each."""
CONVERGED_M, CONVERGED_RAD = 2e-4, 5e-5


@dataclass(frozen=True)
class ScanMatch:
    """A match of one scan."""

    pose: np.ndarray
    """(3,) x, y, yaw in the odometry's frame: the most likely one by scan and prediction."""
    information: np.ndarray
    """(3, 3) that the scan alone gives; 0 along a direction that it does not tell."""
    untold: np.ndarray
    """(k, 2) unit vectors of the directions that it does not tell, k 0 to 2."""
    share: float
    """Of the beams that found the local map."""
    newness: float
    """1 / (number of keyframes that have seen the same surfaces), mean over these beams."""


def match(
    local_map: LocalMap,
    beams: np.ndarray,
    predicted: np.ndarray,
    covariance: np.ndarray,
    parameters: LidarOdometryParameters,
) -> ScanMatch:
    """Match beams (m, 7) from a predicted pose (3,) with its covariance (3, 3).

    Directions that the scan does not tell keep the predicted place.
    """
    prior = np.linalg.inv(covariance) * parameters.reading_variance_m2
    nearby = NearestPoints(np.empty((len(beams), 2)), np.empty(len(beams), np.int64))
    lower, gradient = np.zeros((3, 3)), np.empty(3)
    pose, found, newness = predicted.copy(), 0, 1.0
    robust_m2 = parameters.reach_m**2
    scan_only, kept = np.zeros((3, 3)), np.eye(3)
    for _ in range(LOOKS):
        start = pose.copy()
        found, newness = local_map.find(pose, beams, parameters.reach_m, nearby)
        for _ in range(STEPS):
            scan_only[:], gradient[:] = 0.0, 0.0
            linearise(pose[0], pose[1], pose[2], beams, nearby, found, robust_m2, scan_only, gradient)
            scan_only[:] = scan_only + np.tril(scan_only, -1).T
            kept = _told(scan_only, prior[2, 2], parameters)
            information = kept.T @ scan_only @ kept
            step = kept.T @ gradient
            add_prior(pose, predicted, prior, information, step)
            factor(information, lower)
            solve(lower, step)
            pose += step
        moved = np.abs(pose - start)
        if moved[0] + moved[1] < CONVERGED_M and moved[2] < CONVERGED_RAD:
            break
    share = found / len(beams) if len(beams) else 0.0
    told = kept.T @ scan_only @ kept / parameters.reading_variance_m2
    return ScanMatch(pose, told, _untold(kept), share, newness)


def _told(information: np.ndarray, heading_known: float, parameters: LidarOdometryParameters) -> np.ndarray:
    """Return (3, 3) the projection on what the scan tells: along its directions, and the heading.

    heading_known: information of the heading that the prediction has. A few trunks on one side tell no place
    to a UAV that may have turned. They do to one that knows its heading.
    """
    place, cross = information[:2, :2], information[:2, 2]
    heading = information[2, 2] + heading_known
    marginal = place - np.outer(cross, cross) / heading if heading > 1e-9 else place
    values, vectors = np.linalg.eigh(marginal)
    least = parameters.reading_variance_m2 / parameters.told_m**2
    kept = np.eye(3)
    kept[:2, :2] = (vectors * (values >= least)) @ vectors.T
    return kept


def _untold(kept: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(kept[:2, :2])
    return vectors[:, values < 0.5].T
