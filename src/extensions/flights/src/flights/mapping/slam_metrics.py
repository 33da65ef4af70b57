"""The metrics of SLAM: the ATE of its path and the error of its map."""

from __future__ import annotations

import math

from flights.mapping.slam_run import SlamRun
from flights.results.metrics import statistics_of
from gridslam.errors import EvaluationError
from gridslam.evaluation import MapAccuracy, TrajectoryError, Walls, map_error, trajectory_error
from gridslam.trajectory import Trajectory

SEEN_MIN = 0.5
"""A map that shows a smaller share of the true walls is only a part of one, however exact."""


def slam_metrics_of(
    run: SlamRun, truth: Trajectory, walls: Walls
) -> tuple[dict, TrajectoryError, MapAccuracy]:
    """Return the metrics, and the errors of the final path and of the map.

    No alignment: `map` begins where `world` does, so every error is SLAM's own.

    Raises:
        EvaluationError: there is no path, or the map is empty.
    """
    path = trajectory_error(run.final, truth)
    accuracy = map_error(run.grid, walls)
    metrics = {
        "ate_rmse_m": path.ate_rmse_m,
        "ate_max_m": path.ate_max_m,
        "ate_rotation_rmse_deg": path.ate_rotation_rmse_deg,
        "ate_online_rmse_m": trajectory_error(run.online, truth).ate_rmse_m,
        "ate_aligned_rmse_m": _aligned_ate(run.final, truth),
        "end_error_m": float(path.errors_m[-1]),
        **accuracy.as_dict(),
        "closures": len(run.closures),
        "scans": run.scans,
        "scans_processed": len(run.final.stamps_s),
        "cpu_ms_per_scan": statistics_of(run.cpu_ms),
    }
    return metrics, path, accuracy


def _aligned_ate(path: Trajectory, truth: Trajectory) -> float | None:
    """Return the ATE after the best rigid alignment; None for a straight path (undefined rotation)."""
    try:
        return trajectory_error(path, truth, align="all").ate_rmse_m
    except EvaluationError:
        return None


def verdict(metrics: dict) -> str:
    """Return our description of a map, to compare with the thesis's."""
    words, seen = _of_what_is_mapped(metrics), metrics["wall_seen_share"]
    if seen < SEEN_MIN:
        return f"only a part, {100 * seen:.0f} % of the walls; this part is {words}"
    return words


def _of_what_is_mapped(metrics: dict) -> str:
    ate, p95 = metrics["ate_rmse_m"], metrics["map_error_p95_m"]
    turned = math.degrees(metrics["wall_turned_max_rad"])
    if ate < 0.1 and p95 < 0.15:
        return "true to the world"
    if ate < 0.3 and p95 < 0.4:
        return f"true but for walls bent or turned by up to {turned:.1f} degrees"
    if ate < 1.0:
        return "recognisable, walls bent and doubled"
    return "broken: the ends do not meet"
