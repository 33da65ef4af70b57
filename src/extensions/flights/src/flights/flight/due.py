"""When something periodic is due, in simulated time."""

from __future__ import annotations


class Due:
    """Detects the start of each period."""

    def __init__(self, period_us: int) -> None:
        self._period_us = period_us
        self.next_us = 0
        """When the next period begins."""

    def __call__(self, time_us: int) -> bool:
        """Return whether a period has begun since the last call."""
        if time_us < self.next_us:
            return False
        self.next_us = (time_us // self._period_us + 1) * self._period_us
        return True
