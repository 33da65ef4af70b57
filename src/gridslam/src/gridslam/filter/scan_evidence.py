"""What one scan says about the particles' poses, from the filter's step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gridslam import se2
from gridslam.filter import resampling
from gridslam.filter.motion_model import Motion, Prediction
from gridslam.kernels.matching import Matches
from gridslam.maps.beams import Beams
from gridslam.maps.tile_map import TileMaps
from gridslam.parameters import SlamParameters
from gridslam.tracking.evidence import Evidence


class MatchedScan(NamedTuple):
    """A scan that is matched with the maps of all particles, before it is used."""

    stamp_s: float
    beams: Beams
    motion: Motion
    """By odometry, since the last scan."""
    prediction: Prediction
    """The particles' poses by odometry."""
    matches: Matches


def evidence_of(
    scan: MatchedScan,
    maps: TileMaps,
    best: int,
    weights: np.ndarray,
    parameters: SlamParameters,
    is_witness: bool = True,
) -> Evidence:
    """Return what a scan says.

    Args:
        scan: is matched, and not in the maps yet.
        maps: of all particles.
        best: the particle whose path explains scans and odometry best, with this scan.
        weights: (particles,) before this scan.
        parameters: the filter's.
        is_witness: see `Evidence`.
    """
    stamp_s, beams, motion, prediction, matches = scan
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
        is_witness,
    )
