"""The scan that later ones are compared with."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.scan import PlanarScan


class KeptScan:
    """Keeps a scan, and where odometry was then."""

    def __init__(self) -> None:
        self._kept: tuple[PlanarScan, np.ndarray] | None = None

    def step_to(
        self, scan: PlanarScan, base_in_odom: Sequence[float]
    ) -> tuple[PlanarScan, np.ndarray] | None:
        """Return the kept scan, and odometry's step (3,) since then: x, y in m and yaw in rad.

        None: there was none, so this one is kept.
        """
        if self._kept is None:
            self.keep(scan, base_in_odom)
            return None
        before, was = self._kept
        return before, se2.between(was, np.asarray(base_in_odom, dtype=np.float64))

    def keep(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> None:
        """Compare the next ones with this scan; base_in_odom: x, y in m and yaw in rad."""
        self._kept = scan, np.asarray(base_in_odom, dtype=np.float64)
