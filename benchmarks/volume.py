"""The map of voxels beside OctoMap: a level Puck (28,800 points) in an empty hold of 30 x 20 x 10 m.

Both get the same clouds and poses, and both streams must be equal. Times are CPU times of the thread. The
path is a round of the hold with climbs, at some 1 m/s; clouds come at 20 Hz. Keys: volume.hold.puck.{equal,
insertion_ms, insertion_p99_ms, octomap_ms, octomap_lazy_ms, times_octomap, times_lazy, flight_ms,
flight_p99_ms, flight_cores, message_ms, octomap_message_ms, nodes, cloud_kb, rss_mb, rebuild_s,
rebuild_wall_s, rebuild_nodes}.

`--rows flown`: `hold_3d` flown without GNSS between the bottom and the deck, by odometry from clouds. Keys:
volume.hold_3d.{puck, m8}.{flights, flown, contact}, and {p95_m, within_a_voxel, mapped, free_right, ate_m,
parts.THING}.{median, worst}. volume.hold.{ust, urg}: Experiment 4 without GNSS, whose lidar nods at each
stop.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared.results import ROOT, Results, table
from benchmarks.shared.trials import run_all, trial_options
from benchmarks.volume_rows import flown, nodding
from flights.trials.trial import Trial
from gridslam.volume import (
    Board,
    CorrectedMap,
    Pose,
    Rebuilding,
    ShownMap,
    VolumeParameters,
    VoxelMap,
    stream_of,
)
from gridslam.volume.warm_up import warm_up_volume

sys.path.append(str(ROOT / "src/gridslam/test"))

from room_clouds import puck_directions, ranges_in_hold

ROWS, LIDARS, WORLD = ("speed", "flown"), ("puck", "m8"), "hold_3d"
NODDING = ("ust", "urg")
SEEDS = (21, 22, 23)
"""Nothing was developed on these."""
RATE_HZ = 20.0
SETTLE_S = 5.0
"""Between two paths of SLAM."""
PERIOD_S = 40.0
"""Of a round: an ellipse, with a climb and a descent."""


def pose_at(time_s: float) -> Pose:
    """Return the lidar's pose in the hold."""
    turn = 2.0 * np.pi * time_s / PERIOD_S
    x, y, z = 15.0 + 9.0 * np.cos(turn), 10.0 + 5.0 * np.sin(turn), 4.0 + 2.5 * np.sin(0.5 * turn)
    return Pose(Pose.level(0.0, 0.0, turn + np.pi / 2.0).rotation, np.array((x, y, z)))


def cloud_at(time_s: float) -> np.ndarray:
    """Return the cloud (n, 3) in the lidar's frame."""
    directions, pose = puck_directions(), pose_at(time_s)
    seed = int(time_s * 1000.0)
    ranges = ranges_in_hold(pose.translation, directions @ pose.rotation.T, seed=seed)
    return (directions * ranges[:, None]).astype(np.float32)


def cpu_ms(call: Callable[..., Any], *given: Any) -> float:
    """Return the thread's CPU time of a call."""
    start = time.thread_time()
    call(*given)
    return 1e3 * (time.thread_time() - start)


def insert(voxels: VoxelMap, origin: np.ndarray, points: np.ndarray, board: Board) -> None:
    """Enter a cloud (n, 3) of the map's frame, seen from an origin (3,)."""
    voxels.insert(voxels.rays(origin, points), board)


def insertion(clouds: int) -> dict[str, float]:
    """Insert the same clouds into OctoMap's tree, into a lazy one, and into ours."""
    import pyoctomap

    parameters, board = VolumeParameters(), Board()
    voxels, tree, lazy = VoxelMap(parameters), pyoctomap.OcTree(0.1), pyoctomap.OcTree(0.1)
    times: dict[str, list[float]] = {"ours": [], "octomap": [], "lazy": []}
    for number in tqdm(range(clouds), "clouds beside OctoMap"):
        pose, points = pose_at(2.0 * number), cloud_at(2.0 * number)
        world, origin = pose.of_points(points), pose.translation.astype(np.float32)
        doubles = world.astype(float), origin.astype(float)
        times["ours"].append(cpu_ms(insert, voxels, origin, world, board))
        times["octomap"].append(cpu_ms(tree.insertPointCloud, *doubles))
        times["lazy"].append(cpu_ms(lazy.insertPointCloud, *doubles, -1.0, True))
    theirs = tree.write()
    ours = stream_of(voxels, is_binary=False).data
    medians = {name: float(np.median(each[1:])) for name, each in times.items()}
    with tempfile.TemporaryDirectory() as folder:
        message_ms = cpu_ms(tree.writeBinary, str(Path(folder) / "map.bt"))
    return {
        "equal": theirs[theirs.index(b"\ndata\n") + 6 :] == ours,
        "insertion_ms": medians["ours"],
        "insertion_p99_ms": float(np.percentile(times["ours"][1:], 99.0)),
        "octomap_ms": medians["octomap"],
        "octomap_lazy_ms": medians["lazy"],
        "times_octomap": medians["octomap"] / medians["ours"],
        "times_lazy": medians["lazy"] / medians["ours"],
        "octomap_message_ms": message_ms,
    }


