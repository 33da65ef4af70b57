"""The processed scans, which are kept to make the map anew along a corrected path, and their clouds."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam.level_cloud import LevelCloud
from gridslam.scan import PlanarScan


class InSpace(NamedTuple):
    """What is known of a kept scan beside the plane."""

    cloud: LevelCloud | None = None
    """What the lidar saw in space at the same time; None: it told none."""
    rise_m: float = 0.0
    """How much higher the base was in the map than odometry says."""


class KeptScans:
    """Scans, whether each enters a map, and the odometry at each. Memory grows with the path.

    What a map gets of a scan is made of it again for each map. It would take more memory than the scan.
    """

    def __init__(self) -> None:
        self.scans: list[PlanarScan] = []
        self._enters = bytearray()
        """(k,) whether each scan enters a map."""
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

    def add(self, scan: PlanarScan, base_in_odom: np.ndarray) -> None:
        """Keep a scan."""
        self.scans.append(scan.sharing(self.scans[-1]) if self.scans else scan)
        self._enters.append(True)
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

    def in_band(self, band_m: float, half_m: float) -> list[PlanarScan | None]:
        """Return the scans that enter the map of a height. None: it was taken at another one, or left out."""
        is_any = math.isnan(band_m)
        return [
            scan if enters and (is_any or not abs(scan.height_m - band_m) > half_m) else None  # NaN: in all
            for scan, enters in zip(self.scans, self._enters)
        ]

    def leave_out(self, ranges: Sequence[tuple[int, int]]) -> None:
        """Let the scans in these ranges (first, after last) enter no map."""
        for first, last in ranges:
            self._enters[first:last] = bytes(last - first)

    def restore(
        self,
        scans: Sequence[PlanarScan],
        odometry: np.ndarray,
        in_space: Sequence[InSpace],
    ) -> None:
        """Keep these scans, with the odometry (k, 3), and what is known in space (k). All enter a map.

        Raises:
            ValueError: they are no scans.
        """
        if not all(isinstance(scan, PlanarScan) for scan in scans):
            raise ValueError("what is kept of the path are no scans")
        self.scans, self._odometry = list(scans), list(odometry)
        self._enters = bytearray([True]) * len(self.scans)
        self.in_space, self._heights_m = list(in_space), None
