"""What a volume is made with: the voxels' size and the sensor model, as OctoMap has them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError
from gridslam.volume.kernels.tiles import Model

RESOLUTIONS_M = (0.001, 100.0)
"""Smallest and greatest side of a voxel."""
FLAT_MISS = 0.46
"""`miss` for a level lidar, which sees floor and deck at a flat angle only.

There a ray crosses three voxels of the surface before it hits one. With OctoMap's 0.4 these misses weigh more
than the hits, and erase the surface.
"""


@dataclass(frozen=True)
class VolumeParameters:
    """Checked when it is made. The defaults are those of OctoMap's library.

    Raises:
        ParameterError: a value makes no sense.
    """

    resolution_m: float = limited(0.1, RESOLUTIONS_M[0], RESOLUTIONS_M[1])
    """Side of a voxel, m. 0.1 suits a hold."""
    max_range_m: float = limited(-1.0, -math.inf, math.inf)
    """A longer ray is free up to here, and its end does not count, m. Below 0 no ray is too long."""
    hit: float = limited(0.7, above=0.5, below=1.0)
    """Probability that a voxel is occupied, given that a ray ends in it."""
    miss: float = limited(0.4, above=0.0, below=0.5)
    """The same, given that a ray crosses it."""
    least: float = limited(0.1192, above=0.0, below=0.5)
    """A voxel's probability never falls below this."""
    greatest: float = limited(0.971, above=0.5, below=1.0)
    """A voxel's probability never rises above this."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "The volume's {}")

    @property
    def model(self) -> Model:
        """The log-odds that kernels use."""
        return Model(*(log_odds(each) for each in (self.hit, self.miss, self.least, self.greatest)))


def log_odds(probability: float) -> np.float32:
    """Return a probability's log-odds, rounded as OctoMap rounds them."""
    return np.float32(math.log(probability / (1.0 - probability)))


def probability(log_odds: float) -> float:
    """Return the probability of log-odds."""
    return 1.0 - 1.0 / (1.0 + math.exp(log_odds))
