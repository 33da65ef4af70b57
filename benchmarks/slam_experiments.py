"""Experiments 3 and 4 over seeds: how true the maps of all six lidars are (thesis, 8.2).

Each flight is flown once in the ROS-free closed loop and recorded; SLAM then runs on the recording, on one
thread, without and with loop closure. The odometry drifts as by default, and a flight's seed is that of every
random stream, SLAM's particles included. Figures are medians over the seeds.

Figures: slam.room.LIDAR and slam.hold.LIDAR; and results/slam_experiments.md, slam_experiments/*.png of the
first seed.
"""

from __future__ import annotations

import itertools
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks._report import Report, options, table, write_atomically
from benchmarks._thesis import MAPS
from gridslam.warm_up import warm_up
from master_thesis.mapping import slam_figures, slam_files
from master_thesis.mapping.mapping_flight import SCENARIOS, fly_and_record, parameters_of
from master_thesis.mapping.slam_report import judge, verdict
from master_thesis.mapping.slam_run import replay, true_path, true_walls
from master_thesis.mapping.slam_setup import read_setup
from master_thesis.worlds import floor_plan
from master_thesis.worlds.scenario import LIDARS
from simulation_tools.sdf.parser import load_world

WORLDS = ("room", "hold")
SEEDS = (1, 2, 3, 4, 5)
BRIEF_SEEDS = (1,)
FIGURES = {
    "ate_rmse_m": ("ATE [m]", 3),
    "ate_online_rmse_m": ("online [m]", 3),
    "map_error_mean_m": ("map error [m]", 3),
    "map_error_p95_m": ("95 % [m]", 3),
    "wall_seen_share": ("wall seen", 2),
    "closures": ("loops", 0),
    "cpu_ms": ("CPU/scan [ms]", 1),
}
"""The figures of a map: heading and decimals."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, map, print and write."""
    parser = options(__doc__)
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument("--worlds", nargs="+", default=WORLDS, choices=tuple(SCENARIOS))
    parser.add_argument("--lidars", nargs="+", default=LIDARS, choices=LIDARS)
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N", help="processes")
    given = parser.parse_args(arguments)
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    pictures = given.results / "slam_experiments"
    pictures.mkdir(parents=True, exist_ok=True)
    with Report("slam_experiments", given.results, vars(given)) as report:
        maps = map_all(given.worlds, given.lidars, seeds, pictures, given.workers)
        text = "\n".join(as_markdown(world, given.lidars, maps, len(seeds)) for world in given.worlds)
        for world, lidar in itertools.product(given.worlds, given.lidars):
            closing, open_ended = (maps[world, lidar, closure] for closure in (True, False))
            report.add(f"slam.{world}.{lidar}", {**closing, "without_loop_closure": open_ended})
        write_atomically(given.results / "slam_experiments.md", text)
        print(f"\n{text}")


def map_all(
    worlds: Sequence[str], lidars: Sequence[str], seeds: Sequence[int], pictures: Path, workers: int
) -> dict:
    """Return the figures' medians by (world, lidar, loop closure)."""
    flights = list(itertools.product(worlds, lidars, seeds))
    drawn = [pictures if seed == seeds[0] else None for _, _, seed in flights]
    with ProcessPoolExecutor(workers, initializer=warm_up) as pool:
        found = tqdm(pool.map(fly_and_map, *zip(*flights), drawn), "flights", len(flights), unit=" flights")
        by_case: dict = {}
        for (world, lidar, _), cases in zip(flights, found):
            for closure, figures in cases.items():
                by_case.setdefault((world, lidar, closure), []).append(figures)
    return {case: medians(several) for case, several in by_case.items()}


def fly_and_map(world: str, lidar: str, seed: int, pictures: Path | None = None) -> dict[bool, dict]:
    """Fly once; return the map's figures without and with loop closure. pictures: folder to draw into."""
    scenario, setup = SCENARIOS[world], read_setup(SCENARIOS[world].world)
    recording = fly_and_record(f"{world}, {lidar}, seed {seed}", parameters_of(world, lidar, seed))
    truth = true_path(recording.times_s, recording.truth)
    walls = true_walls(scenario.world_path, scenario.flight_height_m, scenario.start_xyz_yaw[:2])
    found = {}
    for closure in (False, True):
        run = replay(recording, setup.session(seed, loop_closure=closure))
        figures, _, _ = judge(run, truth, walls)
        cpu_ms = figures.pop("cpu_ms_per_scan")
        found[closure] = {**figures, "cpu_ms": cpu_ms["mean"] if cpu_ms else None}
        if pictures:
            title = f"{recording.name}, {'with' if closure else 'without'} loop closure"
            draw(pictures / f"{world}_{lidar}{'_closed' if closure else ''}.png", title, scenario, run, truth)
    return found


def draw(path: Path, title: str, scenario, run, truth) -> None:
    """Draw the world and the maps at half time and at the end."""
    outlines = floor_plan.outlines(load_world(str(scenario.world_path)))
    views = slam_files.map_views(run)
    true_xy = truth.poses_in_map[:, :2]
    height_m = scenario.flight_height_m
    png = slam_figures.world_and_maps_png(title, outlines, height_m, true_xy, views)
    write_atomically(path, png)


def medians(several: Sequence[dict]) -> dict:
    """Return each figure's median over the seeds, and the greatest ATE."""
    middle = {key: _median([figures[key] for figures in several]) for key in several[0]}
    return {**middle, "ate_rmse_worst_m": max(f["ate_rmse_m"] for f in several), "seeds": len(several)}


def _median(values: Sequence) -> float | None:
    finite = [value for value in values if value is not None and np.isfinite(value)]
    return float(np.median(finite)) if finite else None


def as_markdown(world: str, lidars: Sequence[str], maps: dict, seeds: int) -> str:
    """Return a world's table: a row for each lidar, without and with loop closure."""
    header = (
        "lidar",
        "range [m]",
        "loops closed",
        *(heading for heading, _ in FIGURES.values()),
        "ours",
        "thesis",
    )
    rows = []
    for lidar, closure in itertools.product(lidars, (False, True)):
        figures = maps[world, lidar, closure]
        rows.append(
            (
                lidar,
                MAPS["range_m"][lidar],
                "yes" if closure else "no",
                *(_number(figures[key], digits) for key, (_, digits) in FIGURES.items()),
                verdict(figures),
                MAPS.get(world, {}).get(lidar, "-"),
            )
        )
    return f"# {world}\n\nMedians over {seeds} seeds.\n\n{table(header, rows)}\n"


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    main()
