"""Laps in known corridors for two hours: memory and CPU time of the second hour beside those of the first.

    python -m benchmarks.slam_rows.two_hours two_hours 1        seed 1
    python -m benchmarks.slam_rows.two_hours two_hours 1 0.5    half an hour of it: two times a quarter

prints metrics as JSON. Truth, scans and odometry are made here. `kb_per_node` is what the first half adds to
the process's memory, by its nodes. `growth_mb` is what the second half adds.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from typing import Iterator

import numpy as np

from benchmarks.shared.results import ROOT
from gridslam import SlamParameters, se2
from gridslam.evaluation import Walls
from gridslam.session import SlamSession
from gridslam.warm_up import warm_up

STEP_M, PERIOD_S = 0.25, 0.5
"""Between two scans: 0.5 m/s."""
HALF_M = (12.0, 6.0)
"""The middle of the corridor is a rectangle of twice this."""
ASIDE_M = 0.1
"""Standard deviation of each lap's place across the corridor."""


def corridors(seed: int) -> Walls:
    """Return a corridor of 2 m round a block, with niches of many sizes on both sides."""
    rng, polygons = np.random.default_rng(seed), []
    for reach, side in ((1.0, 1.0), (-1.0, -1.0)):
        corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) * (np.array(HALF_M) + reach)
        outline = []
        for start, end in zip(corners, np.roll(corners, -1, axis=0)):
            length = math.dist(start, end)
            along = (end - start) / length
            out = side * np.array((along[1], -along[0]))
            place = rng.uniform(1.0, 3.0)
            outline.append(start)
            while place < length - 2.5:
                wide, deep = rng.uniform(0.5, 1.2), rng.uniform(0.2, 0.6)
                near, far = start + place * along, start + (place + wide) * along
                outline += [near, near + deep * out, far + deep * out, far]
                place += wide + rng.uniform(1.0, 4.0)
        polygons.append(np.array(outline))
    return Walls.from_polygons(polygons)


def laps(hours: float, seed: int) -> np.ndarray:
    """Return the true poses (k, 3) of laps, each a little aside from the others."""
    sys.path.insert(0, str(ROOT / "src/gridslam/test"))
    from planar_world import along

    rng, count = np.random.default_rng((seed, 1)), round(hours * 3600.0 / PERIOD_S)
    corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    each_m = 4.0 * sum(HALF_M)
    asides = ASIDE_M * rng.standard_normal(math.ceil(count * STEP_M / each_m) + 1)
    route = np.concatenate([corners * (np.array(HALF_M) + aside) for aside in asides])
    return along(route, STEP_M)[:count]


def main() -> None:
    """Drive once, and print."""
    seed, hours = int(sys.argv[2]), float(sys.argv[3]) if len(sys.argv) > 3 else 2.0
    print(json.dumps(measure(seed, hours)))


def measure(seed: int, hours: float) -> dict[str, float]:
    """Return the metrics of so many hours."""
    truth = laps(hours, seed)
    session = SlamSession(SlamParameters(seed=seed, threads=1), starting_pose=tuple(truth[0].tolist()))
    warm_up()
    halves = [Half(), Half()]
    memory_mb, nodes, errors_m, published = [rss_mb()], [0], [], []
    for index, (scan, base) in enumerate(_log(truth, seed)):
        half = halves[2 * index // len(truth)]
        began_s = time.process_time()
        update = session.process(scan, base)
        half.cpu_s += time.process_time() - began_s
        half.scans += update is not None
        pose = se2.compose(np.array(session.map_to_odom), base)
        errors_m.append(math.dist(pose[:2], truth[index, :2]))
        published.append(session.tracking is not None and session.tracking.state == "tracking")
        if index + 1 in (len(truth) // 2, len(truth)):
            memory_mb.append(rss_mb())
            nodes.append(len(session.slam.processed_scans()) if session.slam is not None else 0)
    wrong = (np.array(errors_m) > 0.5) & np.array(published)
    return {
        "nodes": nodes[2],
        "nodes_second_half": nodes[2] - nodes[1],
        "kb_per_node": 1e3 * (memory_mb[1] - memory_mb[0]) / max(1, nodes[1]),
        "half_mb": memory_mb[1],
        "end_mb": memory_mb[2],
        "growth_mb": memory_mb[2] - memory_mb[1],
        "cpu_ms_first_half": halves[0].cpu_ms,
        "cpu_ms_second_half": halves[1].cpu_ms,
        "cpu_growth": halves[1].cpu_ms / halves[0].cpu_ms,
        "error_max_m": float(max(errors_m)),
        "tracking_above_half_a_metre": float(wrong.mean()),
    }


class Half:
    """CPU time and number of scans of a half."""

    def __init__(self) -> None:
        self.cpu_s, self.scans = 0.0, 0

    @property
    def cpu_ms(self) -> float:
        """A processed scan, ms."""
        return 1e3 * self.cpu_s / max(1, self.scans)


def _log(truth: np.ndarray, seed: int) -> Iterator[tuple]:
    """Yield the scan and odometry (3,) at each pose."""
    from planar_world import UST, Drift, drifting, scan_at

    walls, rng = corridors(seed), np.random.default_rng((seed, 2))
    for index, (pose, base) in enumerate(zip(truth, drifting(truth, Drift(), rng))):
        yield scan_at(walls, pose, UST, rng, PERIOD_S * index), base


def rss_mb() -> float:
    """Return the memory that the process holds now, MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


if __name__ == "__main__":
    main()
