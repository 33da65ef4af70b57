"""Where a reference velocity that shrinks or turns on the way will end."""

from __future__ import annotations

import math
from typing import Sequence

from cepa.dynamic.constants.choice import FORGOTTEN_M, LEAST_EXPLAINED, MOST_WAITING_REFERENCES


class Destination:
    """Fits v_ref = gain (end - x) to the last references v_ref and places x.

    Who flies to a place asks for less the nearer it is, and turns the reference while the UAV passes it. A
    course has no end: its reference does not depend on the place. The references wait until somebody asks,
    which nobody does in the open.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all references."""
        self._weight = self._place_variance = self._covariance = self._reference_variance = 0.0
        self._mean_m = self._mean_m_s = self._last_m = (0.0, 0.0)
        self._waiting: list[tuple[float, float, float, float]] = []

    def update(self, place_m: Sequence[float], v_ref: Sequence[float]) -> None:
        """Take in the reference (x, y), m/s, at a place (x, y, ...), m, along the same axes."""
        self._waiting.append((place_m[0], place_m[1], v_ref[0], v_ref[1]))
        if len(self._waiting) == MOST_WAITING_REFERENCES:
            self._take_in()

    def _take_in(self) -> None:
        """Take in what waits."""
        for x, y, u, v in self._waiting:
            self._fit(x, y, u, v)
        self._waiting.clear()

    def _fit(self, x: float, y: float, u: float, v: float) -> None:
        """Update weighted means, variances (not divided by the weight) and the covariance of x and v_ref."""
        last_x, last_y = self._last_m
        (mean_x, mean_y), (mean_u, mean_v) = self._mean_m, self._mean_m_s
        kept = math.exp(-math.hypot(x - last_x, y - last_y) / FORGOTTEN_M)
        earlier = kept * self._weight
        self._weight, self._last_m = earlier + 1.0, (x, y)
        share = 1.0 / self._weight
        dx, dy, du, dv = x - mean_x, y - mean_y, u - mean_u, v - mean_v
        self._mean_m = mean_x + share * dx, mean_y + share * dy
        self._mean_m_s = mean_u + share * du, mean_v + share * dv
        new = earlier * share
        self._place_variance = kept * self._place_variance + new * (dx * dx + dy * dy)
        self._covariance = kept * self._covariance + new * (dx * du + dy * dv)
        self._reference_variance = kept * self._reference_variance + new * (du * du + dv * dv)

    @property
    def gain_1_s(self) -> float:
        """By how much the reference's speed falls for each metre towards the end; 0: it has none in sight."""
        self._take_in()
        if (
            self._covariance >= 0.0
            or self._covariance**2 < LEAST_EXPLAINED * self._place_variance * self._reference_variance
        ):
            return 0.0
        return -self._covariance / self._place_variance
