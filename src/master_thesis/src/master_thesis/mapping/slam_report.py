"""How good a map and a path are, as figures: what result.json and the tables say of SLAM."""

from __future__ import annotations

import math

from gridslam.errors import EvaluationError
from gridslam.evaluation import MapAccuracy, TrajectoryError, Walls, map_error, trajectory_error
from gridslam.trajectory import Trajectory
from master_thesis.mapping.slam_run import SlamRun
from master_thesis.results import metrics, run_report


def judge(run: SlamRun, truth: Trajectory, walls: Walls) -> tuple[dict, TrajectoryError, MapAccuracy]:
    """Return the figures of merit, and what they were taken from: the final path's and the map's errors.

    No alignment: `map` begins where `world` does, so every error is SLAM's own.

    Raises:
        EvaluationError: there is nothing to judge: no path, or an empty map.
    """
    path = trajectory_error(run.final, truth)
    accuracy = map_error(run.grid, walls)
    figures = {
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
        "cpu_ms_per_scan": metrics.summary(run.cpu_ms),
    }
    return figures, path, accuracy


def _aligned_ate(path: Trajectory, truth: Trajectory) -> float | None:
    """Return the error that the best rigid alignment leaves; None: a straight path fixes no rotation."""
    try:
        return trajectory_error(path, truth, align="all").ate_rmse_m
    except EvaluationError:
        return None


def verdict(figures: dict) -> str:
    """Return our words for a map, beside which a table puts the thesis's."""
    ate, p95 = figures["ate_rmse_m"], figures["map_error_p95_m"]
    turned = math.degrees(figures["wall_turned_max_rad"])
    if ate < 0.1 and p95 < 0.15:
        return "true to the world"
    if ate < 0.3 and p95 < 0.4:
        return f"true but for walls bent or turned by up to {turned:.1f} degrees"
    if ate < 1.0:
        return "recognisable, walls bent and doubled"
    return "broken: the ends do not meet"


def headline(content: dict) -> str:
    """Return the figures of a run of Experiment 3 or 4 in a few lines for a terminal."""
    lines = run_report.headline(content)
    slam = content.get("slam")
    if slam is None:
        return lines
    rows = {
        "ATE, at the end, online": "{ate_rmse_m:.3f} m, {ate_online_rmse_m:.3f} m".format(**slam),
        "map error, mean, 95 %": "{map_error_mean_m:.3f} m, {map_error_p95_m:.3f} m".format(**slam),
        "true wall seen": f"{100 * slam['wall_seen_share']:.0f} %",
        "odometry alone, ATE": f"{slam['odometry_ate_rmse_m']:.2f} m",
        "loops closed": slam["closures"],
        "SLAM's cores, memory": _costs(slam),
        "the map is": verdict(slam),
    }
    return "\n".join([lines, *(f"  {name:<22} {value}" for name, value in rows.items())])


def _costs(slam: dict) -> str:
    share, memory = slam.get("cpu_share"), slam.get("peak_memory_mb")
    if share is None or memory is None:
        return "-"
    return f"{share:.2f}, {memory:.0f} MB"
