"""The metrics of a run in wall time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class WallMetrics:
    """Metrics that only a run in wall time has.

    real_time_factor: simulated over wall seconds, from sending the goal to reaching it. latency_ms: median
    and p99 of the time from publishing a scan until the flight controller receives the setpoint made from
    it, and their count. lockstep_misses: number of late answers in lockstep. wall_time_s: of the whole run.
    """

    real_time_factor: float | None = None
    latency_ms: dict | None = None
    lockstep_misses: int | None = None
    wall_time_s: float | None = None
    wall_time_to_ready_s: float | None = None
