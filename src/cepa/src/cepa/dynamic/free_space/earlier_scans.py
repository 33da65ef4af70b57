"""What earlier scans have seen free where the newest one does not look."""

from __future__ import annotations

import numpy as np

from cepa.dynamic.constants.free_space import BLIND_REACH_M, BLIND_STEP_M, EARLIER_SCANS, RANGE_BINS
from cepa.dynamic.free_space.kernels.ranges import fill_blind, was_seen_around


class EarlierScans:
    """Keeps the free ranges of the last scans, and where they were taken, in the odometry's frame."""

    def __init__(self) -> None:
        self._xy = np.empty((EARLIER_SCANS, 2))
        self._free_m = np.empty((EARLIER_SCANS, RANGE_BINS))
        self.reset()

    def reset(self) -> None:
        """Forget all scans."""
        self._taken = 0

    def take_over(self, earlier: EarlierScans) -> None:
        """Take over a copy of what another one knows."""
        self._xy, self._free_m, self._taken = earlier._xy.copy(), earlier._free_m.copy(), earlier._taken

    def take_in(self, x_m: float, y_m: float, free_m: np.ndarray) -> None:
        """Take in a scan's place, and how far it sees free (RANGE_BINS,), m."""
        place = self._taken % EARLIER_SCANS
        self._xy[place] = x_m, y_m
        self._free_m[place] = free_m
        self._taken += 1

    def _newest(self, scans: int) -> tuple[np.ndarray, np.ndarray, int]:
        count = min(self._taken, scans, EARLIER_SCANS)
        places = (self._taken - 1 - np.arange(count)) % EARLIER_SCANS
        return self._xy[places], self._free_m[places], count

    def have_seen_around(
        self, free_m: np.ndarray, x_m: float, y_m: float, radius_m: float, scans: int
    ) -> bool:
        """Return whether the newest have seen the body's rim where ``free_m`` (RANGE_BINS,) is below 0."""
        return bool(was_seen_around(free_m, x_m, y_m, *self._newest(scans), radius_m))

    def fill(self, free_m: np.ndarray, x_m: float, y_m: float, own_place_m: float, scans: int) -> None:
        """Fill in ``free_m`` (RANGE_BINS,), m, where it is below 0, by the newest scans.

        own_place_m: what the body covers.
        """
        fill_blind(free_m, x_m, y_m, *self._newest(scans), BLIND_STEP_M, BLIND_REACH_M, own_place_m)
