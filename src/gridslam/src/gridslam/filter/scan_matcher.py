"""Scan matching: finds the pose of every particle at which a scan fits its map best.

Most of the odometry's error is the same for every particle. So one search in the best particle's map finds
the common correction: hill climbing (gmapping's score and steps) from several drawn motions, then
Gauss-Newton on the means of the hits. Every particle starts there and is refined against its own map. If a
particle's map disagrees, it climbs from its own drawn motion. If the scan fits too little of the map, all
particles do.
"""

from __future__ import annotations

import math

import numpy as np

from gridslam import se2
from gridslam.filter.motion_model import Prediction
from gridslam.filter.workers import Workers
from gridslam.kernels.matching import Matches, Motions, Search, find_mode, match
from gridslam.kernels.nearest import ParticleMap
from gridslam.maps.beams import Beams
from gridslam.maps.tile_map import TileMaps
from gridslam.parameters import SlamParameters

REFINE_SIGMA_M2 = 0.02
"""m2: a beam d from the map has the weight exp(-d^2 / this) in Gauss-Newton."""
LOOKS = 6
"""Number of times that Gauss-Newton searches for the nearest points of a particle's map."""
COMMON_LOOKS = 12
"""The same for the common correction, so that each particle needs few."""
BEAM_DEVIATION_M = 0.02
"""m: error of a beam's end at the right pose in a right map. It weighs beams against odometry."""
CANDIDATES = 7
"""Number of motions at which the search for the common correction starts: odometry's and drawn ones."""
CANDIDATES_EVERY = 6
"""The search uses every sixth beam, or more beams if that leaves fewer than CANDIDATES_BEAMS."""
CANDIDATES_BEAMS = 40
HALVINGS_MAX = 2
"""Gauss-Newton does the rest of gmapping's ``iterations``."""
EXPECTED_SHARE = 0.85
"""A particle with less than this share of the best one's score searches for its own correction."""
AMBIGUOUS_SHARE = 0.6
"""If less than this share of a scan fits the map, it may fit in several ways."""
UNTOLD_SHARE = 1e-6
"""Beams tell nothing in a direction in which their share of the information is below this."""
SEEN_DEVIATIONS = 2.0
"""A beam that ends at a surface counts if the surface was seen this many of odometry's deviations around."""
NULL_LIKELIHOOD_M2 = 0.5
"""m2: squared distance that counts for a beam without a point of the map near it (gmapping's)."""


class ScanMatcher:
    """Matches scans with gmapping's parameters."""

    def __init__(self, parameters: SlamParameters):
        self._parameters = parameters
        area = parameters.delta**2
        self._search = Search(
            kernel=parameters.kernelSize,
            score_sigma=parameters.sigma / area,
            refine_sigma=REFINE_SIGMA_M2 / area,
            likelihood_sigma=parameters.lsigma / area,
            missed=-NULL_LIKELIHOOD_M2 / parameters.lsigma,
            step=parameters.lstep / parameters.delta,
            turn=parameters.astep,
            halvings=min(parameters.iterations, HALVINGS_MAX),
            looks=LOOKS,
            least_score=parameters.minimumScore,
        )

    def match(
        self, maps: TileMaps, prediction: Prediction, best: int, beams: Beams, workers: Workers
    ) -> Matches:
        """Match one scan against every particle's map. ``best`` is the particle for the common correction."""
        predicted, drawn = maps.to_cells(prediction.predicted), maps.to_cells(prediction.drawn)
        drawn[:, 2] = predicted[:, 2] + se2.wrap(drawn[:, 2] - predicted[:, 2])
        motions = Motions(predicted, drawn, self._priors(prediction.information))
        starts, score, is_observed = self._common_correction(maps, motions, best, beams)
        counts = np.ones(len(beams.matching), bool)
        if not is_observed:
            counts = self._seen_before(maps, prediction, best, beams.matching)
        count = len(predicted)
        matches = Matches(np.empty((count, 3)), np.empty(count), np.empty(count), np.zeros((count, 3, 3)))
        workers.share(
            count,
            match,
            starts,
            motions,
            EXPECTED_SHARE * score,
            score < AMBIGUOUS_SHARE * len(beams.matching),
            beams.matching,
            counts,
            self._search,
            maps.tables,
            maps.pool.surfaces,
            matches,
        )
        return matches

    def _common_correction(
        self, maps: TileMaps, motions: Motions, best: int, beams: Beams
    ) -> tuple[np.ndarray, float, bool]:
        """Apply the best particle's correction to every prediction.

        Returns the poses, the score, and whether beams tell the position in all directions.
        """
        predicted, drawn, priors = motions
        steps = se2.between(predicted[: CANDIDATES - 1], drawn[: CANDIDATES - 1])
        candidates = np.vstack((predicted[best], se2.compose(predicted[best], steps)))
        every = max(1, min(CANDIDATES_EVERY, len(beams.matching) // CANDIDATES_BEAMS))
        grid = ParticleMap(maps.tables[best], *maps.pool.surfaces)
        mode, lower = np.empty(3), np.zeros((3, 3))
        score = find_mode(
            candidates,
            predicted[best],
            priors[best],
            beams.matching,
            every,
            grid,
            self._search,
            COMMON_LOOKS,
            mode,
            lower,
        )
        starts = se2.compose(predicted, se2.between(predicted[best], mode))
        starts[:, 2] = predicted[:, 2] + se2.wrap(starts[:, 2] - predicted[:, 2])
        told = np.linalg.eigvalsh((lower @ lower.T - priors[best])[:2, :2])
        return starts, score, told[0] > UNTOLD_SHARE * told[1]

    def _seen_before(
        self, maps: TileMaps, prediction: Prediction, best: int, beams: np.ndarray
    ) -> np.ndarray:
        """Return which beams (m,) end where the best particle's map was seen, by odometry.

        If the others counted along a corridor, a path that lags behind would seem likelier, because more of
        its scan fits.
        """
        pose = maps.to_cells(prediction.predicted[best])
        before = se2.transform(pose, beams[:, 0:2] - beams[:, 2:4])
        normals = se2.transform((0.0, 0.0, pose[2]), beams[:, 4:6])
        weakest = np.linalg.eigvalsh(prediction.information[best][:2, :2])[0]
        reach = SEEN_DEVIATIONS / (math.sqrt(weakest) * self._parameters.delta) + 1.0
        shift = np.where(beams[:, 6:7] < 1.0, reach * normals[:, ::-1] * (-1.0, 1.0), 0.0)
        return (
            maps.are_seen(best, before)
            & maps.are_seen(best, before + shift)
            & maps.are_seen(best, before - shift)
        )

    def _priors(self, information: np.ndarray) -> np.ndarray:
        """Return the motion's information per cell and rad, in units of one beam's."""
        delta = self._parameters.delta
        scale = np.array((delta, delta, 1.0))
        return information * np.outer(scale, scale) * (BEAM_DEVIATION_M / delta) ** 2
