"""The charge of the battery in flight, from readings that may be wrong or missing.

In flight a charge only sinks. So the lowest reading counts, drained since then at the mean rate. This one
rule covers readings that are coarse, NaN, frozen, jump up or do not come. Only a simulated battery may stay
at a charge, which is known by name: `held_at`. A reading that falls all at once
counts when the next one confirms it: a single wrong one would land the UAV for good.
"""

from __future__ import annotations

from collections import deque

from exploration.energy.parameters import EnergyParameters

LEAST_SHARE_OF_RATE = 0.5
"""A UAV in flight draws at least this share of what `endurance` says."""
LEAST_TIME_S = 10.0
"""A loss over a shorter time tells no rate: a take-off draws more, and a voltage sags under load."""


class Charge:
    """The charge and the rate at which it sinks, since the last `reset`.

    Times in s, of a clock that nobody sets (see `SteadyTime`); charges 0..1.

    Attributes:
        held_at: see `EnergyParameters`; may be changed at any time.
    """

    def __init__(self, parameters: EnergyParameters) -> None:
        self._parameters = parameters
        self.held_at = parameters.held_at
        self.reset()

    def reset(self) -> None:
        """Forget everything, as at a take-off, with a battery that may be another one."""
        self.heard_s: float | None = None
        self._sunk: deque[tuple[float, float]] = deque()
        self._doubted: float | None = None
        """The last reading, if it fell all at once and waits for the next one."""

    def offer(self, stamp_s: float, charge: float) -> str:
        """Take in a reading; return one sentence if it is not believed, else nothing."""
        if not 0.0 <= charge <= 1.0:
            return f"The battery's charge is {charge}, not a number from 0 to 1, so the last good one counts."
        if not self._sunk:
            self._believe(stamp_s, charge)
            return ""
        last_s, lowest = self._sunk[-1]
        if stamp_s < last_s:
            return "The battery's reading is older than one before it, so it does not count."
        if charge > lowest + self._parameters.largest_rise:
            self._doubted = None
            return (
                f"The battery's charge jumped up from {lowest:.0%} to {charge:.0%} in flight, "
                "so the lower one counts."
            )
        if self._is_doubtful(stamp_s, charge):
            return (
                f"The battery's charge fell from {lowest:.0%} to {charge:.0%} all at once, "
                "so it counts when the next reading confirms it."
            )
        self._believe(stamp_s, charge)
        return ""

    def _is_doubtful(self, stamp_s: float, charge: float) -> bool:
        """Whether a reading fell too far for its time, and none confirms it. It confirms the one before."""
        reckoned, most = self.at(stamp_s), self._parameters.largest_fall
        assert reckoned is not None
        doubted, self._doubted = self._doubted, None
        if charge >= reckoned - most or (doubted is not None and charge >= doubted - most):
            return False
        if doubted is not None:
            self._believe(stamp_s, doubted)
        self._doubted = charge
        return True

    def _believe(self, stamp_s: float, charge: float) -> None:
        self.heard_s = stamp_s
        if not self._sunk or charge < self._sunk[-1][1]:
            self._sunk.append((stamp_s, charge))
            self._forget_before(stamp_s - self._parameters.rate_window)

    def _forget_before(self, stamp_s: float) -> None:
        """Keep one reading that is older, so that the window is full."""
        while len(self._sunk) > 1 and self._sunk[1][0] <= stamp_s:
            self._sunk.popleft()

    @property
    def rate_per_s(self) -> float:
        """Charge that a second takes. The resolution is added, so that coarse readings do not hide a loss.

        In the first half of the window the rate is never less than supposed, and more only as far as the
        readings, coarse as they are, leave no doubt.
        """
        p = self._parameters
        supposed = 1.0 / p.endurance
        if not self._sunk or self._is_held:
            return supposed
        (first_s, first), (last_s, last) = self._sunk[0], self._sunk[-1]
        sunk, time_s = first - last, last_s - first_s
        if time_s < 0.5 * p.rate_window:
            if time_s < LEAST_TIME_S or self.held_at > 0.0:  # which sinks fast, and then stays
                return supposed
            return max((sunk - p.resolution) / time_s, supposed)  # a weak battery draws so much for sure
        return max((sunk + p.resolution) / time_s, LEAST_SHARE_OF_RATE * supposed)

    @property
    def _is_held(self) -> bool:
        """Whether a simulated battery has sunk as far as it ever does."""
        return self.held_at > 0.0 and abs(self._sunk[-1][1] - self.held_at) <= self._parameters.resolution

    def at(self, now_s: float) -> float | None:
        """Return the charge now; None before the first reading."""
        if not self._sunk:
            return None
        stamp_s, lowest = self._sunk[-1]
        if self._is_held:
            return lowest
        return max(lowest - self.rate_per_s * max(now_s - stamp_s, 0.0), 0.0)
