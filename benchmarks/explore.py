"""Exploration without GNSS and without ROS: the tank by a QT64; hold, rooms and bug traps by a Puck.

Odometry by clouds, the map of voxels, planner and explorer, flown with dynamics. A flight depends on its
place and its seed alone. Times count from the first setpoint after the hover. `time_99_s` is when 99 % of the
volume was known that the map knows at the end. The judge works on the world's surfaces at 0.05 m:
`known_share` is of all that the UAV with its clearance can fill, `mapped_share` of the surface that its lidar
can see from there. `false_ends`: flights that ended as explored, and less than 99 % was known.
`--algorithm` flies the rows of flights with another algorithm of CEPA; their row is called ROW_ALGORITHM.

Keys: explore.ROW.LIDAR.{flights, ended, contacts, landed_home, false_ends, left_m2}, and {time_99_s, end_s,
home_s, known_share, mapped_share, views, decision_ms, decision_max_ms}.{median, worst}.

The row `batteries` is a campaign of missions whose battery is too small: see `explore_rows/batteries.py`.
Keys: explore.batteries.{missions, landings, came_home_for_energy, below_goal, least_charge, median_charge,
not_home, contacts}.

The row `one_mesh` is nine places of one mesh each, see `explore_rows/meshes.py`. It is flown if it is named.
The row `decisions` is the CPU time of decisions in a large hall, without a flight; see
`explore_rows/decisions.py`. Keys: explore.decisions.MILLIMETRES of a voxel.

The row `way_home` compares the reckoned way home with the time that it took, in 20 drawn places; see
`explore_rows/way_home.py`. It is flown if it is named. Keys: explore.way_home.{flights, longer_than_allowed,
least_to_spare_s, longer_than_factor, ways, landing_s, longest_m, contacts}, and of ratios flown to reckoned
{, up_, down_, energy_}{ratio_median, ratio_99, ratio_greatest}.

Keys of `one_mesh`: explore.one_mesh.PLACE, of the first seed; `explore_rows/one_mesh.py` has what they hold.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.explore_rows import batteries, decisions, one_mesh, way_home
from benchmarks.explore_rows.meshes import PLACES
from benchmarks.shared.results import Results
from benchmarks.shared.trials import run_crossed, trial_options
from exploration.next_view import End, Why
from flights.exploring.judged_flight import fly_and_judge
from flights.exploring.places import ROWS, place_of
from gridslam.cloud_odometry.warm_up import warm_up_cloud_odometry
from gridslam.volume.warm_up import warm_up_volume
from inspection.warm_up import warm_up

SEEDS, BRIEF_SEEDS = (11, 12, 13), (11,)
"""The exploration was developed in flights with the seed 1."""
MISSION_SEEDS = tuple(range(1201, 1401))
"""Of `batteries`, which was developed with seeds below 100, and after flights with 1001 to 1037."""
TIME_S, BRIEF_TIME_S = 400.0, 15.0
"""Of simulation; then the UAV flies home, explored or not."""
KNOWN_MIN = 0.99
ALGORITHMS = ("dynamic", "improved", "original")
"""The first is that of explore.launch."""
NAMED = (one_mesh.ROW, decisions.ROW, way_home.ROW)
"""Rows that are measured only if they are named."""
SHARES = ("known_share", "mapped_share")
METRICS = (
    "time_99_s",
    "end_s",
    "home_s",
    "known_share",
    "mapped_share",
    "views",
    "decision_ms",
    "decision_max_ms",
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = trial_options(__doc__ or "")
    rows = (*ROWS, batteries.ROW, *NAMED)
    parser.add_argument(
        "--rows", nargs="+", choices=rows, default=None, help="the places; default: all but one_mesh"
    )
    parser.add_argument(
        "--seeds", nargs="+", type=int, default=None, help="of the flights, and of drawn places"
    )
    parser.add_argument(
        "--places", nargs="+", choices=tuple(PLACES), default=tuple(PLACES), help="of one_mesh; default: all"
    )
    parser.add_argument(
        "--algorithm", choices=ALGORITHMS, default=ALGORITHMS[0], help="of CEPA; default: %(default)s"
    )
    given = parser.parse_args(arguments)
    rows = given.rows or (ROWS[:1] if given.brief else (*ROWS, batteries.ROW))
    with Results("explore", given.results, vars(given)) as results:
        _fly_rows(given, [row for row in rows if row in ROWS], results)
        if batteries.ROW in rows:
            _fly_missions(given, results)
        if one_mesh.ROW in rows:
            _fly_meshes(given, results)
        if way_home.ROW in rows:
            _fly_home(given, results)
        if decisions.ROW in rows:
            for voxel_m in decisions.VOXELS_M:
                numbers = decisions.measure(voxel_m)
                results.add(f"explore.{decisions.ROW}.{round(1e3 * voxel_m)}", numbers)
                print(voxel_m, json.dumps(numbers))


def _fly_rows(given: argparse.Namespace, rows: Sequence[str], results: Results) -> None:
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    time_s = BRIEF_TIME_S if given.brief else TIME_S
    algorithm = given.algorithm
    found = run_crossed("explore", fly, given, row=rows, seed=seeds, time_s=[time_s], algorithm=[algorithm])
    for row in rows:
        numbers = summary([found[row, seed, time_s, algorithm] for seed in seeds])
        called = row if algorithm == ALGORITHMS[0] else f"{row}_{algorithm}"
        results.add(f"explore.{called}.{place_of(row, seeds[0]).uav.lidar}", numbers)
        print(called, json.dumps(numbers))


def _fly_missions(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or MISSION_SEEDS
    found = run_crossed("explore_batteries", batteries.fly, given, seed=seeds)
    numbers = batteries.summary(list(found.values()))
    results.add(f"explore.{batteries.ROW}", numbers)
    print(batteries.ROW, json.dumps(numbers))


def _fly_meshes(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or BRIEF_SEEDS
    found = run_crossed("explore_one_mesh", fly_mesh, given, place=given.places, seed=seeds)
    for (place, seed), numbers in found.items():
        if seed == seeds[0]:
            results.add(f"explore.{one_mesh.ROW}.{place}", numbers)
        print(place, json.dumps(numbers))


def _fly_home(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or (way_home.SEEDS[:1] if given.brief else way_home.SEEDS)
    found = run_crossed("explore_way_home", fly_home, given, seed=seeds)
    for (seed,), numbers in found.items():
        print(seed, json.dumps(numbers))
    numbers = way_home.summary(list(found.values()))
    results.add(f"explore.{way_home.ROW}", numbers)
    print(way_home.ROW, json.dumps(numbers))


def fly_home(seed: int) -> dict:
    """Explore a drawn place for a while, and come home."""
    _warm_up()
    return way_home.fly(seed)


def fly_mesh(place: str, seed: int) -> dict:
    """Explore a place of one mesh once."""
    _warm_up()
    return one_mesh.fly(place, seed)


def fly(row: str, seed: int, time_s: float, algorithm: str = ALGORITHMS[0]) -> dict:
    """Explore a place once; return the metrics, times in s."""
    _warm_up()
    place = place_of(row, seed)
    place = replace(place, uav=replace(place.uav, algorithm=algorithm))
    with tempfile.TemporaryDirectory() as folder:
        flown = fly_and_judge(place, place.written_to(Path(folder)), seed, time_s, 2.0 * TIME_S)
    explored, judged = flown.explored, flown.judged
    return {
        "ended": explored.end.value if explored.end else "",
        "contact": flown.outcome.collision,
        "landed_home": flown.is_home,
        "time_99_s": explored.time_of(0.99) - flown.began_s,
        "end_s": explored.ended_s - flown.began_s,
        "home_s": flown.home_s,
        "known_share": judged.known_share,
        "mapped_share": judged.mapped_share,
        "reachable_m3": judged.reachable_m3,
        "visible_m2": judged.visible_m2,
        "views": explored.views,
        "decision_ms": float(1e3 * np.median(explored.cpu_s)),
        "decision_max_ms": float(1e3 * max(explored.cpu_s)),
        "left": {why.value: explored.left_m2(why) for why in Why},
    }


def _warm_up() -> None:
    warm_up_cloud_odometry()
    warm_up_volume()
    warm_up()  # otherwise the first decisions wait for their kernels


def summary(trials: Sequence[dict]) -> dict:
    """Return how the flights ended, and median and worst of each metric."""
    counts = {
        "ended": [trial["ended"] for trial in trials],
        "contacts": sum(trial["contact"] for trial in trials),
        "landed_home": sum(trial["landed_home"] for trial in trials),
        "false_ends": sum(
            trial["ended"] == End.EXPLORED.value and trial["known_share"] < KNOWN_MIN for trial in trials
        ),
        "left_m2": [trial["left"] for trial in trials],
    }
    values = {key: [trial[key] for trial in trials] for key in METRICS}
    spread = {
        key: {"median": float(np.median(all_)), "worst": min(all_) if key in SHARES else max(all_)}
        for key, all_ in values.items()
    }
    return {"flights": len(trials), **counts, **spread}


if __name__ == "__main__":
    main()
