"""The UAV's own place, where nobody has looked."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.free_space import OWN_PLACE_BINS

_angles = 2.0 * math.pi / OWN_PLACE_BINS * np.arange(OWN_PLACE_BINS)
DIRECTIONS = np.stack((np.cos(_angles), np.sin(_angles)))


class OwnPlace:
    """A disc that the UAV's middle may not leave where nobody has looked, such as where it started.

    It lies where the UAV was last within what had been seen. From there only drift can drag it along. If it
    went with the UAV, the UAV would creep into what its lidar does not see.
    """

    def __init__(self, radius_m: float) -> None:
        self._radius_m = radius_m
        self._xy: np.ndarray | None = None

    def follow(self, here: np.ndarray, is_seen: bool) -> np.ndarray:
        """Return how far the UAV may go in each of OWN_PLACE_BINS directions, m.

        here: (2,) m, along the odometry's axes. is_seen: whether all that the body takes was seen.
        """
        if self._xy is None or is_seen:
            self._xy = here
        back = self._xy - here
        back *= min(1.0, self._radius_m / max(math.hypot(*back), 1e-9))
        self._xy = here + back
        along = back @ DIRECTIONS
        return along + np.sqrt(np.maximum(0.0, self._radius_m**2 - back @ back + along**2))
