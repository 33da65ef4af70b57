"""How often scans come, and so for how long an answer must be safe to fly."""

from __future__ import annotations

import math

from cepa.dynamic.constants.response import COMMIT_PERIODS, LONGEST_COMMIT_S, SCAN_PERIOD_SHARE


class ScanTiming:
    """Keeps the mean time between scans.

    period_s: 0 if it is not known. commit_s: how long an answer is flown if no other one comes.
    """

    def __init__(self, least_commit_s: float) -> None:
        self._least_commit_s = least_commit_s
        self.reset()

    def reset(self) -> None:
        """Forget all scans."""
        self._stamp_s = -math.inf
        self._set_period(0.0)

    def take_over(self, earlier: ScanTiming) -> None:
        """Take over what one with another least commit time knows."""
        self._stamp_s = earlier._stamp_s
        self._set_period(earlier.period_s)

    def goes_back(self, stamp_s: float) -> bool:
        """Return whether a scan is older than the last one."""
        return stamp_s < self._stamp_s

    def take_in(self, stamp_s: float) -> None:
        """Take in the stamp of a scan."""
        gap_s = stamp_s - self._stamp_s
        self._stamp_s = stamp_s
        if gap_s <= LONGEST_COMMIT_S:
            period_s = self.period_s
            self._set_period(period_s + SCAN_PERIOD_SHARE * (gap_s - period_s) if period_s else gap_s)

    def _set_period(self, period_s: float) -> None:
        self.period_s = period_s
        self.commit_s = min(max(self._least_commit_s, COMMIT_PERIODS * period_s), LONGEST_COMMIT_S)
