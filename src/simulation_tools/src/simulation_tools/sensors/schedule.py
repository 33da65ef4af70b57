"""When sensors fire."""

from __future__ import annotations

import math


class Schedule:
    """When a sensor fires: at the first instant at or after each due time k / rate (rate 0: at each).

    The due times are exact. So a 15 Hz lidar does not drift, although its period is not a whole number of us.
    """

    def __init__(self, rate_hz: float):
        self._rate_hz = rate_hz
        self.due_us = 0

    def restart(self) -> None:
        """Be due at t = 0."""
        self.due_us = 0

    def fired(self, now_us: int) -> None:
        """Wait for the first due time after now."""
        count = math.floor(1e-6 * now_us * self._rate_hz + 1e-9) + 1
        self.due_us = math.ceil(1e6 * count / self._rate_hz - 1e-3) if self._rate_hz > 0.0 else now_us + 1
