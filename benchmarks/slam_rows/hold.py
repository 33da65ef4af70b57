"""Experiment 4's hold with every lidar, and odometry that drifts as by default or three times as much.

Each flight is flown once in the ROS-free closed loop; SLAM then maps its recording with loop closure.
"""

from __future__ import annotations

import argparse
import resource
from dataclasses import asdict
from typing import Sequence

import numpy as np

from benchmarks.shared.trials import run_crossed
from benchmarks.slam_rows.logs import summary
from flights.mapping.mapping_flight import parameters_of
from flights.mapping.slam_metrics import slam_metrics_of
from flights.worlds.scenario import LIDARS
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import MappedFlight
from simulation_tools.sensors.odometry import OdometryParameters

DRIFTS = (1, 3)


def measure(seeds: Sequence[int], given: argparse.Namespace) -> dict[str, dict]:
    """Return the metrics of `hold_x1` and `hold_x3`: over all lidars, and under each lidar's name."""
    runs = run_crossed("slam_hold", fly_and_map, given, drift=DRIFTS, lidar=LIDARS, seed=seeds)
    found = {}
    for drift in DRIFTS:
        of_lidar = {lidar: summary([runs[drift, lidar, seed] for seed in seeds]) for lidar in LIDARS}
        whole = summary([run for (times, _, _), run in runs.items() if times == drift])
        found[f"hold_x{drift}"] = {**whole, **of_lidar}
    return found


def fly_and_map(drift: int, lidar: str, seed: int) -> dict:
    """Fly once; return the ATE of the path, which begins at its true pose, and the cost.

    The peak of memory is that of the whole process, which flies, too.
    """
    warm_up()
    odometry = OdometryParameters(
        **{name: drift * value for name, value in asdict(OdometryParameters()).items()}
    )
    flight = MappedFlight.fly("hold", lidar, seed, parameters_of("hold", lidar, seed, odometry))
    run = flight.map(seed, loop_closure=True)
    metrics, _, _ = slam_metrics_of(run, flight.truth, flight.walls)
    return {
        "ate_m": metrics["ate_rmse_m"],
        "ate_online_m": metrics["ate_online_rmse_m"],
        "cpu_ms_per_scan": float(np.mean(run.cpu_ms)),
        "cpu_ms_p95": float(np.percentile(run.cpu_ms, 95)),
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "loops_closed": len(run.closures),
    }
