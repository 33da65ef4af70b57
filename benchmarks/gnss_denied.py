"""Experiments 3 and 4 without GNSS: the UAV flies by its lidar, IMU and range finder, with every lidar.

The whole chain without ROS: the flight controller's stand-in with its Kalman filter, odometry from the lidar,
SLAM with loop closure beside it, and the mission in `map`, followed as slowly as the nodes do. A flight
depends on its seed alone. The table has medians and the worst of the seeds.

`landed_off_m` is the distance from the start. In the room the mission ends after a time. The UAV then flies
back to its start.

Keys: gnss_denied.WORLD.LIDAR.{flown, contacts, landed_off_m, ate_m, odometry_ate_m, path_p95_m, height_p95_m,
cpu_ms}, each but the first two with .median and .worst. Further rows (`--rows`):
gnss_denied.killed.PART.{briefly, for_good}: parts of the chain die in flight.
gnss_denied.stops.{LIDAR, urg_after_lost_scan}.{stops, median_s, worst_s, ...}: it loses its pose and stops.
gnss_denied.boxes: boxes of 0.5 m lie under the way.
gnss_denied.landings: Experiment 1, and where it lands.
gnss_denied.restart.{closure, restart}: SLAM closes the loop, or begins a new map, in flight.
gnss_denied.climbs.WORLD.{puck, m8, ust}: climbs in `hold_3d` and `ballast_tank` by odometry, SLAM beside;
--beside: with other libraries on the same clouds.
"""

from __future__ import annotations

import argparse
import itertools
import json
from types import ModuleType
from typing import Sequence

import numpy as np

from benchmarks.gnss_rows import boxes, climbs, corrections, killed, landings, stops
from benchmarks.gnss_rows.beside import NAMES
from benchmarks.gnss_rows.climb_places import CLIMBS
from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_all, run_crossed, trial_options
from flights.flight.without_gnss import PARTS
from flights.trials.trial import Trial
from flights.trials.workers import count
from flights.worlds.scenario import LIDARS
from master_thesis.experiments_3_4.without_gnss.flight import fly_without_gnss, parameters_without_gnss

