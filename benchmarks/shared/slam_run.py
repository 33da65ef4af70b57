"""Maps one log with gridslam in a separate process, to measure its memory and time.

    python -m benchmarks.shared.slam_run intel 1 DATA      the Intel Research Lab, seed 1
    python -m benchmarks.shared.slam_run beams360 1        a simulated hold, seen with 360 beams
    python -m benchmarks.shared.slam_run beams10000 1      the same, seen with 10,000
    python -m benchmarks.shared.slam_run hall 1            a hall of 300 x 300 m, seen with 80 m
    python -m benchmarks.shared.slam_run hall_closed 1     the same, with loop closure; all others without

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
from typing import Any, Callable, Iterable

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "src/gridslam" / part) for part in ("src", "test")]

from gridslam import PlanarScan, SlamParameters, se2  # noqa: E402
from gridslam.session import SlamSession  # noqa: E402
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


def run(
    scans: Iterable[PlanarScan], odometry: np.ndarray, parameters: SlamParameters, loop_closure: bool = False
) -> Run:
    """Let the filter take in a log, and draw maps periodically."""
    warm_up()
    session = SlamSession(parameters, loop_closure)
    stamps, online, renderings, costs_s, cpu_s = [], [], [], [], 0.0
    for scan, base in zip(scans, odometry):
        stamps.append(scan.stamp_s)
        began = time.process_time()
        update = session.process(scan, base)
        cpu_s += time.process_time() - began
        map_to_odom = session.map_to_odom
        assert map_to_odom is not None  # since the first scan
        online.append(se2.compose(map_to_odom, base))
        if update is not None:
            costs_s.append(cpu_s)
            cpu_s = 0.0
            if len(costs_s) % RENDER_EVERY == 0:
                began = time.process_time()
                session.grid()
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
    return Run(
        np.array(stamps), np.array(online), session.trajectory().filled(np.array(stamps), odometry), cost
    )


def intel(seed: int, data: Path) -> dict:
    """The dense log, compared with the relations: online and final path, exact relations and all."""
    from gridslam.evaluation.relations import read_relations, relation_errors
    from gridslam.logs.carmen import planar_scans
    from gridslam.trajectory import Trajectory

    scans, odometry = zip(*planar_scans(data / "intel_dense.log.gz"))
    outcome = run(scans, np.array(odometry), SlamParameters(maxUrange=40.0, seed=seed, threads=1))
    relations = read_relations(data / "intel.relations.gz")
    metrics = dict(outcome.cost)
    for which, chosen in (("exact", relations.exact(outcome.stamps_s)), ("all", relations)):
        for when in ("final", "online"):
            errors = relation_errors(Trajectory(outcome.stamps_s, getattr(outcome, when)), chosen)
            metrics[f"{which}_{when}_m"] = errors.translation_mean_m
            metrics[f"{which}_{when}_deg"] = errors.rotation_mean_deg
    return metrics


def beams(count: int, laps: float, seed: int) -> dict:
    """Round the cargo hold with this many beams of 30 m."""
    from planar_world import Lidar, along, hold, rectangle_route

    lidar = Lidar(2.0 * math.pi * (count - 1) / count, count, 30.0, 0.01, 10.0)
    route = along(rectangle_route(11.0, 6.0, laps=laps), 0.1)
    return _simulated(hold(), route, lidar, SlamParameters(seed=seed, threads=1))


def hall(seed: int, loop_closure: bool = False) -> dict:
    """Once round a hall of 300 x 300 m with pillars, seen with a lidar of 80 m."""
    from planar_world import Lidar, along, rectangle_route

    from gridslam.evaluation import Walls

    places = np.arange(-120.0, 121.0, 30.0)
    pillars = [_square(x, y, 0.5) for x in places for y in places]
    route = along(rectangle_route(110.0, 110.0), 0.5)
    lidar = Lidar(2.0 * math.pi * 719 / 720, 720, 80.0, 0.02, 10.0)
    walls = Walls.from_polygons([_square(0.0, 0.0, 150.0), *pillars])
    parameters = SlamParameters(maxUrange=80.0, seed=seed, threads=1)
    return _simulated(walls, route, lidar, parameters, loop_closure)


def _square(x: float, y: float, half_m: float) -> np.ndarray:
    return half_m * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) + (x, y)


def _simulated(
    walls: Any, route: np.ndarray, lidar: Any, parameters: SlamParameters, loop_closure: bool = False
) -> dict:
    from planar_world import Drift, drifting, scan_at

    rng = np.random.default_rng(parameters.seed)
    odometry = drifting(route, Drift(), rng)
    scans = (scan_at(walls, pose, lidar, rng, 0.1 * index) for index, pose in enumerate(route))
    outcome = run(scans, odometry, parameters, loop_closure)
    errors = np.hypot(*(outcome.final - route)[:, :2].T)
    return {**outcome.cost, "ate_rmse_m": float(np.sqrt(np.mean(errors**2)))}


RUNS: dict[str, Callable[..., dict]] = {
    "intel": lambda seed, data: intel(seed, Path(data)),
    "beams360": lambda seed: beams(360, 2.0, seed),
    "beams10000": lambda seed: beams(10_000, 0.5, seed),
    "hall": hall,
    "hall_closed": lambda seed: hall(seed, loop_closure=True),
}

if __name__ == "__main__":
    name, seed, *data = sys.argv[1:]
    print(json.dumps(RUNS[name](int(seed), *data)))
