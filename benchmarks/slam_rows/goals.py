"""What each row of the table is to reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Sequence

from benchmarks.shared.results import table

HEADER = ("log", "metric", "goal", "measured", "reached", "without loop closure")


@dataclass(frozen=True)
class Goal:
    """The greatest value of a metric."""

    metric: str
    most: float


GOALS: Mapping[str, Sequence[Goal]] = {
    "csail": (
        Goal("ate_worst_m", 0.15),
        Goal("ate_median_m", 0.08),
        Goal("published_by_best_after_closures", 1.2),
        Goal("online_by_final_since_closure", 1.2),
        Goal("cpu_ms_per_scan", 13.2),
        Goal("cpu_ms_p95", 40.0),
        Goal("peak_mb", 300.0),
    ),
    "aces": (
        Goal("ate_worst_m", 0.15),
        Goal("ate_median_m", 0.08),
        Goal("published_by_best_after_closures", 1.2),
        Goal("online_by_final_since_closure", 1.2),
        Goal("cpu_ms_per_scan", 8.5),
        Goal("cpu_ms_p95", 40.0),
        Goal("peak_mb", 300.0),
    ),
    "intel": (
        Goal("ate_worst_m", 0.020),
        Goal("all_worst_m", 0.098),
        Goal("cpu_ms_per_scan", 6.3),
        Goal("cpu_ms_p95", 40.0),
        Goal("peak_mb", 300.0),
    ),
    "two_hours": (
        Goal("growth_mb", 10.0),
        Goal("cpu_growth", 1.1),
        Goal("end_mb", 300.0),
        Goal("error_max_m", 0.5),
    ),
    "small_robot": (
        Goal("lost_share", 0.0),
        Goal("tracking_wrong_share", 0.0),
        Goal("final_error_max_m", 0.1),
    ),
    "slipped_step": (Goal("tracking_wrong_share", 0.0), Goal("final_error_max_m", 0.3)),
    "no_imu": (
        Goal("error_max_m", 0.3),
        Goal("turn_error_max_deg", 2.0),
        Goal("clouds_error_max_m", 0.3),
        Goal("clouds_turn_error_max_deg", 2.0),
    ),
    "corridor": (
        Goal("length_excess_worst_m", 0.0),
        Goal("gap_worst_m", 0.3),
        Goal("published_by_best_after_closures", 1.2),
        Goal("ate_worst_m", 0.3),
        Goal("cpu_ms_p95", 40.0),
        Goal("peak_mb", 300.0),
    ),
    "hold_x1": (Goal("ate_worst_m", 0.10), Goal("cpu_ms_p95", 40.0)),
    "hold_x3": (Goal("ate_worst_m", 0.15), Goal("cpu_ms_p95", 40.0)),
    "repeated": (Goal("false_closures", 0.0),),
    "hall": (Goal("cpu_ms_per_scan", 30.0), Goal("peak_mb", 500.0)),
    "beams10000": (Goal("cpu_ms_per_scan", 60.0),),
}
"""By the log's name in the keys."""


def as_table(measured: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the table of goals and metrics by the logs' names; a log that was not measured is left out."""
    return table(HEADER, _rows(measured))


def _rows(measured: Mapping[str, Mapping[str, Any]]) -> Iterable[tuple]:
    for log, goals in GOALS.items():
        for goal in goals if log in measured else ():
            value = measured[log][goal.metric]
            alone = measured[log].get("without_loop_closure", {}).get(goal.metric)
            reached = "yes" if value <= goal.most else "no"
            yield log, goal.metric, _number(goal.most), _number(value), reached, _number(alone)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}" if value < 100.0 else f"{value:.0f}"
