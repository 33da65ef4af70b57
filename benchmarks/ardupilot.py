"""ArduPilot Copter beside the PX4 stand-in, with and without GNSS: step responses, flights by CEPA.

Both fly `iris` in the same simulator. The steps are those of `bench px4`, flown without ROS, in lockstep; the
table has medians over the seeds. Without GNSS, poses have 1 cm of noise, come 30 times a second and 50 ms
late. The flights are Experiment 1 in forest and hallway, and Experiment 4 in the hold, in the ROS graph. You
build ArduPilot yourself (simulation_tools/doc/ardupilot.md) and name its program by --ardupilot or
ARDUPILOT_COPTER; without it nothing is flown.

Keys: ardupilot.steps.{gnss, poses}.{ardupilot, standin}.MANOEUVRE.{rise_s, delay_s, overshoot_percent, ...},
ardupilot.hover_cm.{gnss, poses}.{ardupilot, standin}.{north, east, down} and
ardupilot.flights.{forest, hallway, hold}.{gnss, poses}.{ardupilot, standin}.SEED.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import asdict, replace
from functools import partial
from itertools import product
from typing import Any, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.px4 import medians
from benchmarks.px4_vision import PARAMETERS, Vision
from benchmarks.shared.results import Results, options, table
from benchmarks.simulator import ardupilot_flights
from benchmarks.simulator.real_ardupilot import RealArduPilot
from benchmarks.simulator.reference_quad import standing, stepped
from benchmarks.simulator.step_response import COLUMNS, MANOEUVRES, Pilot, metrics
from master_thesis.errors import GraphError
from simulation_tools.ardupilot_sitl.program import ENVIRONMENT, check_program
from simulation_tools.autopilot import VehicleState
from simulation_tools.errors import SimulationToolsError
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.simulation import Simulation, SimulationParameters

PARTS = ("steps", "flights")
PLACES = ("gnss", "poses")
PILOTS = ("ardupilot", "standin")
LATE = {"VISO_DELAY_MS": 50.0}
HEIGHT_M, TAKE_OFF_S, SETTLE_S, HOVER_S = 3.0, 120.0, 20.0, 60.0
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
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--real-time-factor", type=float, default=1.0, help="of the flights; 0: no limit")
    given = parser.parse_args(arguments)
    if not given.ardupilot.strip():
        print(f"Skipped: ArduPilot is not here; name its program by --ardupilot or {ENVIRONMENT}.")
        return 0
    try:
        check_program(given.ardupilot)
        with Results("ardupilot", given.results, vars(given)) as results:
            _measure(given, results)
    except (SimulationToolsError, GraphError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _measure(given: argparse.Namespace, results: Results) -> None:
    seeds = given.seeds[:1] if given.brief else given.seeds
    if "steps" in given.parts:
        for place in PLACES:
            flown = {
                pilot: [fly_steps(pilot, place, seed, given) for seed in tqdm(seeds, f"{pilot}, {place}")]
                for pilot in PILOTS
            }
            for pilot, flights in flown.items():
                results.add(f"ardupilot.steps.{place}.{pilot}", step_metrics(flights))
                results.add(f"ardupilot.hover_cm.{place}.{pilot}", hover_cm(flights))
            print(f"\n{steps_table(place, {pilot: step_metrics(f) for pilot, f in flown.items()})}")
            print(f"\n{hover_table(place, {pilot: hover_cm(f) for pilot, f in flown.items()})}\n")
    if "flights" in given.parts:
        rows = []
        kinds = list(product(ardupilot_flights.FLIGHTS, PLACES, PILOTS, seeds))
        for flight, place, pilot, seed in tqdm(kinds, "flights"):
            result = ardupilot_flights.fly(
                flight, pilot, given.ardupilot, place == "gnss", seed, given.real_time_factor
            )
            results.add(f"ardupilot.flights.{flight}.{place}.{pilot}.{seed}", result)
            rows.append(ardupilot_flights.row(flight, BY[place], pilot, seed, result))
        print(f"\n{table(ardupilot_flights.HEADER, rows)}")


def fly_steps(pilot: str, place: str, seed: int, given: argparse.Namespace) -> dict[str, np.ndarray]:
    """Return the rows of a hover and of every manoeuvre, by name."""
    fly = fly_ardupilot if pilot == "ardupilot" else fly_stand_in
    return fly(place, seed, given.ardupilot)


def fly_stand_in(place: str, seed: int, _path: str) -> dict[str, np.ndarray]:
    """Fly the stand-in once."""
    simulation = Simulation(_parameters(place, seed))
    px4, vision = simulation.px4, Vision(seed)
    assert px4 is not None

    def advance() -> VehicleState:
        state = stepped(simulation)
        if place == "poses":
            for position, attitude in vision.arrived(state):
                px4.offer_external_vision(ExternalVision(state.time_us, position, attitude=attitude))
        return state

    try:
        pilot = Pilot(px4, advance)
        pilot.fly(5.0)
        pilot.take_off(HEIGHT_M, SETTLE_S)
        return _fly(pilot)
    finally:
        simulation.close()


def fly_ardupilot(place: str, seed: int, path: str) -> dict[str, np.ndarray]:
    """Fly ArduPilot once."""
    vision = Vision(seed)
    if place == "gnss":
        ardupilot = RealArduPilot(path, seed, True, {}, lambda state: ())
    else:
        ardupilot = RealArduPilot(path, seed, False, LATE, vision.messages)
    simulation = Simulation(_parameters(place, seed), ardupilot)
    try:
        while not ardupilot.is_ready():
            time.sleep(0.02)
        pilot = Pilot(ardupilot, partial(stepped, simulation))
        ardupilot.take_off(HEIGHT_M, pilot, TAKE_OFF_S)
        return _fly(pilot)
    finally:
        simulation.close()


def _parameters(place: str, seed: int) -> SimulationParameters:
    parameters = replace(standing(seed), model="iris")
    return parameters if place == "gnss" else replace(parameters, gnss=False, px4_parameters=PARAMETERS)


def _fly(pilot: Pilot) -> dict[str, np.ndarray]:
    assert MANOEUVRES[0].before is not None
    pilot.stream(MANOEUVRES[0].before)
    pilot.fly(SETTLE_S)
    return {"hover": pilot.fly(HOVER_S), **{m.name: pilot.manoeuvre(m) for m in MANOEUVRES}}


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
    """Return the step responses, each cell "ArduPilot / stand-in"."""
    rows = []
    for manoeuvre in MANOEUVRES:
        found = [steps[pilot][manoeuvre.name] for pilot in PILOTS]
        cells = (" / ".join(f"{f[key]:.{digits}f}" for f in found) for key, (_, digits) in SHOWN.items())
        rows.append((manoeuvre.name.replace("_", " "), *cells))
    heading = f"{BY[place]}: ArduPilot / stand-in"
    return table((heading, *(name for name, _ in SHOWN.values())), rows)


def hover_table(place: str, spreads: dict[str, dict[str, Any]]) -> str:
    """Return the spread of a hover of a minute."""
    rows = [(pilot, *(f"{cm:.2f}" for cm in spread.values())) for pilot, spread in spreads.items()]
    return table((f"hover {BY[place]}: spread [cm]", *spreads[PILOTS[0]]), rows)


if __name__ == "__main__":
    sys.exit(main())
