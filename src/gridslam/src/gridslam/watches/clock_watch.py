"""Finds odometry whose stamps are of other times than those of the scans: it turns early, or late."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.filter.step_check import Link
from gridslam.scan import PlanarScan

PERIOD_MIN_S, PERIOD_MAX_S = 0.2, 1.0
"""Two scans are compared if so much time is between them."""
GUESSES_RAD = np.array((-0.6, -0.3, 0.0, 0.3, 0.6))
"""Scans are aligned beginning at each of these turns, as odometry is not to be believed here."""
TURN_RAD, TURNS, TURNED_RAD = 0.1, 6, 3.0
"""So many comparisons in which the scans turn by more than the first decide, if they turn so much in all."""
PAIRS_MAX = 600
"""After so many pairs of scans the watch ends in any case, so it costs nothing later."""
OFFSET_MIN_S, OFFSET_MAX_S, STEP_S = 0.25, 2.0, 0.05
"""Offsets between the first two are looked for. A smaller one does little harm."""
BETTER = 0.4
"""With an offset, the squared differences must be below this share of those without one."""
ERROR_MAX_RAD = 0.3
"""Greater differences count as this: a jump, or a wrong comparison, tells nothing of clocks."""


class ClockWatch:
    """Aligns scans with those before them, and compares how they turn with odometry, earlier and later."""

    def __init__(self) -> None:
        self._before: PlanarScan | None = None
        self._told: list[tuple[float, float]] = []
        """Stamp, s, and yaw of odometry, rad, at each scan."""
        self._turns: list[tuple[float, float, float]] = []
        """Stamps of two scans, s, and the turn between them, rad."""
        self._pairs = 0
        self._has_ended = False

    def check(self, scan: PlanarScan, base_in_odom: Sequence[float]) -> str:
        """Take in a levelled scan with the base in odom, x, y in m and yaw in rad.

        Return a sentence, once, if odometry's stamps are of other times; else nothing.
        """
        if self._has_ended or (self._told and scan.stamp_s <= self._told[-1][0]):
            return ""
        self._told.append((scan.stamp_s, float(base_in_odom[2])))
        before = self._before
        if before is not None and scan.stamp_s - before.stamp_s < PERIOD_MIN_S:
            return ""
        self._before = scan
        self._pairs += 1  # also where scans are too far apart, so that the watch ends
        if before is not None and scan.stamp_s - before.stamp_s <= PERIOD_MAX_S:
            self._compare(before, scan)
        if not self._is_enough():
            self._has_ended = self._pairs >= PAIRS_MAX
            return ""
        offset_s = offset_of(np.array(self._turns), np.array(self._told))
        self._has_ended = True
        return offset_in_words(offset_s) if offset_s else ""

    def _compare(self, before: PlanarScan, scan: PlanarScan) -> None:
        guesses = np.zeros((len(GUESSES_RAD), 3))
        guesses[:, 2] = GUESSES_RAD
        link = Link.between(before, scan, guesses)
        if link is not None:
            self._turns.append((before.stamp_s, scan.stamp_s, float(link.pose[2])))

    def _is_enough(self) -> bool:
        """Return whether the scans have turned enough, and odometry is known long enough after that."""
        if not self._turns:
            return False
        last_s = self._told[-1][0] - OFFSET_MAX_S
        turned = np.array([abs(turn) for _, end_s, turn in self._turns if end_s < last_s])
        return bool((turned > TURN_RAD).sum() >= TURNS and turned.sum() >= TURNED_RAD)


def offset_of(turns: np.ndarray, odometry: np.ndarray) -> float:
    """Return how much later than the scans odometry turns, s; negative: earlier; 0: no offset is clear.

    Args:
        turns: (n, 3) of scans: stamps of two scans, s, and the turn between them, rad.
        odometry: (k, 2) ascending stamps, s, and yaw, rad. In between it is interpolated.
    """
    told_s, headings = odometry[:, 0], np.unwrap(odometry[:, 1])
    inside = (turns[:, 0] >= told_s[0] + OFFSET_MAX_S) & (turns[:, 1] <= told_s[-1] - OFFSET_MAX_S)
    begin_s, end_s, turned = turns[inside].T
    if (np.abs(turned) > TURN_RAD).sum() < TURNS:
        return 0.0
    zero = round(OFFSET_MAX_S / STEP_S)
    offsets_s = STEP_S * np.arange(-zero, zero + 1)[:, None]
    told = np.interp(end_s + offsets_s, told_s, headings) - np.interp(begin_s + offsets_s, told_s, headings)
    errors = np.minimum(np.abs(se2.wrap(told - turned)), ERROR_MAX_RAD)
    squares = (errors**2).sum(axis=1)
    best = int(squares.argmin())
    if abs(best - zero) * STEP_S < OFFSET_MIN_S or squares[best] > BETTER * squares[zero]:
        return 0.0
    return float(offsets_s[best, 0])


def offset_in_words(offset_s: float) -> str:
    """Return a sentence on an offset that was found."""
    when = "late" if offset_s > 0.0 else "early"
    return (
        f"Odometry turns {abs(offset_s):.1f} s too {when} for the scans: check the clocks that stamp both. "
        "The map is wrong where the vehicle turns."
    )
