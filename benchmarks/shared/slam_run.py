"""Maps one log with gridslam in a separate process, to measure its memory and time.

    python -m benchmarks.shared.slam_run intel 1 DATA      the Intel Research Lab, seed 1
    python -m benchmarks.shared.slam_run beams360 1        a simulated hold, seen with 360 beams
    python -m benchmarks.shared.slam_run beams10000 1      the same, seen with 10,000
    python -m benchmarks.shared.slam_run hall 1            a hall of 300 x 300 m, seen with 80 m

prints metrics as JSON.
"""

from __future__ import annotations

import dataclasses
import json
import math
import resource
import sys
import time
from pathlib import Path
from typing import Any, Callable, Iterable, Sequence

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "src/gridslam" / part) for part in ("src", "test")]

from gridslam import GridSlam, PlanarScan, SlamParameters, se2  # noqa: E402
from gridslam.warm_up import warm_up  # noqa: E402

RENDER_EVERY = 5
"""Processed scans between two maps; at gmapping's thresholds that is about its map_update_interval of 5 s."""


@dataclasses.dataclass(frozen=True)
class Run:
    """A log's outcome: stamps_s (n,), odometry, online and final poses (n, 3) at every scan, and the cost."""

    stamps_s: np.ndarray
    online: np.ndarray
    final: np.ndarray
    cost: dict


def run(scans: Iterable[PlanarScan], odometry: np.ndarray, parameters: SlamParameters) -> Run:
    """Let the filter take in a log, and draw maps periodically."""
    warm_up()
    slam = GridSlam(parameters, starting_pose=tuple(odometry[0]))
    stamps, online, renderings, costs_s, cpu_s = [], [], [], [], 0.0
    for scan, base in zip(scans, odometry):
        stamps.append(scan.stamp_s)
        began = time.process_time()
        update = slam.process(scan, base)
        cpu_s += time.process_time() - began
        online.append(se2.compose(slam.map_to_odom, base))
        if update is not None:
            costs_s.append(cpu_s)
            cpu_s = 0.0
            if len(costs_s) % RENDER_EVERY == 0:
                began = time.process_time()
                slam.grid()
                renderings.append(time.process_time() - began)
    first, *_, last = np.array_split(costs_s, 4)
    cost = {
        "processed": len(costs_s),
        "cpu_ms_per_scan": 1e3 * float(np.mean(costs_s)),
        "cpu_ms_p95": 1e3 * float(np.percentile(costs_s, 95)),
        "cost_growth": float(np.mean(last) / np.mean(first)),
        "render_ms": 1e3 * float(np.mean(renderings)),
        "render_max_ms": 1e3 * max(renderings),
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }
    return Run(np.array(stamps), np.array(online), slam.trajectory().filled(np.array(stamps), odometry), cost)


def intel(seed: int, data: Path) -> dict:
    """The dense log, compared with the relations: online and final path, exact relations and all."""
    from gridslam.evaluation.relations import read_relations, relation_errors
    from gridslam.logs.carmen import CarmenScan, read_log
    from gridslam.trajectory import Trajectory

    entries = [entry for entry in read_log(data / "intel_dense.log.gz") if isinstance(entry, CarmenScan)]
    scans, odometry = _scans(entries)
    outcome = run(scans, odometry, SlamParameters(maxUrange=40.0, seed=seed, threads=1))
    relations = read_relations(data / "intel.relations.gz")
    metrics = dict(outcome.cost)
    for which, chosen in (("exact", relations.exact(outcome.stamps_s)), ("all", relations)):
        for when in ("final", "online"):
            errors = relation_errors(Trajectory(outcome.stamps_s, getattr(outcome, when)), chosen)
            metrics[f"{which}_{when}_m"] = errors.translation_mean_m
            metrics[f"{which}_{when}_deg"] = errors.rotation_mean_deg
    return metrics


def _scans(entries: Iterable[Any]) -> tuple[list[PlanarScan], np.ndarray]:
    """Return the scans in the order of their stamps, each stamp once, and the robot's odometry."""
    scans, odometry, last = [], [], -math.inf
    for entry in entries:
        if entry.stamp_s <= last:
            continue
        last = entry.stamp_s
        angles = entry.angle_min_rad + np.arange(entry.ranges_m.size) * entry.angle_increment_rad
        lidar = tuple(se2.between(entry.robot_in_odom, entry.lidar_in_odom))
        lidar = lidar if _is_mounting(lidar) else (0.0, 0.0, 0.0)
        scans.append(PlanarScan(last, angles, entry.ranges_m, lidar, entry.range_max_m))
        odometry.append(entry.robot_in_odom)
    return scans, np.array(odometry)


def _is_mounting(lidar: Sequence[float]) -> bool:
    """Return whether a pose is a place on the robot. Some entries hold the lidar's corrected pose instead."""
    return math.hypot(lidar[0], lidar[1]) < 0.5 and abs(lidar[2]) < 0.1


def beams(count: int, laps: float, seed: int) -> dict:
    """Round the cargo hold with this many beams of 30 m."""
    from planar_world import Lidar, along, hold, rectangle_route

    lidar = Lidar(2.0 * math.pi * (count - 1) / count, count, 30.0, 0.01, 10.0)
    route = along(rectangle_route(11.0, 6.0, laps=laps), 0.1)
    return _simulated(hold(), route, lidar, SlamParameters(seed=seed, threads=1))


def hall(seed: int) -> dict:
    """Once round a hall of 300 x 300 m with pillars, seen with a lidar of 80 m."""
    from planar_world import Lidar, along, rectangle_route

    from gridslam.evaluation import Walls

    places = np.arange(-120.0, 121.0, 30.0)
    pillars = [_square(x, y, 0.5) for x in places for y in places]
    route = along(rectangle_route(110.0, 110.0), 0.5)
    lidar = Lidar(2.0 * math.pi * 719 / 720, 720, 80.0, 0.02, 10.0)
    walls = Walls.from_polygons([_square(0.0, 0.0, 150.0), *pillars])
    return _simulated(walls, route, lidar, SlamParameters(maxUrange=80.0, seed=seed, threads=1))


def _square(x: float, y: float, half_m: float) -> np.ndarray:
    return half_m * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) + (x, y)


def _simulated(walls: Any, route: np.ndarray, lidar: Any, parameters: SlamParameters) -> dict:
    from planar_world import Drift, drifting, scan_at

    rng = np.random.default_rng(parameters.seed)
    odometry = drifting(route, Drift(), rng)
    scans = (scan_at(walls, pose, lidar, rng, 0.1 * index) for index, pose in enumerate(route))
    outcome = run(scans, odometry, parameters)
    errors = np.hypot(*(outcome.final - route)[:, :2].T)
    return {**outcome.cost, "ate_rmse_m": float(np.sqrt(np.mean(errors**2)))}


RUNS: dict[str, Callable[..., dict]] = {
    "intel": lambda seed, data: intel(seed, Path(data)),
    "beams360": lambda seed: beams(360, 2.0, seed),
    "beams10000": lambda seed: beams(10_000, 0.5, seed),
    "hall": hall,
}

if __name__ == "__main__":
    name, seed, *data = sys.argv[1:]
    print(json.dumps(RUNS[name](int(seed), *data)))
