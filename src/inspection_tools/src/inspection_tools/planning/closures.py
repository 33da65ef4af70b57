"""Places that are closed for a while, because CEPA did not fly there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from inspection_tools.checks import check_number
from inspection_tools.errors import PoseError


@dataclass(frozen=True)
class Closure:
    """A ball that no path enters up to a stamp. place_m: (x, y, z) of its centre, in the map's frame."""

    place_m: tuple[float, float, float]
    radius_m: float
    until_s: float


class Closures:
    """All that are closed. A clock that jumps back opens none of them early, but none stays for ever."""

    def __init__(self) -> None:
        self._closed: list[tuple[Closure, float]] = []

    def close(self, place_m: np.ndarray, radius_m: float, seconds: float, stamp_s: float) -> None:
        """Close a ball around a place (x, y, z) for so many seconds from a stamp on.

        Raises:
            PoseError: the place is not finite.
            ParameterError: the radius or the time is not positive.
        """
        if not np.isfinite(place_m).all() or not math.isfinite(stamp_s):
            raise PoseError("The place to close is not finite.")
        check_number("radius", radius_m, 1e-3, 1e3)
        check_number("time", seconds, 0.0, 1e6)
        closure = Closure(
            (float(place_m[0]), float(place_m[1]), float(place_m[2])), radius_m, stamp_s + seconds
        )
        self._closed.append((closure, seconds))

    def at(self, stamp_s: float) -> list[Closure]:
        """Return what is closed at a stamp; forget what is open again, or whose clock has jumped back."""
        self._closed = [
            (closure, seconds)
            for closure, seconds in self._closed
            if 0.0 < closure.until_s - stamp_s <= seconds
        ]
        return [closure for closure, _ in self._closed]
