"""What one scan says about the particles' poses, from the filter's step."""

from __future__ import annotations

import math

import numpy as np

from gridslam import se2
from gridslam.filter import resampling
from gridslam.filter.beams import Beams
from gridslam.filter.motion_model import Motion, Prediction
from gridslam.filter.tile_map import TileMaps
from gridslam.kernels.matching import Matches
from gridslam.localisation.evidence import Evidence
from gridslam.parameters import SlamParameters


def evidence_of(
    stamp_s: float,
    beams: Beams,
    maps: TileMaps,
    matches: Matches,
    prediction: Prediction,
    best: int,
    weights: np.ndarray,
    motion: Motion,
    parameters: SlamParameters,
) -> Evidence:
    """Return what a scan says, with the maps before it.

    Args:
        stamp_s: s: the scan's.
        beams: the scan's.
        maps: of all particles.
        matches: of the scan with the maps.
        prediction: the particles' poses by odometry.
        best: the particle whose path explains scans and odometry best, with this scan.
        weights: (particles,) before this scan.
        motion: by odometry, since the last scan.
        parameters: the filter's.
    """
    poses = maps.to_metres(matches.poses)
    missed = poses[best] - prediction.predicted[best]
    missed[2] = se2.wrap(missed[2])
    ranges = np.hypot(*(beams.ends - beams.lidar)[beams.hits].T) * parameters.delta
    range_m = float(np.median(ranges)) if len(ranges) else 0.0
    from_middle = poses[:, :2] - weights @ poses[:, :2]
    return Evidence(
        stamp_s,
        maps.agreement(best, poses[best], beams),
        math.sqrt(float(weights @ (from_middle**2).sum(axis=1))),
        resampling.effective_number(weights) / len(weights),
        math.sqrt(float(missed @ prediction.information[best] @ missed)),
        range_m,
        parameters.srt * parameters.linearUpdate * range_m,
        motion.distance_m - float(motion.tried[0]),
    )
