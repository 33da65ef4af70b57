"""The outcome of an exploration: why it ended, what it saw, and what stays unknown or unreachable."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from exploration.energy import WayHome
from exploration.next_view.unknown.leftovers import Leftover, Why

HEIGHT_KNOWN_M = 0.3
"""With a greater standard deviation the UAV's height counts as not known."""

TOLD_M = 100.0
"""Drivers that do not know a standard deviation tell a greater one."""


class End(Enum):
    """Why an exploration has ended."""

    EXPLORED = "explored"
    TIME = "time"
    BATTERY = "battery"
    ABORTED = "aborted"
    SHUT_IN = "shut in"
    CUT_OFF = "cut off"
    """Explored, but no way leads home any more."""


@dataclass
class Explored:
    """What an exploration did.

    end: why it ended; None: it flies. reason: the same as a sentence. ended_s: when. views: that were
    decided. known_m3: time in s, and the free and occupied volume. leftovers: what stays unknown. cpu_s: CPU
    time of each decision. way_home: as it was reckoned when it ended; None: the battery does not count.
    way_home_charge: what that takes at the mean rate, 0..1; NaN: not known.
    height_uncertain_m: the greatest standard deviation of the height in flight, as odometry told it; NaN: it
    told none.
    """

    end: End | None = None
    reason: str = ""
    views: int = 0
    known_m3: list[tuple[float, float]] = field(default_factory=list)
    leftovers: tuple[Leftover, ...] = ()
    cpu_s: list[float] = field(default_factory=list)
    ended_s: float = math.nan
    way_home: WayHome | None = None
    way_home_charge: float = math.nan
    height_uncertain_m: float = math.nan

    def left_m2(self, why: Why) -> float:
        """Return the area of the border that stays unknown for a reason."""
        return sum(leftover.area_m2 for leftover in self.leftovers if leftover.why is why)

    @property
    def height_words(self) -> str:
        """That the height was not known, in a sentence; empty: it was, or nothing was told of it."""
        return height_doubt(self.height_uncertain_m)

    def note_height(self, sigma_m: float) -> str:
        """Take the standard deviation of the UAV's height, m; NaN: it is not told.

        Return what is wrong, in a sentence; empty: nothing.
        """
        if not 0.0 <= sigma_m < TOLD_M:
            return ""
        self.height_uncertain_m = float(np.fmax(self.height_uncertain_m, sigma_m))
        if sigma_m <= HEIGHT_KNOWN_M:
            return ""
        return (
            f"The height is not known: its standard deviation is {sigma_m:.1f} m (at most "
            f"{HEIGHT_KNOWN_M} m). Look at the range finder, and whether the lidar sees the floor."
        )

    def time_of(self, share: float) -> float:
        """Return when this share of the volume known at the end was known, s; NaN if nothing was."""
        rows = np.array(self.known_m3).reshape(-1, 2)
        enough = rows[rows[:, 1] >= share * rows[-1:, 1]] if len(rows) else rows
        return float(enough[0, 0]) if len(enough) else math.nan


def height_doubt(sigma_m: float) -> str:
    """Return that the height was not known, in a sentence; empty: it was, or nothing was told of it.

    sigma_m: its greatest standard deviation, m; NaN: none was told.
    """
    if not sigma_m > HEIGHT_KNOWN_M:
        return ""
    return (
        f"The height was not always known: its standard deviation reached {sigma_m:.1f} m "
        f"(at most {HEIGHT_KNOWN_M} m), so the map may be wrong."
    )
