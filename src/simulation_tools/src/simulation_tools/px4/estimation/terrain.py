"""The height of the ground below: a Kalman filter with one state."""

from __future__ import annotations

import math

_TIMEOUT_US = 5_000_000
_NOISE_M_S, _GRADIENT = 0.05, 0.5  # the ground's height changes: over time, and with the way flown


class Terrain:
    """Height of the ground, `down_m` (NED), from distances along the vertical."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Know nothing."""
        self.down_m = self.ratio = math.nan
        self._variance = 0.0
        self._seen_us: int | None = None

    def predict(self, dt_s: float, speed_m_s: float) -> None:
        """Grow less sure, over dt_s at a speed over ground."""
        self._variance += (_NOISE_M_S * dt_s) ** 2 + (_GRADIENT * speed_m_s * dt_s) ** 2

    def stand(self, down_m: float) -> None:
        """Take the ground's height from a vehicle that stands on it."""
        self.down_m, self._variance = down_m, 0.01

    def measure(self, now_us: int, down_m: float, variance: float, gate: float) -> None:
        """Take in the height of the ground that a range finder sees."""
        if math.isnan(self.down_m) or not self.is_valid(now_us):
            self.down_m, self._variance = down_m, variance
        total = self._variance + variance
        innovation = down_m - self.down_m
        self.ratio = innovation**2 / (gate**2 * total)
        if self.ratio <= 1.0:
            gain = self._variance / total
            self.down_m += gain * innovation
            self._variance *= 1.0 - gain
            self._seen_us = now_us

    def is_valid(self, now_us: int) -> bool:
        """Whether a range finder has seen the ground lately."""
        return self._seen_us is not None and now_us - self._seen_us <= _TIMEOUT_US
