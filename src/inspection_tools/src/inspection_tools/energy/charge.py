"""The charge of the battery in flight, from readings that may be wrong or missing.

In flight a charge only sinks. So the lowest reading counts, drained since then at the mean rate. This one
rule covers readings that are coarse, NaN, frozen, jump up or do not come.
"""

from __future__ import annotations

from collections import deque

from inspection_tools.energy.parameters import EnergyParameters

LEAST_SHARE_OF_RATE = 0.5
"""A UAV in flight draws at least this share of what `endurance` says."""

LATEST_S = 2.0
"""A reading that is older than the last one by more comes from a clock that jumped back."""


class Charge:
    """The charge and the rate at which it sinks, since the last `reset`. Times in s, charges 0..1."""

    def __init__(self, parameters: EnergyParameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Forget everything, as at a take-off, with a battery that may be another one."""
        self.heard_s: float | None = None
        self._sunk: deque[tuple[float, float]] = deque()

    def restart_clock(self, stamp_s: float) -> None:
        """Count the last charge as told now: the clock jumped back."""
        if self._sunk:
            self.heard_s, self._sunk = stamp_s, deque([(stamp_s, self._sunk[-1][1])])

    def offer(self, stamp_s: float, charge: float) -> str:
        """Take in a reading; return one sentence if it is not believed, else nothing."""
        if not 0.0 <= charge <= 1.0:
            return f"The battery's charge is {charge}, not a number from 0 to 1, so the last good one counts."
        if not self._sunk:
            self.heard_s = stamp_s
            self._sunk.append((stamp_s, charge))
            return ""
        if stamp_s < self._sunk[-1][0] - LATEST_S:
            # Also after `restart_clock`: a reading from before the jump may arrive after it.
            self.restart_clock(stamp_s)
        lowest = self._sunk[-1][1]
        if stamp_s < self._sunk[-1][0]:
            return "The battery's reading is older than one before it, so it does not count."
        if charge > lowest + self._parameters.largest_rise:
            return (
                f"The battery's charge jumped up from {lowest:.0%} to {charge:.0%} in flight, "
                "so the lower one counts."
            )
        self.heard_s = stamp_s
        if charge < lowest:
            self._sunk.append((stamp_s, charge))
            self._forget_before(stamp_s - self._parameters.rate_window)
        return ""

    def _forget_before(self, stamp_s: float) -> None:
        """Keep one reading that is older, so that the window is full."""
        while len(self._sunk) > 1 and self._sunk[1][0] <= stamp_s:
            self._sunk.popleft()

    @property
    def rate_per_s(self) -> float:
        """Charge that a second takes. The resolution is added, so that coarse readings do not hide a loss."""
        p = self._parameters
        supposed = 1.0 / p.endurance
        if not self._sunk:
            return supposed
        (first_s, first), (last_s, last) = self._sunk[0], self._sunk[-1]
        if last_s - first_s < 0.5 * p.rate_window:
            return supposed
        return max((first - last + p.resolution) / (last_s - first_s), LEAST_SHARE_OF_RATE * supposed)

    def at(self, now_s: float) -> float | None:
        """Return the charge now; None before the first reading."""
        if not self._sunk:
            return None
        stamp_s, lowest = self._sunk[-1]
        return max(lowest - self.rate_per_s * max(now_s - stamp_s, 0.0), 0.0)
