"""A bounded queue of scans that wait for their transforms and for SLAM. It never blocks."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Any, Callable, NamedTuple

WAITING_MAX = 200
"""Greatest number of scans that wait for TF, which may be seconds late."""
READY_MAX = 40
"""Greatest number of scans that wait for SLAM; of more, some are left out. Most scans take a millisecond. So
SLAM catches up soon after a pause of one second at 40 Hz.
"""
LIDARS_MAX = 4
"""So many lidars may send scans in turns, of which TF knows the place of one only."""


class Taken(NamedTuple):
    """What `ScanQueue.take` returns."""

    scan: object | None
    """The oldest scan that is ready, if any is."""
    too_late: list
    """Scans left out because SLAM was busy for too long."""
    without_tf: list
    """Scans left out because their transforms never came, although those of a newer scan did."""


class _Waiting(NamedTuple):
    number: int
    """How many scans came before it."""
    scan: Any


class ScanQueue:
    """Scans in the order in which they came. Any object may stand for a scan.

    Of too many scans those are left out whose neighbours are nearest to each other. So what is left is spread
    evenly, and the newest scan stays.

    Args:
        waiting_max: greatest number of waiting scans; None: no limit, as for a bag.
        ready_max: greatest number of waiting scans that are ready; None: no limit.
    """

    def __init__(self, waiting_max: int | None = WAITING_MAX, ready_max: int | None = READY_MAX):
        self._waiting: deque[_Waiting] = deque()
        self._waiting_max, self._ready_max = waiting_max, ready_max
        self._before = -1
        """Number of the scan that was taken last, or of the one before the oldest that ever came."""
        self.offered = 0
        """How many scans have come so far."""

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def ends(self) -> tuple:
        """The oldest and the newest scan; only of a queue that is not empty."""
        return self._waiting[0].scan, self._waiting[-1].scan

    def offer(self, scan: object) -> list:
        """Append a scan; returns those that were dropped for it."""
        self._waiting.append(_Waiting(self.offered, scan))
        self.offered += 1
        if self._waiting_max is None:
            return []
        return [self._leave_out(self._waiting_max) for _ in range(len(self._waiting) - self._waiting_max)]

    def take(self, is_ready: Callable) -> Taken:
        """Take the oldest scan that is ready, and those left out for it."""
        waiting, ready_max, too_late, without_tf = self._waiting, self._ready_max, [], []
        while ready_max is not None and len(waiting) > ready_max and is_ready(waiting[ready_max].scan):
            too_late.append(self._leave_out(ready_max))
        while waiting and not is_ready(waiting[0].scan) and self._is_newer_ready(is_ready):
            without_tf.append(waiting.popleft().scan)
        if not waiting or not is_ready(waiting[0].scan):
            return Taken(None, too_late, without_tf)
        self._before, scan = waiting.popleft()
        return Taken(scan, too_late, without_tf)

    def _is_newer_ready(self, is_ready: Callable) -> bool:
        return any(is_ready(each.scan) for each in islice(reversed(self._waiting), LIDARS_MAX))

    def _leave_out(self, last: int) -> object:
        """Leave out one of the scans before the one at this place: where the gap becomes smallest."""
        numbers = [self._before, *(each.number for each in islice(self._waiting, last + 1))]
        gaps = [later - earlier for earlier, later in zip(numbers, numbers[2:])]
        place = gaps.index(min(gaps))
        scan = self._waiting[place].scan
        del self._waiting[place]
        return scan

    def clear(self) -> list:
        """Empty the queue; returns what was in it."""
        scans = [each.scan for each in self._waiting]
        self._waiting.clear()
        return scans
