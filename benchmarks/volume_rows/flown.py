"""A hold flown without GNSS with climbs, its map of voxels by the odometry's poses, and how true it is."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import numpy as np

from benchmarks.gnss_rows.climb_places import CLIMBS
from benchmarks.gnss_rows.climbs import parameters_of
from exploration.planning import PathPlanner, PlannerParameters
from flights.exploring.flown_clouds import FlownClouds
from flights.exploring.volume_of_flight import VolumeOfFlight
from flights.flight.closed_loop import ClosedLoop
from gridslam.cloud_odometry.warm_up import warm_up_cloud_odometry
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.evaluation.volume.surface import read_surface
from gridslam.evaluation.volume.visibility import Places
from gridslam.evaluation.volume.volume_error import VolumeError, volume_error
from gridslam.evaluation.volume.voxels import voxels_of
from gridslam.volume import FLAT_MISS, Pose, VolumeParameters
from gridslam.volume.warm_up import warm_up_volume
from simulation_tools.sensors.cloud import CloudLidar

RESOLUTION_M, RANGE_M = 0.1, 30.0
"""Of volume.launch. `miss` is that of mapping.launch."""
METRICS = ("p95_m", "within_a_voxel", "mapped", "free_right", "ate_m")
LESS_IS_WORSE = ("within_a_voxel", "mapped", "free_right")


def fly(world: str, lidar: str, seed: int, minutes: float) -> dict:
    """Fly about so many minutes; return how true the map is.

    p95_m: 95 % of the occupied voxels are nearer to a true surface. mapped: share of the visible true surface
    with an occupied voxel within one voxel; parts: the same for each thing of the world. visible_m2: of it.
    """
    warm_up_cloud_odometry()
    warm_up_volume()
    climb = CLIMBS[world]
    with ClosedLoop(parameters_of(climb, lidar, seed)) as empty:
        rays = empty.simulation.world.rays
        mission = climb.mission(rays, np.random.default_rng(seed), 60.0 * minutes)
    volume = VolumeOfFlight(
        PathPlanner(PlannerParameters()),
        VolumeParameters(resolution_m=RESOLUTION_M, max_range_m=RANGE_M, miss=FLAT_MISS),
    )
    places: list[Pose] = []
    with ClosedLoop(parameters_of(climb, lidar, seed, mission)) as loop:
        clouds = FlownClouds(loop, volume, "This row")
        while not loop.is_over:
            output = loop.step()
            clouds.take(output)
            for sensor in output.payload if output.ground_truth else ():
                if isinstance(sensor.device, CloudLidar) and output.ground_truth is not None:
                    true = output.ground_truth.pose @ sensor.mount.pose
                    places.append(Pose(true.rotation, np.array(true.position_m)))
        outcome, truth = loop.outcome, loop.log.truth.array("t_s", "x_m", "y_m", "z_m")
        assert loop.own_odometry is not None  # there is no GNSS
        estimates = loop.own_odometry.estimates[1:]
    times_s = [estimate.stamp_s for estimate in estimates]
    known = np.column_stack([np.interp(times_s, truth[:, 0], truth[:, axis]) for axis in (1, 2, 3)])
    off_m = np.linalg.norm(np.array([estimate.position_xyz for estimate in estimates]) - known, axis=1)
    rng, surface = np.random.default_rng(seed), read_surface(climb.world)
    seen_from = Places(
        np.array([each.translation for each in places]), np.array([each.rotation for each in places])
    )
    view = replace(VIEWS[lidar], range_max_m=RANGE_M)
    voxels = voxels_of(volume.corrected.voxels, Pose.identity(), rng)
    error, _ = volume_error(voxels, surface, rng, seen_from, view)
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "minutes": times_s[-1] / 60.0,
        "nodes": len(volume.corrected.nodes),
        "ate_m": float(np.sqrt(np.square(off_m).mean())),
        **figures_of(error),
    }


def figures_of(error: VolumeError) -> dict:
    """Return how true a map of voxels is, by the names of `METRICS`."""
    return {
        "p95_m": error.p95_m,
        "mean_m": error.mean_m,
        "within_a_voxel": error.within_a_voxel,
        "visible_m2": error.visible_m2,
        "mapped": error.mapped,
        "free_right": error.free_right,
        "parts": error.mapped_by_part,
    }


def summary(trials: Sequence[dict]) -> dict:
    """Return counts, and median and worst of each figure and of each part's mapped share."""
    counts = {key: sum(trial[key] for trial in trials) for key in ("flown", "contact")}
    parts = {
        name: _spread([trial["parts"][name] for trial in trials if name in trial["parts"]], is_share=True)
        for name in sorted({name for trial in trials for name in trial["parts"]})
    }
    figures = {key: _spread([trial[key] for trial in trials], key in LESS_IS_WORSE) for key in METRICS}
    return {"flights": len(trials), **counts, **figures, "parts": parts}


def _spread(values: Sequence[float], is_share: bool) -> dict[str, float]:
    return {"median": float(np.median(values)), "worst": min(values) if is_share else max(values)}
