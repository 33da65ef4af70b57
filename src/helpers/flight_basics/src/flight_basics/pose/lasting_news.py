"""Tells a change once, and what changes to and fro only where it lasts."""

from __future__ import annotations

import math


class LastingNews:
    """Decides whether a state is news. Times of any clock, s.

    Args:
        quiet_s: a state that was away for so long is news at once. lasts_s: one that has come back earlier is
            news when it has held for so long.
    """

    def __init__(self, quiet_s: float, lasts_s: float) -> None:
        self._quiet_s, self._lasts_s = quiet_s, lasts_s
        self._told = self._state = ""
        self._since_s = -math.inf
        self._is_back = False
        self._seen_s: dict[str, float] = {}

    def is_due(self, state: str, now_s: float) -> bool:
        """Take in the present state, again and again. Return whether it is to be told now."""
        if state != self._state:
            away_s = now_s - self._seen_s.get(state, -math.inf)
            self._is_back = 0.0 <= away_s < self._quiet_s
            self._state, self._since_s = state, now_s
        self._seen_s[state] = now_s
        if state == self._told or (self._is_back and now_s - self._since_s < self._lasts_s):
            return False
        self._told = state
        return True
