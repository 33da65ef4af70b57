"""Experiments 3 and 4 over seeds: the errors of the maps of all six lidars (thesis, 8.2).

Each flight is flown once in the ROS-free closed loop and recorded; SLAM then runs on the recording, on one
thread, without and with loop closure. The odometry drifts as by default, and a flight's seed is that of every
random stream, SLAM's particles included. The table has medians over the seeds.

Keys: slam.room.LIDAR and slam.hold.LIDAR; and results/slam_experiments.md, slam_experiments/*.png of the
first seed.
"""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path
from typing import Sequence

from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_all, trial_options
from flights.files import replace_file
from flights.mapping.mapping_flight import SCENARIOS, parameters_of
from flights.mapping.slam_metrics import verdict
from flights.results.picture_files import png
from flights.trials.trial import Trial
from flights.worlds.scenario import LIDARS
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import MappedFlight, medians
from master_thesis.report.thesis import LIDARS as THESIS_LIDARS
from master_thesis.report.thesis import MAPS

WORLDS = ("room", "hold")
SEEDS = (1, 2, 3, 4, 5)
BRIEF_SEEDS = (1,)
METRICS = {
    "ate_rmse_m": ("ATE [m]", 3),
    "ate_online_rmse_m": ("online [m]", 3),
    "map_error_mean_m": ("map error [m]", 3),
    "map_error_p95_m": ("95 % [m]", 3),
    "wall_seen_share": ("wall seen", 2),
    "closures": ("loops", 0),
    "cpu_ms": ("CPU/scan [ms]", 1),
}
"""The metrics of a map: heading and decimals."""
_NAMES = {False: "without", True: "with"}
"""Loop closure."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, map, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument("--worlds", nargs="+", default=WORLDS, choices=tuple(SCENARIOS))
    parser.add_argument("--lidars", nargs="+", default=LIDARS, choices=LIDARS)
    given = parser.parse_args(arguments)
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    pictures = given.results / "slam_experiments"
    pictures.mkdir(parents=True, exist_ok=True)
    with Results("slam_experiments", given.results, vars(given)) as results:
        maps = map_all(seeds, pictures, given)
        text = "\n".join(as_markdown(world, given.lidars, maps, len(seeds)) for world in given.worlds)
        for world, lidar in itertools.product(given.worlds, given.lidars):
            closing, open_ended = (maps[world, lidar, closure] for closure in (True, False))
            results.add(f"slam.{world}.{lidar}", {**closing, "without_loop_closure": open_ended})
        replace_file(given.results / "slam_experiments.md", text)
        print(f"\n{text}")


def map_all(seeds: Sequence[int], pictures: Path, given: argparse.Namespace) -> dict:
    """Return the metrics' medians by (world, lidar, loop closure)."""
    flights = list(itertools.product(given.worlds, given.lidars, seeds))
    keys = ("world", "lidar", "seed")
    trials = [
        Trial(
            " ".join(map(str, flight)),
            fly_and_map,
            {**dict(zip(keys, flight)), "pictures": pictures if flight[2] == seeds[0] else None},
        )
        for flight in flights
    ]
    by_case: dict = {}
    for (world, lidar, _), maps in zip(flights, run_all("slam_experiments", trials, given)):
        for closure in (False, True):
            by_case.setdefault((world, lidar, closure), []).append(maps[_NAMES[closure]])
    return {case: medians(several) for case, several in by_case.items()}


def fly_and_map(world: str, lidar: str, seed: int, pictures: Path | None = None) -> dict[str, dict]:
    """Fly once; return the map's metrics without and with loop closure. pictures: folder to draw into."""
    warm_up()
    flight = MappedFlight.fly(world, lidar, seed, parameters_of(world, lidar, seed))
    found = {}
    for closure, name in _NAMES.items():
        run = flight.map(seed, loop_closure=closure)
        found[name] = flight.metrics(run)
        if pictures:
            title = f"{flight.recording.name}, {name} loop closure"
            path = pictures / f"{world}_{lidar}{'_closed' if closure else ''}.png"
            replace_file(path, png(flight.picture(run, title)))
    return found


def as_markdown(world: str, lidars: Sequence[str], maps: dict, seeds: int) -> str:
    """Return a world's table: a row for each lidar, without and with loop closure."""
    header = (
        "lidar",
        "range [m]",
        "loops closed",
        *(heading for heading, _ in METRICS.values()),
        "ours",
        "thesis",
    )
    rows = []
    for lidar, closure in itertools.product(lidars, (False, True)):
        metrics = maps[world, lidar, closure]
        rows.append(
            (
                lidar,
                THESIS_LIDARS[lidar].range_m,
                "yes" if closure else "no",
                *(_number(metrics[key], digits) for key, (_, digits) in METRICS.items()),
                verdict(metrics),
                MAPS[world][lidar].words if world in MAPS else "-",
            )
        )
    return f"# {world}\n\nMedians over {seeds} seeds.\n\n{table(header, rows)}\n"


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    main()
