"""ArduPilot Copter beside real PX4 and its stand-in, with and without GNSS: step responses, flights by CEPA.

All fly `iris` in the same simulator. The steps are those of `bench px4`, flown without ROS, in lockstep; the
table has medians over the seeds. Without GNSS, poses have 1 cm of noise, come 30 times a second and 50 ms
late. The flights are Experiment 1 in forest and hallway, and Experiment 4 in the hold, in the ROS graph. You
build ArduPilot yourself (simulation_tools/doc/ardupilot.md) and name its program by --ardupilot or
ARDUPILOT_COPTER; without it nothing is flown. --px4 names PX4's folder build/px4_sitl_default
(simulation_tools/doc/px4_sitl.md); without it real PX4 is left out.

Keys, PILOT being ardupilot, px4 or standin: ardupilot.hover_cm.{gnss, poses}.PILOT.{north, east, down},
ardupilot.steps.{gnss, poses}.PILOT.MANOEUVRE.{rise_s, delay_s, overshoot_percent, ...} and
ardupilot.flights.{forest, hallway, hold}.{gnss, poses}.PILOT.SEED.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.px4 import medians
from benchmarks.shared.results import Results, options, table
from benchmarks.simulator import ardupilot_flights
from benchmarks.simulator.ardupilot_pilots import Programs, fly_steps
from benchmarks.simulator.px4_process import PROGRAM
from benchmarks.simulator.step_response import COLUMNS, MANOEUVRES, metrics
from flights.errors import GraphError
from simulation_tools.ardupilot_sitl.program import ENVIRONMENT, check_program
from simulation_tools.errors import SimulationToolsError

PARTS = ("steps", "flights")
PLACES = ("gnss", "poses")
SHOWN = {
    "rise_s": ("rise [s]", 2),
    "delay_s": ("50 % [s]", 2),
    "overshoot_percent": ("overshoot [%]", 1),
    "settling_s": ("settling [s]", 1),
    "peak_tilt_deg": ("peak tilt [deg]", 0),
}
BY = {"gnss": "with GNSS", "poses": "by poses"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print and write; 1, with a sentence, when ArduPilot does not fly."""
    parser = options(__doc__)
    place = os.environ.get(ENVIRONMENT, "")
    parser.add_argument("--ardupilot", default=place, help=f"ArduPilot's arducopter (default ${ENVIRONMENT})")
    parser.add_argument("--px4", type=Path, help="PX4's folder build/px4_sitl_default")
    parser.add_argument("--instance", type=int, default=7, help="of real PX4 (its option -i)")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--real-time-factor", type=float, default=1.0, help="of the flights; 0: no limit")
    given = parser.parse_args(arguments)
    if not given.ardupilot.strip():
        print(f"Skipped: ArduPilot is not here; name its program by --ardupilot or {ENVIRONMENT}.")
        return 0
    if given.px4 is None:
        print("Real PX4 is left out; name its folder build/px4_sitl_default by --px4.")
    elif not (given.px4 / PROGRAM).is_file():
        parser.error(
            f"there is no {given.px4 / PROGRAM}; give PX4's folder build/px4_sitl_default with --px4"
        )
    try:
        check_program(given.ardupilot)
        with Results("ardupilot", given.results, {**vars(given), "px4": str(given.px4)}) as results:
            _measure(given, results)
    except (SimulationToolsError, GraphError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _measure(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds[:1] if given.brief else given.seeds
    programs = Programs(given.ardupilot, given.px4 and given.px4.resolve(), given.instance)
    if "steps" in given.parts:
        for place in PLACES:
            flown = {
                pilot: [
                    fly_steps(pilot, place == "gnss", seed, programs)
                    for seed in tqdm(seeds, f"{pilot}, {place}")
                ]
                for pilot in programs.pilots
            }
            for pilot, flights in flown.items():
                results.add(f"ardupilot.steps.{place}.{pilot}", step_metrics(flights))
                results.add(f"ardupilot.hover_cm.{place}.{pilot}", hover_cm(flights))
            print(f"\n{steps_table(place, {pilot: step_metrics(f) for pilot, f in flown.items()})}")
            print(f"\n{hover_table(place, {pilot: hover_cm(f) for pilot, f in flown.items()})}\n")
    if "flights" in given.parts:
        rows = []
        kinds = list(product(ardupilot_flights.FLIGHTS, PLACES, programs.pilots, seeds))
        for flight, place, pilot, seed in tqdm(kinds, "flights"):
            result = ardupilot_flights.fly(
                flight, pilot, programs, place == "gnss", seed, given.real_time_factor
            )
            results.add(f"ardupilot.flights.{flight}.{place}.{pilot}.{seed}", result)
            rows.append(ardupilot_flights.row(flight, BY[place], pilot, seed, result))
        print(f"\n{table(ardupilot_flights.HEADER, rows)}")


def step_metrics(flights: Sequence[dict[str, np.ndarray]]) -> dict[str, dict[str, float]]:
    """Return the medians of each manoeuvre's metrics over the flights."""
    return {m.name: medians([asdict(metrics(m, rows[m.name])) for rows in flights]) for m in MANOEUVRES}


def hover_cm(flights: Sequence[dict[str, np.ndarray]]) -> dict[str, float]:
    """Return the true position's standard deviation in a hover, each flight about its own mean."""
    spread = {}
    for axis in ("north", "east", "down"):
        column = COLUMNS.index(f"{axis}_m")
        variances = [rows["hover"][:, column].var() for rows in flights]
        spread[axis] = 100.0 * float(np.sqrt(np.mean(variances)))
    return spread


def steps_table(place: str, steps: dict[str, dict[str, dict[str, float]]]) -> str:
    """Return the step responses, a cell for each pilot in turn."""
    rows = []
    for manoeuvre in MANOEUVRES:
        found = [steps[pilot][manoeuvre.name] for pilot in steps]
        cells = (" / ".join(f"{f[key]:.{digits}f}" for f in found) for key, (_, digits) in SHOWN.items())
        rows.append((manoeuvre.name.replace("_", " "), *cells))
    heading = f"{BY[place]}: {' / '.join(steps)}"
    return table((heading, *(name for name, _ in SHOWN.values())), rows)


def hover_table(place: str, spreads: dict[str, dict[str, Any]]) -> str:
    """Return the spread of a hover of a minute."""
    rows = [(pilot, *(f"{cm:.2f}" for cm in spread.values())) for pilot, spread in spreads.items()]
    return table((f"hover {BY[place]}: spread [cm]", *next(iter(spreads.values()))), rows)


if __name__ == "__main__":
    sys.exit(main())
