"""A bounded queue of scans that wait for their transforms and for SLAM. It never blocks."""

from __future__ import annotations

from collections import deque
from typing import Callable, NamedTuple

WAITING_MAX = 200
"""Greatest number of scans that wait for TF, which may be seconds late."""
READY_MAX = 40
"""Greatest number of scans that wait for SLAM; older ones are left out. Most scans take a millisecond. So
SLAM catches up soon after a pause of one second at 40 Hz.
"""


class Taken(NamedTuple):
    """What `ScanQueue.take` returns."""

    scan: object | None
    """The oldest scan that is ready, if any is."""
    too_late: list
    """Scans left out because SLAM was busy for too long."""
    without_tf: list
    """Scans left out because their transforms never came, although those of the newest scan did."""


class ScanQueue:
    """Scans in the order in which they came. Any object may stand for a scan.

    Args:
        waiting_max: greatest number of waiting scans; None: no limit, as for a bag.
        ready_max: greatest number of waiting scans that are ready; None: no limit.
    """

    def __init__(self, waiting_max: int | None = WAITING_MAX, ready_max: int | None = READY_MAX):
        self._scans: deque = deque()
        self._waiting_max, self._ready_max = waiting_max, ready_max

    def __len__(self) -> int:
        return len(self._scans)

    @property
    def ends(self) -> tuple:
        """The oldest and the newest scan; only of a queue that is not empty."""
        return self._scans[0], self._scans[-1]

    def offer(self, scan: object) -> list:
        """Append a scan; returns those that were dropped for it."""
        self._scans.append(scan)
        if self._waiting_max is None:
            return []
        return [self._scans.popleft() for _ in range(len(self._scans) - self._waiting_max)]

    def take(self, is_ready: Callable) -> Taken:
        """Take the oldest scan that is ready, and those left out for it."""
        scans, ready_max, too_late, without_tf = self._scans, self._ready_max, [], []
        while ready_max is not None and len(scans) > ready_max and is_ready(scans[ready_max]):
            too_late.append(scans.popleft())
        while scans and not is_ready(scans[0]) and is_ready(scans[-1]):
            without_tf.append(scans.popleft())
        scan = scans.popleft() if scans and is_ready(scans[0]) else None
        return Taken(scan, too_late, without_tf)

    def clear(self) -> list:
        """Empty the queue; returns what was in it."""
        scans = list(self._scans)
        self._scans.clear()
        return scans
