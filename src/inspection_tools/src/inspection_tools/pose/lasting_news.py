"""Tells a change once, and what changes to and fro only where it lasts."""

from __future__ import annotations

import math


class LastingNews:
    """Decides whether a state is news. Times of any clock, s.

    Args:
        steady_s: after a state that held for so long, the next one is news at once. lasts_s: any other one is
            news when it has held for so long.
    """

    def __init__(self, steady_s: float, lasts_s: float) -> None:
        self._steady_s, self._lasts_s = steady_s, lasts_s
        self._told = self._state = ""
        self._since_s = -math.inf
        self._was_steady = True

    def is_due(self, state: str, now_s: float) -> bool:
        """Take in the present state, again and again. Return whether it is to be told now."""
        if state != self._state:
            self._was_steady = not 0.0 <= now_s - self._since_s < self._steady_s
            self._state, self._since_s = state, now_s
        if state == self._told or not (self._was_steady or now_s - self._since_s >= self._lasts_s):
            return False
        self._told = state
        return True
