"""Other heights to look for a way at, where the plane has none."""

from __future__ import annotations

from cepa.dynamic.constants.cost_to_go import LONGEST_SEARCH_M


class HeightSearch:
    """Where the plane has no way out, tries the heights above, then those below."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew: a way was found."""
        self._untried = [1.0, -1.0]
        self._began_m: float | None = None

    def climb(self, height_m: float, is_open: tuple[bool, bool]) -> float | None:
        """Return 1.0 to climb, -1.0 to sink, or None when both were tried.

        height_m: of the UAV. is_open: whether it may move into the next layer above, and below.
        """
        if self._began_m is None:
            self._began_m = height_m
        while self._untried:
            sign = self._untried[0]
            if is_open[0 if sign > 0.0 else 1] and sign * (height_m - self._began_m) < LONGEST_SEARCH_M:
                return sign
            self.give_up()
        return None

    def give_up(self) -> None:
        """Try the other direction, if it was not tried before."""
        del self._untried[:1]
