"""Exploration without GNSS and without ROS by a Puck: the hold, the tank, rooms, bug traps.

Odometry by clouds, the map of voxels, planner and explorer, flown with dynamics. A flight depends on its
place and its seed alone. Times count from the first setpoint after the hover. `time_99_s` is when 99 % of the
volume was known that the map knows at the end. The judge works on the world's surfaces at 0.05 m:
`known_share` is of all that the UAV with its clearance can fill, `mapped_share` of the surface that its lidar
can see from there. `false_ends`: flights that ended as explored, and less than 99 % was known.

Keys: explore.ROW.puck.{flights, ended, contacts, landed_home, false_ends, left_m2}, and {time_99_s, end_s,
home_s, known_share, mapped_share, views, decision_ms, decision_max_ms}.{median, worst}.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.explore_rows.places import ROWS, Place, place_of
from benchmarks.shared.results import Results
from benchmarks.shared.trials import run_crossed, trial_options
from gridslam.evaluation.volume.lidars import VIEWS
from inspection_tools import PositionControllerParameters
from inspection_tools.exploration import End, ExplorationParameters, Why
from master_thesis.exploring.flight import ExploringFlight
from master_thesis.exploring.judge import judge_map
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase, PhaseLimits
from master_thesis.flight.parameters import ClosedLoopParameters
from simulation_tools.geometry import Pose
from simulation_tools.simulation import SimulationParameters

SEEDS, BRIEF_SEEDS = (11, 12, 13), (11,)
"""The exploration was developed in flights with the seed 1."""
TIME_S, BRIEF_TIME_S = 400.0, 15.0
"""Of simulation; then the UAV flies home, explored or not."""
HOME_M, HOVER_M = 1.0, 1.5
KNOWN_MIN = 0.99
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
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=None, help="the places; default: all")
    parser.add_argument(
        "--seeds", nargs="+", type=int, default=None, help="of the flights, and of drawn places"
    )
    given = parser.parse_args(arguments)
    with Results("explore", given.results, vars(given)) as results:
        _fly_rows(given, results)


def _fly_rows(given: argparse.Namespace, results: Results) -> None:
    rows = given.rows or (ROWS[:1] if given.brief else ROWS)
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    time_s = BRIEF_TIME_S if given.brief else TIME_S
    found = run_crossed("explore", fly, given, row=rows, seed=seeds, time_s=[time_s])
    for row in rows:
        numbers = summary([found[row, seed, time_s] for seed in seeds])
        results.add(f"explore.{row}.puck", numbers)
        print(row, json.dumps(numbers))


def fly(row: str, seed: int, time_s: float) -> dict:
    """Explore a place once; return the metrics, times in s."""
    place = place_of(row, seed)
    with tempfile.TemporaryDirectory() as folder:
        return _fly(place, place.written_to(Path(folder)), seed, time_s)


def _fly(place: Place, world: Path, seed: int, time_s: float) -> dict:
    simulation = SimulationParameters(
        str(world),
        model=place.uav.model,
        lidar=place.uav.lidar,
        sensors=("range_finder", "range_finder_up"),
        gnss=False,
        seed=seed,
        spawn_pose=Pose(place.start_m),
    )
    parameters = ClosedLoopParameters(
        simulation,
        goal_xyz_m=None,
        algorithm=place.uav.algorithm,
        cepa=place.uav.cepa,
        range_finders=True,
        pose_source="odometry",
        limits=PhaseLimits(flight_timeout_s=2.0 * TIME_S),
        position_controller=PositionControllerParameters(max_speed=place.explorer.speed),
    )
    with ClosedLoop(parameters) as loop:
        asked = ExplorationParameters(time_max=time_s, arrived=place.arrived_m, steep=True)
        flight = ExploringFlight(loop, place.planner, place.explorer, place.volume, asked)
        told = flight.run()
        outcome, truth = loop.outcome, loop.log.truth.array("x_m", "y_m", "z_m")
    began_s = outcome.times_s[Phase.FLYING]
    rng, hover_m = np.random.default_rng(seed), np.array((*place.start_m[:2], HOVER_M))
    view = replace(VIEWS["puck"], range_max_m=place.volume.max_range_m)
    judged = judge_map(flight.volume.shown, world, place.box_m, hover_m, place.clearance_m, view, rng)
    at_home = math.dist(truth[-1, :2], place.start_m[:2]) < HOME_M
    return {
        "ended": told.end.value if told.end else "",
        "contact": outcome.collision,
        "landed_home": outcome.landed and at_home,
        "time_99_s": told.time_of(0.99) - began_s,
        "end_s": told.ended_s - began_s,
        "home_s": outcome.times_s.get(Phase.HOVERING, math.nan) - began_s,
        "known_share": judged.known_share,
        "mapped_share": judged.mapped_share,
        "reachable_m3": judged.reachable_m3,
        "visible_m2": judged.visible_m2,
        "views": told.views,
        "decision_ms": float(1e3 * np.median(told.cpu_s)),
        "decision_max_ms": float(1e3 * max(told.cpu_s)),
        "left": {why.value: told.left_m2(why) for why in Why},
    }


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
