"""Scans that wait for their transforms and for their turn: bounded, and offering one never blocks."""

from __future__ import annotations

from collections import deque
from typing import Callable

WAITING_MAX = 200
"""Scans that wait for TF at most; it may be seconds late."""
READY_MAX = 40
"""Scans whose transforms are known and that may still wait for their turn; older ones are left out.

Most scans take a millisecond, so that even a second's halt at 40 Hz is made up for soon.
"""


class ScanQueue:
    """Scans in the order of their coming; any object may stand for a scan."""

    def __init__(self):
        self._scans: deque = deque()

    def __len__(self) -> int:
        return len(self._scans)

    @property
    def ends(self) -> tuple:
        """The oldest and the newest scan; only of a queue that is not empty."""
        return self._scans[0], self._scans[-1]

    def offer(self, scan) -> list:
        """Append a scan; returns those that had to go for it."""
        self._scans.append(scan)
        return [self._scans.popleft() for _ in range(len(self._scans) - WAITING_MAX)]

    def take(self, is_ready: Callable) -> tuple:
        """Return (the oldest scan that is ready or None, those left out for it).

        Left out are scans before so many ready ones that their turn would come too late, and scans that are
        not ready although the newest one is, whose transforms therefore never came.
        """
        left_out = []
        while len(self._scans) > READY_MAX and is_ready(self._scans[READY_MAX]):
            left_out.append(self._scans.popleft())
        while self._scans and not is_ready(self._scans[0]) and is_ready(self._scans[-1]):
            left_out.append(self._scans.popleft())
        if self._scans and is_ready(self._scans[0]):
            return self._scans.popleft(), left_out
        return None, left_out

    def clear(self) -> list:
        """Empty the queue; returns what was in it."""
        scans = list(self._scans)
        self._scans.clear()
        return scans
