"""The ranges that wait for a scan, and which of them count for it."""

from __future__ import annotations

from collections import deque
from typing import Any

LAG_MAX_S = 0.25
"""A range finder that is silent for longer holds up no scan."""
SLACK_S = 0.005
"""Ranges may come later by this than the gap before them tells."""
GAPS = 5
KEPT = 20


class RangeQueue:
    """Ranges in the order of their stamps.

    The first range that is at most a lag older than a scan is the last one that counts for it. So the stamps
    alone tell whether a scan has all its ranges, or waits for one that comes later. The lag is a little more
    than the second longest of the last gaps between ranges that counted. So one lost range has no effect.
    """

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, Any]] = deque(maxlen=KEPT)
        self._counted_s: deque[float] = deque(maxlen=GAPS + 1)
        self._newest_s: float | None = None

    @property
    def has_begun(self) -> bool:
        """Whether any range has come."""
        return self._newest_s is not None

    def add(self, stamp_s: float, reading: Any) -> None:
        """Take a range, in any form. One that a simulator in lockstep sends again does not count."""
        if stamp_s == self._newest_s:
            return
        if self._newest_s is not None and stamp_s < self._newest_s:  # the clock went back
            self._waiting.clear()
            self._counted_s.clear()
        self._newest_s = stamp_s
        self._waiting.append((stamp_s, reading))

    def lacks(self, stamp_s: float) -> bool:
        """Whether a range that counts for a scan of this time is still to come."""
        return self._newest_s is not None and self._lag_s < stamp_s - self._newest_s < LAG_MAX_S

    def take(self, stamp_s: float) -> list[tuple[float, Any]]:
        """Return (stamp in s, range) of the new ones that count for a scan of this time, oldest first."""
        taken: list[tuple[float, Any]] = []
        until_s = stamp_s - self._lag_s
        while self._waiting and (not self._counted_s or self._counted_s[-1] < until_s):
            range_s = self._waiting[0][0]
            if range_s >= stamp_s:
                break
            taken.append((range_s, self._waiting.popleft()[1]))
            self._counted_s.append(range_s)
        return taken

    @property
    def _lag_s(self) -> float:
        stamps_s = list(self._counted_s)
        gaps_s = sorted(later - earlier for earlier, later in zip(stamps_s, stamps_s[1:]))
        return min(gaps_s[-2] + SLACK_S, LAG_MAX_S) if len(gaps_s) > 1 else LAG_MAX_S
