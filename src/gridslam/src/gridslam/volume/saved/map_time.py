"""One time for all flights of a map: the clock may begin anew with each."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

PAUSE_S = 1.0
"""Between two flights whose clock began anew."""


NEXT_S = 1e-3
"""A cloud that is later by so much is another one."""


class Flight(NamedTuple):
    """offset_s: is added to its stamps. begin_s: time of its first cloud."""

    offset_s: float
    begin_s: float


FIRST = Flight(0.0, -math.inf)


class MapTime:
    """Turns stamps into a time that grows from flight to flight.

    After a saved state, a cloud that is not newer than the state begins another flight.

    Args:
        flights: of the state.
        newest_s: time of its newest cloud.
    """

    def __init__(self, flights: Sequence[Flight] = (FIRST,), newest_s: float = -math.inf) -> None:
        self.flights, self.newest_s = list(flights), newest_s
        self._may_begin = math.isfinite(newest_s)

    def take_over(self, other: MapTime) -> None:
        """Become another time."""
        self.flights, self.newest_s, self._may_begin = other.flights, other.newest_s, other._may_begin

    def begin_flight(self) -> None:
        """Let the next cloud begin another flight if it is not newer: the clock was set back."""
        self._may_begin = True

    def begin_map(self) -> None:
        """Let the next cloud begin another map of SLAM, whose path tells nothing of earlier clouds."""
        self.flights.append(Flight(self.flights[-1].offset_s, self.newest_s + NEXT_S))

    def of_cloud(self, stamp_s: float) -> float:
        """Return the time of a cloud. The stamps of one flight grow."""
        if self._may_begin and stamp_s + self.flights[-1].offset_s <= self.newest_s:
            begin_s = self.newest_s + PAUSE_S
            self.flights.append(Flight(begin_s - stamp_s, begin_s))
        self._may_begin = False
        self.newest_s = stamp_s + self.flights[-1].offset_s
        return self.newest_s

    def of_path(self, stamps_s: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Return which poses (n,) of a path are of known flights, the times (k,) of these, and since when.

        Where the path's stamps go back, a flight begins. SLAM may have begun later than the map, or sooner:
        the last flights of both belong together.
        """
        number = np.concatenate(([0], np.cumsum(np.diff(stamps_s) < 0.0))) if len(stamps_s) else np.zeros(0)
        flights = (number + len(self.flights) - 1 - number[-1:].sum()).astype(int)
        are_known = flights >= 0
        offsets_s = np.array([flight.offset_s for flight in self.flights])[flights[are_known]]
        since_s = self.flights[flights[are_known][0]].begin_s if are_known.any() else math.inf
        return are_known, np.asarray(stamps_s, float)[are_known] + offsets_s, since_s
