"""When what follows the map is told again."""

from __future__ import annotations

import math

TOLERANCE_S = 1e-6
"""Stamps are rounded."""


class Pace:
    """Lets changes be told at most once a period, by the stamps of clouds.

    What has changed too early waits for a later cloud: until then no time passes.

    Args:
        period_s: the least time between two tellings.
        has_changed: whether there is something to tell from the start.
    """

    def __init__(self, period_s: float, has_changed: bool = False) -> None:
        self._period_s, self._has_changed = period_s, has_changed
        self._told_s = -math.inf

    def note(self) -> None:
        """Something has changed."""
        self._has_changed = True

    def is_due(self, stamp_s: float) -> bool:
        """Return whether a change is to be told at the newest cloud's stamp; 0: there was no cloud yet."""
        past_s = stamp_s - self._told_s
        is_early = stamp_s > 0.0 and 0.0 <= past_s < self._period_s - TOLERANCE_S
        return self._has_changed and not is_early

    def tell(self, stamp_s: float) -> None:
        """All changes are told at this stamp."""
        self._has_changed, self._told_s = False, stamp_s

    def restart(self) -> None:
        """Begin anew, because the clock jumped back: the next change is told at once."""
        self._told_s = -math.inf
