"""The offset of another clock from ours: PX4's and MAVROS's filter of TIMESYNC exchanges.

The filter is a double exponential smoothing. Its gains fall while it converges. An exchange counts if the
answer is quick and near the estimate. Too many outliers in a row restart the filter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class TimesyncParameters:
    """The defaults of PX4 and MAVROS."""

    gain_initial: float = 0.05
    gain_final: float = 0.003
    convergence_window: int = 500  # exchanges
    max_round_trip_ns: int = 10_000_000
    max_deviation_ns: int = 100_000_000
    max_consecutive_deviations: int = 5


@dataclass(frozen=True)
class Observation:
    """One exchange. Offsets: our clock less the other one; all in ns."""

    remote_ns: int
    observed_offset_ns: int
    estimated_offset_ns: int
    round_trip_ns: int


class ClockOffset:
    """Estimates the offset from one exchange after the other."""

    def __init__(self, parameters: TimesyncParameters | None = None) -> None:
        self._parameters = parameters or TimesyncParameters()
        self.reset()

    def reset(self) -> None:
        """Forget all exchanges."""
        self._offset_ns = self._skew_ns = 0.0
        self._count = self._deviations = 0

    @property
    def converged(self) -> bool:
        """Whether enough exchanges count for the estimate."""
        return self._count >= self._parameters.convergence_window

    def add(self, sent_ns: int, remote_ns: int, received_ns: int) -> Observation:
        """Take in an exchange: times of sending and receiving by our clock, and the other clock's time."""
        p = self._parameters
        observed_ns = (sent_ns + received_ns - 2 * remote_ns) // 2
        round_trip_ns = received_ns - sent_ns
        if 0 <= round_trip_ns < p.max_round_trip_ns:
            contradicts = abs(observed_ns - self._offset_ns) > p.max_deviation_ns
            if self.converged and contradicts:
                self._deviations += 1
                if self._deviations > p.max_consecutive_deviations:
                    self.reset()
            else:
                self._smooth(observed_ns)
        return Observation(remote_ns, observed_ns, round(self._offset_ns), round_trip_ns)

    def _smooth(self, observed_ns: int) -> None:
        gain = self._gain()
        if self._count == 0:
            self._offset_ns = float(observed_ns)
        else:
            before_ns = self._offset_ns
            self._offset_ns = gain * observed_ns + (1.0 - gain) * (before_ns + self._skew_ns)
            self._skew_ns = gain * (self._offset_ns - before_ns) + (1.0 - gain) * self._skew_ns
        self._count += 1
        self._deviations = 0

    def _gain(self) -> float:
        """Return the gain of offset and skew. It falls along a sigmoid from its first to its last value."""
        p = self._parameters
        if self.converged:
            return p.gain_final
        progress = self._count / p.convergence_window
        share = 1.0 - math.exp(0.5 * (1.0 - 1.0 / (1.0 - progress)))
        return share * p.gain_final + (1.0 - share) * p.gain_initial