def flight(seconds: float, nodes: int) -> dict[str, float]:
    """Fly, take the message's time, and move all nodes by a closure's correction."""
    before_mb = rss_mb()
    corrected, shown = CorrectedMap(VolumeParameters()), ShownMap(0.1)
    times, settling = [], []
    for number in tqdm(range(int(seconds * RATE_HZ)), "flight"):
        time_s = number / RATE_HZ
        points, pose = cloud_at(time_s), pose_at(time_s)
        times.append(cpu_ms(corrected.add, time_s, points, pose, Pose.identity()))
        if number % int(RATE_HZ) == 0:
            shown.refresh(corrected)
        if number % int(SETTLE_S * RATE_HZ) == 0:
            settling.append(cpu_ms(_settle, corrected))
    time_s = seconds
    while len(corrected.nodes) < nodes:
        time_s += 0.25
        corrected.add(time_s, cloud_at(time_s), pose_at(time_s), Pose.identity())
    shown.refresh(corrected)
    _settle(corrected)
    message_ms = float(np.median([cpu_ms(shown.octree) for _ in range(5)]))
    memory_mb, count = rss_mb() - before_mb, len(corrected.nodes)
    correction = [Pose.level(0.2, -0.1, 0.02) @ node.sensor_in_map for node in corrected.nodes[-nodes:]]
    kept = [node.sensor_in_map for node in corrected.nodes[:-nodes]]
    wall_s, began = time.perf_counter(), time.thread_time()
    rebuilding = Rebuilding(corrected, kept + correction)
    rebuilding.take_over()
    return {
        "flight_ms": float(np.median(times)),
        "flight_p99_ms": float(np.percentile(times, 99.0)),
        "flight_cores": float(np.mean(times)) * 1e-3 * RATE_HZ,
        "settling_cores": 1e-3 * sum(settling) / seconds,
        "message_ms": message_ms,
        "nodes": count,
        "cloud_kb": float(np.mean([len(node.cloud.packed) for node in corrected.nodes])) / 1e3,
        "rss_mb": memory_mb,
        "rebuild_nodes": rebuilding.moved,
        "rebuild_s": time.thread_time() - began,
        "rebuild_wall_s": time.perf_counter() - wall_s,
    }


def _settle(corrected: CorrectedMap) -> None:
    """Settle old clouds, as slam_octomap does with each path on which nothing moves."""
    Rebuilding(corrected, [node.sensor_in_map for node in corrected.nodes]).settle()


def rss_mb() -> float:
    """Return this process's memory without the pages of files, which the system may drop at any time."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    lines = dict(line.split(":", 1) for line in status.splitlines())
    return int(lines["RssAnon"].split()[0]) * 1024 / 1e6


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--rows", nargs="+", default=ROWS, choices=ROWS)
    parser.add_argument("--seeds", nargs="+", type=int, default=None, help="of the flown rows")
    parser.add_argument(
        "--lidars", nargs="+", default=LIDARS, choices=(*LIDARS, *NODDING), help="of the flown rows"
    )
    parser.add_argument("--minutes", type=float, default=2.0, metavar="MIN", help="of a flown flight")
    parser.add_argument("--clouds", type=int, default=12, metavar="NUMBER", help="beside OctoMap")
    parser.add_argument("--seconds", type=float, default=60.0, metavar="S", help="of the flight")
    parser.add_argument("--nodes", type=int, default=300, metavar="NUMBER", help="that the closure moves")
    given = parser.parse_args(arguments)
    with Results("volume", given.results, vars(given)) as results:
        if "speed" in given.rows:
            warm_up_volume()
            # The flight first: its memory would fit into what OctoMap frees
            of_flight = flight(10.0 if given.brief else given.seconds, 60 if given.brief else given.nodes)
            numbers = {**insertion(5 if given.brief else given.clouds), **of_flight}
            results.add("volume.hold.puck", numbers)
            print(table(("key", "value"), [(name, round(value, 3)) for name, value in numbers.items()]))
        if "flown" in given.rows:
            _fly(given, results)


def _fly(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or SEEDS[: 1 if given.brief else None]
    lidars, minutes = given.lidars[: 1 if given.brief else None], 0.3 if given.brief else given.minutes
    trials = {lidar: [_trial(lidar, seed, minutes) for seed in seeds] for lidar in lidars}
    done = iter(run_all("volume", [trial for each in trials.values() for trial in each], given))
    for lidar, its in trials.items():
        numbers = flown.summary([next(done) for _ in its])
        results.add(f"volume.{nodding.WORLD if lidar in NODDING else WORLD}.{lidar}", numbers)
        print(lidar, json.dumps(numbers))


def _trial(lidar: str, seed: int, minutes: float) -> Trial:
    if lidar in NODDING:
        return Trial(f"{lidar} nods {seed}", nodding.fly, {"lidar": lidar, "seed": seed})
    given = {"world": WORLD, "lidar": lidar, "seed": seed, "minutes": minutes}
    return Trial(" ".join(map(str, given.values())), flown.fly, given)


if __name__ == "__main__":
    main()
