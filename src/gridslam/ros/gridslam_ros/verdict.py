"""What replay and node say of their map: how long the vehicle was tracked, what odometry alone joins."""

from __future__ import annotations

from collections import Counter
from typing import Callable, Sequence

import numpy as np

from gridslam.tracking.monitor import STATES, TRACKING

NAMED_MAX = 5
"""More moments than this tell nothing more."""


class Verdict:
    """Counts the states of a run, one for each scan that was used."""

    def __init__(self) -> None:
        self._states: Counter[str] = Counter()

    def add(self, state: str) -> None:
        """Take in the state after a scan."""
        self._states[state] += 1

    @property
    def shares(self) -> dict[str, float]:
        """Share of the scans in each state."""
        count = max(1, self._states.total())
        return {state: self._states[state] / count for state in STATES}

    def sentences(self, parts_s: Sequence[float], begun_s: float) -> list[str]:
        """Return what is to be known of the map; nothing: the vehicle was tracked, and the map is one.

        Args:
            parts_s: stamps at which parts of the map begin that odometry alone joins with the others.
            begun_s: stamp of the first scan.
        """
        said = []
        if self._states.total() > self._states[TRACKING]:
            others = ", ".join(f"{self.shares[state]:.1%} {state}" for state in STATES if self._states[state])
            said.append(f"The state was, by scans: {others}. doc/localisation.md says what that means.")
        if parts_s:
            said.append(loose_parts_in_words(parts_s, begun_s))
        return said


class LoosePartsWatch:
    """Tells when the map has another number of loose parts than before."""

    def __init__(self) -> None:
        self._parts_s: list[float] = []

    def follow(self, parts_s: Sequence[float], stamps_s: Callable[[], np.ndarray]) -> str:
        """Return a sentence if the number has changed, else nothing.

        Args:
            parts_s: stamps at which the parts begin now.
            stamps_s: returns those of the path's nodes; it is asked for when something is to be told.
        """
        before, self._parts_s = self._parts_s, list(parts_s)
        if len(before) == len(parts_s):
            return ""
        if parts_s:
            return loose_parts_in_words(parts_s, stamps_s()[0])
        return "Scans or closures join all parts of the map now."


def loose_parts_in_words(parts_s: Sequence[float], begun_s: float) -> str:
    """Return a sentence on the parts of the map, one or more, that odometry alone joins with the others.

    Args:
        parts_s: stamps at which they begin.
        begun_s: stamp of the first scan.
    """
    moments = ", ".join(f"{stamp_s - begun_s:.1f} s" for stamp_s in parts_s[:NAMED_MAX])
    more = f" and {len(parts_s) - NAMED_MAX} more" if len(parts_s) > NAMED_MAX else ""
    return (
        f"The map has {len(parts_s) + 1} parts of which odometry alone tells where they are: new ones begin "
        f"at {moments}{more} after the first scan. They may be misplaced; walls may be there twice."
    )
