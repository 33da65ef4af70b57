"""The battery's readings on their way from who hears them to who decides."""

from __future__ import annotations

from collections import deque

MOST_READINGS = 100
"""If nobody decides for long, the oldest ones are forgotten."""


class Readings:
    """A queue of readings: time in s, and charge 0..1 as it was told, right or wrong. Lock it yourself."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, float]] = deque(maxlen=MOST_READINGS)

    def add(self, stamp_s: float, charge: float) -> None:
        """Take in a reading."""
        self._waiting.append((stamp_s, charge))

    def restart_clock(self, stamp_s: float) -> None:
        """Count what waits as told now: the clock jumped back. The charges are as true as before.

        A watch that never heard a charge sends the UAV home, so the first reading must not be lost here.
        """
        self._waiting = deque(((stamp_s, charge) for _, charge in self._waiting), MOST_READINGS)

    def begin(self, stamp_s: float, charge: float) -> None:
        """Begin a flight with the newest reading, told now."""
        self._waiting.clear()
        self.add(stamp_s, charge)

    def take(self) -> list[tuple[float, float]]:
        """Return what waits, the oldest first. It waits no more."""
        taken = list(self._waiting)
        self._waiting.clear()
        return taken
