"""The processed scans, which are kept to make the map anew along a corrected path, and their clouds."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam.level_cloud import LevelCloud
from gridslam.maps.beams import Beams
from gridslam.scan import PlanarScan


class InSpace(NamedTuple):
    """What is known of a kept scan beside the plane."""

    cloud: LevelCloud | None = None
    """What the lidar saw in space at the same time; None: it told none."""
    rise_m: float = 0.0
    """How much higher the base was in the map than odometry says."""


class KeptScans:
    """Scans, what each enters into a map, and the odometry at each. Memory grows with the path."""

    def __init__(self) -> None:
        self.scans: list[PlanarScan] = []
        self.beams: list[Beams] = []
        """Without those for matching."""
        self._odometry: list[np.ndarray] = []
        self.in_space: list[InSpace] = []
        self._heights_m: np.ndarray | None = None
        """None: they have changed since they were asked for."""

    def __len__(self) -> int:
        return len(self.scans)

    @property
    def odometry(self) -> np.ndarray:
        """(k, 3) pose of the base in the odometry's frame, at each scan."""
        return np.reshape(self._odometry, (-1, 3))

    @property
    def newest_odometry(self) -> np.ndarray:
        """(3,) the same at the newest scan."""
        return self._odometry[-1]

    @property
    def heights_m(self) -> np.ndarray:
        """(k,) of the base in the map, at each scan; NaN: not known. It is read-only."""
        if self._heights_m is None:  # once for many scans in known places, which ask each time
            pairs = zip(self.scans, self.in_space)
            self._heights_m = np.array([scan.height_m + in_space.rise_m for scan, in_space in pairs], float)
            self._heights_m.flags.writeable = False
        return self._heights_m

    @property
    def rise_m(self) -> float:
        """How much higher the base is in the map since the newest scan than odometry says."""
        return self.in_space[-1].rise_m if self.in_space else 0.0

    def add(self, scan: PlanarScan, beams: Beams, base_in_odom: np.ndarray) -> None:
        """Keep a scan."""
        self.scans.append(scan.sharing(self.scans[-1]) if self.scans else scan)
        self.beams.append(beams.for_map())
        self._odometry.append(np.array(base_in_odom, float))
        self.in_space.append(InSpace(None, self.rise_m))
        self._heights_m = None

    def add_cloud(self, cloud: LevelCloud) -> None:
        """Keep the cloud of the newest scan."""
        self.in_space[-1] = self.in_space[-1]._replace(cloud=cloud)

    def correct_heights(self, heights_m: np.ndarray) -> None:
        """Take over heights (n,) of the base in the map at the first scans. The others rise with the last."""
        further_m = np.zeros(len(self))
        further_m[: len(heights_m)] = heights_m - self.heights_m[: len(heights_m)]
        further_m[len(heights_m) :] = further_m[len(heights_m) - 1]
        self.in_space = [
            each._replace(rise_m=each.rise_m + rise_m)
            for each, rise_m in zip(self.in_space, further_m.tolist())
        ]
        self._heights_m = None

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

    def restore(
        self,
        scans: Sequence[PlanarScan],
        beams: Sequence[Beams],
        odometry: np.ndarray,
        in_space: Sequence[InSpace],
    ) -> None:
        """Keep these scans, with their beams, the odometry (k, 3), and what is known in space (k)."""
        self.scans, self.beams, self._odometry = list(scans), list(beams), list(odometry)
        self.in_space, self._heights_m = list(in_space), None
