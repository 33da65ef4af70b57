"""Places that are closed for a while, because CEPA did not fly there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flight_basics.checks import check_number
from flight_basics.errors import PoseError

LONGEST = 64
"""A place is closed for this multiple of the first time at most."""


@dataclass(frozen=True)
class Closure:
    """A ball that no path enters up to a stamp.

    place_m: (x, y, z) of its centre, in the map's frame. times: so often it was closed.
    """

    place_m: tuple[float, float, float]
    radius_m: float
    until_s: float
    times: int = 1


class Closures:
    """All that are closed. A clock that jumps back opens none of them early, but none stays for ever.

    A place that is closed again stays so for twice the time. So a UAV between two ways that CEPA does not
    fly does not try them by turns for ever.
    """

    def __init__(self) -> None:
        self._closed: list[tuple[Closure, float]] = []
        self._times: list[tuple[np.ndarray, int]] = []
        """Places, and how often each was closed."""

    def close(self, place_m: np.ndarray, radius_m: float, seconds: float, stamp_s: float) -> None:
        """Close a ball around a place (x, y, z) from a stamp on, the first time for so many seconds.

        Raises:
            PoseError: the place is not finite.
            ParameterError: the radius or the time is not positive.
        """
        if not np.isfinite(place_m).all() or not math.isfinite(stamp_s):
            raise PoseError("The place to close is not finite.")
        check_number("radius", radius_m, 1e-3, 1e3)
        check_number("time", seconds, 0.0, 1e6)
        times = self._count(np.array(place_m, float), radius_m)
        seconds *= min(2 ** (times - 1), LONGEST)
        x, y, z = (float(each) for each in place_m)
        self._closed.append((Closure((x, y, z), radius_m, stamp_s + seconds, times), seconds))

    def _count(self, place_m: np.ndarray, radius_m: float) -> int:
        """Return how often a place, or one within the radius of it, has been closed, with this time."""
        for number, (known_m, times) in enumerate(self._times):
            if math.dist(known_m, place_m) <= radius_m:
                self._times[number] = known_m, times + 1
                return times + 1
        self._times.append((place_m, 1))
        return 1

    def reopen(self, times_max: float) -> bool:
        """Open what was closed at most so often. Return whether anything was."""
        kept = [(closure, seconds) for closure, seconds in self._closed if closure.times > times_max]
        is_opened = len(kept) < len(self._closed)
        self._closed = kept
        return is_opened

    def at(self, stamp_s: float) -> list[Closure]:
        """Return what is closed at a stamp; forget what is open again, or whose clock has jumped back."""
        self._closed = [
            (closure, seconds)
            for closure, seconds in self._closed
            if 0.0 < closure.until_s - stamp_s <= seconds
        ]
        return [closure for closure, _ in self._closed]