WORLDS = ("room", "hold")
ROWS = ("missions", "killed", "stops", "boxes", "landings", "restart", "climbs")
SEEDS = (1, 2, 3, 4, 5)
SHORT_SEEDS, BRIEF_SEEDS = (1, 2, 3), (1,)
BRIEF_CLIMB_MIN = 0.5
KILLS, BRIEF_KILLS = 50, 2
STOP_SEEDS = (5,)
"""The stop's constants were chosen in flights with the seeds 1 to 3."""
CLIMBS_LIDARS = {"hold_3d": ("puck", "m8", "ust"), "ballast_tank": ("puck",)}
CLIMBS_SEEDS = tuple(range(11, 21))
"""The cloud odometry was developed in flights with the seeds 1 and 2."""
METRICS = {
    "landed_off_m": "landed off the start [m]",
    "ate_m": "ATE of the pose flown by [m]",
    "odometry_ate_m": "ATE of odometry [m]",
    "path_p95_m": "off the path, 95 % [m]",
    "height_p95_m": "height, 95 % [m]",
    "cpu_ms": "odometry's CPU/scan [ms]",
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--rows", nargs="+", default=ROWS, choices=ROWS)
    parser.add_argument("--kills", type=count, default=None, help="of each part, for a while and for good")
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument("--climb-minutes", type=float, default=10.0, help="length of a flight with climbs")
    parser.add_argument("--climb-worlds", nargs="+", default=tuple(CLIMBS), choices=tuple(CLIMBS))
    parser.add_argument("--beside", nargs="+", default=(), choices=NAMES, help="libraries beside the climbs")
    parser.add_argument("--worlds", nargs="+", default=WORLDS, choices=WORLDS)
    parser.add_argument("--lidars", nargs="+", default=LIDARS, choices=LIDARS)
    given = parser.parse_args(arguments)
    with Results("gnss_denied", given.results, vars(given)) as results:
        if "missions" in given.rows:
            _fly_missions(given, results)
        if "killed" in given.rows:
            _kill(given, results)
        if "stops" in given.rows:
            _stop(given, results)
        if "boxes" in given.rows:
            _fly_seeds("boxes", boxes, {}, given, results)
        if "landings" in given.rows:
            _fly_seeds("landings", landings, {}, given, results)
        if "restart" in given.rows:
            for kind in ("closure", "restart"):
                _fly_seeds(f"restart.{kind}", corrections, {"kind": kind}, given, results)
        if "climbs" in given.rows:
            _climb(given, results)


def _fly_missions(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    found = run_crossed("gnss_denied", fly, given, world=given.worlds, lidar=given.lidars, seed=seeds)
    rows = []
    for world, lidar in itertools.product(given.worlds, given.lidars):
        numbers = summary([found[world, lidar, seed] for seed in seeds])
        results.add(f"gnss_denied.{world}.{lidar}", numbers)
        rows.append((world, lidar, *_cells(numbers, len(seeds))))
    print(table(("world", "lidar", "flown", "contacts", *METRICS.values()), rows))


def _kill(given: argparse.Namespace, results: Results) -> None:
    kills = given.kills or (BRIEF_KILLS if given.brief else KILLS)
    rounds, seeds = killed.flights_for(kills), range(1, kills + 1)
    trials = [Trial(f"briefly {seed}", killed.briefly, {"seed": seed}) for seed in range(1, rounds + 1)]
    trials += [
        Trial(f"{part} {seed}", killed.for_good, {"part": part, "seed": seed})
        for seed in seeds
        for part in PARTS
    ]
    found = run_all("gnss_denied_killed", trials, given)
    for number, part in enumerate(PARTS):
        numbers = {
            "briefly": killed.summary_briefly(part, found[:rounds]),
            "for_good": killed.summary_for_good(part, found[rounds + number :: len(PARTS)]),
        }
        results.add(f"gnss_denied.killed.{part}", numbers)
        print(part, json.dumps(numbers))


def _stop(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or STOP_SEEDS
    cases = {lidar: {"lidar": lidar} for lidar in given.lidars}
    if "urg" in given.lidars:
        cases["urg_after_lost_scan"] = {"lidar": "urg", "after_lost_scan": True}
    trials = [
        Trial(f"{name} {seed}", stops.fly, {**case, "seed": seed})
        for name, case in cases.items()
        for seed in seeds
    ]
    found = run_all("gnss_denied_stops", trials, given)
    for number, name in enumerate(cases):
        rounds = found[number * len(seeds) : (number + 1) * len(seeds)]
        numbers = stops.summary([stop for one in rounds for stop in one])
        results.add(f"gnss_denied.stops.{name}", numbers)
        print(name, json.dumps(numbers))


def _climb(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else CLIMBS_SEEDS)
    minutes = BRIEF_CLIMB_MIN if given.brief else given.climb_minutes
    cases = {
        f"{world}.{lidar}": {"world": world, "lidar": lidar}
        for world in given.climb_worlds
        for lidar in CLIMBS_LIDARS[world]
        if lidar in given.lidars
    }
    rest = {"minutes": minutes, "beside": list(given.beside)}
    trials = [
        Trial(f"{name} {seed}", climbs.fly, {**case, **rest, "seed": seed})
        for name, case in cases.items()
        for seed in seeds
    ]
    found = run_all("gnss_denied_climbs", trials, given)
    for number, name in enumerate(cases):
        numbers = climbs.summary(found[number * len(seeds) : (number + 1) * len(seeds)])
        results.add(f"gnss_denied.climbs.{name}", numbers)
        print(name, json.dumps(numbers))


def _fly_seeds(
    key: str, row: ModuleType, arguments: dict, given: argparse.Namespace, results: Results
) -> None:
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SHORT_SEEDS)
    trials = [Trial(f"{key} {seed}", row.fly, {**arguments, "seed": seed}) for seed in seeds]
    numbers = row.summary(run_all(f"gnss_denied_{key}", trials, given))
    results.add(f"gnss_denied.{key}", numbers)
    print(key, json.dumps(numbers))


def fly(world: str, lidar: str, seed: int) -> dict:
    """Fly once and return the metrics."""
    return fly_without_gnss(world, seed, parameters_without_gnss(world, lidar, seed)).metrics()


def summary(trials: Sequence[dict]) -> dict:
    """Return how many flights were flown and had a contact, and median and worst of each metric."""
    return {
        "flown": sum(trial["flown"] for trial in trials),
        "contacts": sum(trial["contact"] for trial in trials),
        "seeds": len(trials),
        **{key: _spread([trial[key] for trial in trials]) for key in METRICS},
    }


def _spread(values: Sequence[float | None]) -> dict[str, float] | None:
    known = [value for value in values if value is not None]
    return {"median": float(np.median(known)), "worst": max(known)} if known else None


def _cells(numbers: dict, seeds: int) -> tuple:
    spread = ("{median:.3f} ({worst:.3f})".format(**numbers[key]) if numbers[key] else "-" for key in METRICS)
    return f"{numbers['flown']} of {seeds}", numbers["contacts"], *spread


if __name__ == "__main__":
    main()
