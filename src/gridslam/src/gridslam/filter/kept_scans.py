"""The processed scans, which are kept to make the map anew along a corrected path."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam.maps.beams import Beams
from gridslam.scan import PlanarScan


class KeptScans:
    """Scans, what each enters into a map, and the odometry at each. Memory grows with the path."""

    def __init__(self) -> None:
        self.scans: list[PlanarScan] = []
        self.beams: list[Beams] = []
        """Without those for matching."""
        self._odometry: list[np.ndarray] = []

    def __len__(self) -> int:
        return len(self.scans)

    @property
    def odometry(self) -> np.ndarray:
        """(k, 3) pose of the base in the odometry's frame, at each scan."""
        return np.reshape(self._odometry, (-1, 3))

    def add(self, scan: PlanarScan, beams: Beams, base_in_odom: np.ndarray) -> None:
        """Keep a scan."""
        self.scans.append(scan.sharing(self.scans[-1]) if self.scans else scan)
        self.beams.append(beams.for_map())
        self._odometry.append(np.array(base_in_odom, float))

    def in_band(self, band_m: float, half_m: float) -> list[Beams]:
        """Return what each scan enters into the map of a height: none if it was taken at another one."""
        if math.isnan(band_m):
            return self.beams
        none = Beams.none()
        return [
            none if abs(scan.height_m - band_m) > half_m else beams  # NaN is in every band
            for scan, beams in zip(self.scans, self.beams)
        ]

    def leave_out(self, ranges: Sequence[tuple[int, int]]) -> None:
        """Let the scans in these ranges (first, after last) enter no map."""
        for first, last in ranges:
            self.beams[first:last] = [Beams.none()] * (last - first)

    def restore(self, scans: Sequence[PlanarScan], beams: Sequence[Beams], odometry: np.ndarray) -> None:
        """Keep these scans, with their beams and the odometry (k, 3)."""
        self.scans, self.beams, self._odometry = list(scans), list(beams), list(odometry)
