"""Writes SLAM's output into a results folder: trajectories, maps, pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from flights.mapping.slam_metrics import slam_metrics_of
from flights.mapping.slam_run import SlamRun
from flights.results.flight_pictures import TimeSeries
from flights.results.picture_files import files
from flights.results.run_folder import RunFolder
from flights.worlds.floor_plan import Outline
from gridslam.evaluation import (
    MapAccuracy,
    TrajectoryError,
    Walls,
    map_error_figure,
    poses_at,
    trajectory_error,
    write_tum,
)
from gridslam.files.map_file import write_map
from gridslam.trajectory import Trajectory
from master_thesis.experiments_3_4 import slam_pictures


@dataclass(frozen=True)
class Surveyed:
    """A flight and the truth for its map.

    title: of the flight. truth, odometry: of the whole flight, in `world` and in `odom`. walls: the true
    walls. outlines: the world from above. height_m: of the flight.
    """

    title: str
    run: SlamRun
    truth: Trajectory
    odometry: Trajectory
    walls: Walls
    outlines: Sequence[Outline]
    height_m: float


def write_survey(folder: RunFolder, survey: Surveyed) -> dict:
    """Write trajectories, maps and pictures of a flight; return its metrics.

    truth.tum, odometry.tum, slam_online.tum, slam_final.tum; map.{pgm, yaml}, map_half_way.{pgm, yaml};
    walls.csv; map.png, map_error.png, error.png.

    Raises:
        EvaluationError: there is no path, or the map is empty.
    """
    run, path = survey.run, folder.path
    for name, trajectory in (
        ("truth", survey.truth),
        ("odometry", survey.odometry),
        ("slam_online", run.online),
        ("slam_final", run.final),
    ):
        write_tum(path / f"{name}.tum", trajectory)
    write_map(path / "map", run.grid)
    write_map(path / "map_half_way", run.half_way)
    folder.write_csv("walls.csv", ("x1_m", "y1_m", "x2_m", "y2_m"), survey.walls.ends_m.tolist())
    metrics, errors, accuracy = slam_metrics_of(run, survey.truth, survey.walls)
    drift = _odometry_error(survey)
    metrics["odometry_ate_rmse_m"] = drift.ate_rmse_m
    _write_pictures(folder, survey, metrics, (errors, drift), accuracy)
    return metrics


def _write_pictures(
    folder: RunFolder,
    survey: Surveyed,
    metrics: dict,
    errors: tuple[TrajectoryError, TrajectoryError],
    accuracy: MapAccuracy,
) -> None:
    run = survey.run
    title = "{}: ATE {:.3f} m, map error {:.3f} m (95 %: {:.3f} m)".format(
        survey.title, metrics["ate_rmse_m"], metrics["map_error_mean_m"], metrics["map_error_p95_m"]
    )
    shown = slam_pictures.world_and_maps(
        title, survey.outlines, survey.height_m, survey.truth.poses_in_map[:, :2], map_views(run)
    )
    folder.write_files(files("map", shown))
    online = trajectory_error(run.online, survey.truth)
    panels = (
        TimeSeries(
            "SLAM [m]",
            (("path at the end", _curve(errors[0])), ("as believed in flight", _curve(online))),
        ),
        TimeSeries("odometry [m]", (("odometry alone", _curve(errors[1])),)),
    )
    folder.write_files(files("error", slam_pictures.error_figure(title, panels, closure_times(run))))
    compared = map_error_figure(run.grid, survey.walls, accuracy, estimate=run.final, truth=survey.truth)
    folder.write_files(files("map_error", compared))


def map_views(run: SlamRun) -> tuple[slam_pictures.MapView, ...]:
    """Return the drawings of the map at half time and at the end."""
    half_s = (run.final.stamps_s[0] + run.final.stamps_s[-1]) / 2
    until_half = run.online.poses_in_map[run.online.stamps_s <= half_s, :2]
    none = np.empty((0, 2, 2))
    return (
        slam_pictures.MapView("map at half time", run.half_way, until_half, none),
        slam_pictures.MapView("map at the end", run.grid, run.final.poses_in_map[:, :2], closure_pairs(run)),
    )


def closure_times(run: SlamRun) -> list[float]:
    """Return the times of loop closures: the stamps of scans that showed a known place."""
    return [closure.stamp_to_s for closure in run.closures]


def closure_pairs(run: SlamRun) -> np.ndarray:
    """Return the places of loop closures: pairs of places on the final path, (k, 2, 2)."""
    stamps = np.array([(closure.stamp_from_s, closure.stamp_to_s) for closure in run.closures])
    return poses_at(run.final, stamps.ravel())[:, :2].reshape(-1, 2, 2)


def _odometry_error(survey: Surveyed) -> TrajectoryError:
    stamps = survey.run.final.stamps_s
    return trajectory_error(Trajectory(stamps, poses_at(survey.odometry, stamps)), survey.truth)


def _curve(error: TrajectoryError) -> np.ndarray:
    return np.column_stack((error.stamps_s, error.errors_m))
