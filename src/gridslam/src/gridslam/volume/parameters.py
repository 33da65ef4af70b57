"""What a volume is made with: the voxels' size and the sensor model, as OctoMap has them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

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

    resolution_m: float = 0.1
    """Side of a voxel."""
    max_range_m: float = -1.0
    """A longer ray is free up to here, and its end does not count; below 0: no ray is too long."""
    hit: float = 0.7
    """Probability that a voxel is occupied, given that a ray ends in it."""
    miss: float = 0.4
    """The same, given that a ray crosses it."""
    least: float = 0.1192
    """A voxel's probability never falls below this."""
    greatest: float = 0.971
    """A voxel's probability never rises above this."""

    def __post_init__(self) -> None:
        low, high = RESOLUTIONS_M
        if not low <= self.resolution_m <= high:
            raise ParameterError(
                f"The resolution must be from {low} to {high} m, not {self.resolution_m}; 0.1 suits a hold."
            )
        if math.isnan(self.max_range_m):
            raise ParameterError("The greatest range must be a number of metres; -1 means none.")
        if not 0.5 < self.hit < 1.0 or not 0.0 < self.miss < 0.5:
            raise ParameterError(
                f"hit must be a probability above 0.5 and miss one below it, not {self.hit} and {self.miss}."
            )
        if not 0.0 < self.least < 0.5 < self.greatest < 1.0:
            raise ParameterError(
                "The least and greatest probability must be on both sides of 0.5, between 0 and 1, not "
                f"{self.least} and {self.greatest}."
            )

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
