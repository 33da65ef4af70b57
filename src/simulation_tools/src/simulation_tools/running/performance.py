"""How well a running simulator keeps up: real-time factor, latency of the setpoints, lockstep misses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

LATENCIES_KEPT = 32768
"""Number of newest latencies in the percentiles: 13 minutes of a 40 Hz lidar."""


@dataclass(frozen=True)
class PerformanceFigures:
    """A snapshot. Latencies are NaN until the first one is measured.

    real_time_factor: simulated seconds per wall second since the snapshot before, pauses left out;
    real_time_factor_mean: the same since the start (or reset). setpoint_latency_ms_*: wall time from
    publishing scan(t) to receiving the setpoint with `time_boot_ms` = t, over the newest `LATENCIES_KEPT`;
    setpoint_latency_count: how many were measured. lockstep_misses: barriers that timed out.
    """

    simulated_s: float
    real_time_factor: float
    real_time_factor_mean: float
    setpoint_latency_ms_median: float
    setpoint_latency_ms_p99: float
    setpoint_latency_count: int
    lockstep_misses: int


class LatencyMeter:
    """Pairs the publishing of scan(t) with the first setpoint whose `time_boot_ms` is t."""

    def __init__(self, kept: int = LATENCIES_KEPT) -> None:
        self._latencies_ms = np.empty(kept)
        self.clear()

    def clear(self) -> None:
        """Forget all latencies."""
        self.count = 0
        self._published: dict[int, float] = {}

    def on_scan(self, stamp_ms: int, wall_s: float) -> None:
        """Note that scan(stamp_ms) is being published."""
        self._published[stamp_ms] = wall_s
        while len(self._published) > 64:  # scans without an answer
            del self._published[next(iter(self._published))]

    def on_setpoint(self, stamp_ms: int, wall_s: float) -> None:
        """Note that a setpoint with `time_boot_ms` = stamp_ms has arrived."""
        published_s = self._published.pop(stamp_ms, None)
        if published_s is not None:
            self._latencies_ms[self.count % len(self._latencies_ms)] = 1000.0 * (wall_s - published_s)
            self.count += 1

    def percentiles_ms(self, *percentages: float) -> list[float]:
        """Return percentiles of the kept latencies; NaN if there are none."""
        kept = self._latencies_ms[: self.count]
        return np.percentile(kept, percentages).tolist() if self.count else [math.nan] * len(percentages)


class PerformanceMeter:
    """Collects the figures of one run loop. Wall times are seconds of one monotonic clock."""

    def __init__(self) -> None:
        self.latency = LatencyMeter()
        self.lockstep_misses = 0
        self._simulated_s = self._wall_s = 0.0
        self._snapshot = (0.0, 0.0)

    def clear(self) -> None:
        """Start all figures again, as after a reset."""
        self.latency.clear()
        self.lockstep_misses = 0
        self._simulated_s = self._wall_s = 0.0
        self._snapshot = (0.0, 0.0)

    def on_progress(self, simulated_s: float, wall_s: float) -> None:
        """Note that simulated time advanced by `simulated_s` within `wall_s`."""
        self._simulated_s += simulated_s
        self._wall_s += wall_s

    def snapshot(self) -> PerformanceFigures:
        """Return the figures; the next snapshot's real_time_factor begins here."""
        simulated_s, wall_s = self._snapshot
        self._snapshot = (self._simulated_s, self._wall_s)
        median_ms, p99_ms = self.latency.percentiles_ms(50.0, 99.0)
        return PerformanceFigures(
            simulated_s=self._simulated_s,
            real_time_factor=_ratio(self._simulated_s - simulated_s, self._wall_s - wall_s),
            real_time_factor_mean=_ratio(self._simulated_s, self._wall_s),
            setpoint_latency_ms_median=median_ms,
            setpoint_latency_ms_p99=p99_ms,
            setpoint_latency_count=self.latency.count,
            lockstep_misses=self.lockstep_misses,
        )


def _ratio(numerator: float, denominator: float) -> float:
    return numerator / denominator if denominator > 0.0 else 0.0
