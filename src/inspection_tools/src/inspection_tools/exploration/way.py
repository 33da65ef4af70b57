"""The places that a UAV flies to one after the other."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np


class Way:
    """A way that one thread follows. Another one may replace it at any time, but does not change it.

    Args:
        places_m: (x, y, z) each, without the place where the UAV is.
    """

    def __init__(self, places_m: Sequence[np.ndarray] = ()) -> None:
        self._places_m, self._reached = tuple(places_m), 0

    def follow(self, here_m: np.ndarray, arrived_m: float) -> None:
        """Go on to the next place if the UAV (x, y, z) is nearer than this to the present one."""
        if self.is_left and math.dist(here_m, self._places_m[self._reached]) < arrived_m:
            self._reached += 1

    @property
    def is_left(self) -> bool:
        """Whether the UAV has not arrived at the end."""
        return self._reached < len(self._places_m)

    @property
    def rest_m(self) -> list[np.ndarray]:
        """The places to come."""
        return list(self._places_m[self._reached :])

    @property
    def setpoint_m(self) -> np.ndarray | None:
        """The place to fly to now, in the end the last one; None: the way has none."""
        return self._places_m[min(self._reached, len(self._places_m) - 1)] if self._places_m else None
