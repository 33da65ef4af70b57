"""The battery's readings on their way from who hears them to who decides."""

from __future__ import annotations

from collections import deque

MOST_READINGS = 100
"""If nobody decides for long, the oldest ones are forgotten."""


class Readings:
    """A queue of readings: time in s, and charge 0..1 as it was told, right or wrong. Lock it yourself."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, float]] = deque(maxlen=MOST_READINGS)
        self._last: deque[float] = deque(maxlen=2)
        """The newest readings that may be true, whether they wait or not."""

    def add(self, stamp_s: float, charge: float) -> None:
        """Take in a reading."""
        self._waiting.append((stamp_s, charge))
        if 0.0 <= charge <= 1.0:
            self._last.append(charge)

    def begin(self, stamp_s: float, charge: float) -> None:
        """Begin a flight with the newest reading, told now.

        One that is much lower than the one before it may be wrong. So the higher one of both counts until
        those that follow confirm the lower one.
        """
        self._waiting.clear()
        may_be = [each for each in (charge, *self._last) if 0.0 <= each <= 1.0]
        self._waiting.append((stamp_s, max(may_be, default=charge)))

    def drain(self) -> list[tuple[float, float]]:
        """Return what waits, the oldest first. It waits no more."""
        taken = list(self._waiting)
        self._waiting.clear()
        return taken
