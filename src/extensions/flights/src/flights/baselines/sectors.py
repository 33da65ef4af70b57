"""The scan in sectors of equal width, which both histogram methods look at."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa.scan import Beams


@dataclass(frozen=True)
class Sectors:
    """A full turn in `count` sectors; sector k is centred on k times the width from the frame's x axis."""

    count: int

    @property
    def width_rad(self) -> float:
        """Width of a sector."""
        return 2.0 * math.pi / self.count

    @property
    def angles_rad(self) -> np.ndarray:
        """Centres of the sectors (count,)."""
        return np.arange(self.count) * self.width_rad

    def index(self, angle_rad: float | np.ndarray) -> np.ndarray:
        """Return the sector that holds an angle, or each of several."""
        return np.rint(np.asarray(angle_rad) / self.width_rad).astype(int) % self.count

    def nearest(self, beams: Beams) -> np.ndarray:
        """Return the least range in each sector (count,), m: +inf where all is free, NaN where unseen."""
        least = np.full(self.count, np.nan)
        np.fmin.at(least, self.index(beams.angles[beams.seen]), beams.ranges[beams.seen])
        return least


def angle_between(a_rad: float | np.ndarray, b_rad: float | np.ndarray) -> np.ndarray:
    """Return the unsigned angles between directions, rad, 0 to pi."""
    return np.abs(np.remainder(np.asarray(a_rad) - b_rad + math.pi, 2.0 * math.pi) - math.pi)
