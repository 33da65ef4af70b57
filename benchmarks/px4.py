"""The PX4 stand-in beside real PX4: every manoeuvre of the reference, flown on the same body.

Flown by `Simulation` (PyBullet, the model `reference_quad`, an empty world, noise like that of PX4's
estimates), through the flight controller's setpoints; the reference was recorded on PX4 SITL. Several flights
with noise of their own, and the median of each figure. It fails when a figure is more than 10 % off PX4's.

--estimator ekf2 flies by the stand-in's Kalman filter instead; its keys begin with px4_ekf2.

Keys: px4.MANOEUVRE.{ours, px4}.{rise_s, delay_s, overshoot_percent, settling_s, peak_tilt_deg, peak_rate},
px4.MANOEUVRE.rms_percent, px4.takeoff.{ours, px4}, px4.hover.{ours, px4}; and results/px4.png.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, replace
from functools import partial
from typing import Mapping, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared.anchors import HEADING, Anchor, sources
from benchmarks.shared.results import Results, options, table
from benchmarks.simulator.px4_picture import png
from benchmarks.simulator.reference_quad import PACKAGE, standing, stepped
from benchmarks.simulator.step_response import (
    COLUMNS,
    MANOEUVRES,
    TAKEOFF,
    Manoeuvre,
    Pilot,
    metrics,
    read_reference,
    rms_percent,
)
from flights.files import replace_file
from simulation_tools.px4.estimation.choice import ESTIMATORS, STEADY
from simulation_tools.simulation import Simulation

DATA = PACKAGE / "test/px4/data"
RECORDED = Anchor("PX4", "PX4 SITL, master of July 2021, on the same body; recorded once (px4_steps.csv.gz)")
TAKEOFF_HEIGHT_M = 2.0
HOVER, HOVER_S = "hover", 120.0
TOLERANCE = 0.1


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print and write; 1 when a figure is out of bounds."""
    parser = options(__doc__)
    parser.add_argument("--seed", type=int, default=1, help="seed of the first flight's noise")
    parser.add_argument("--flights", type=int, default=5, help="number of flights")
    parser.add_argument("--estimator", choices=ESTIMATORS, default=STEADY, help="of the stand-in")
    given = parser.parse_args(arguments)
    prefix = "px4" if given.estimator == STEADY else f"px4_{given.estimator}"
    reference = read_reference(DATA / "px4_steps.csv.gz")
    published = json.loads((DATA / "px4_figures.json").read_text(encoding="utf-8"))
    with Results(prefix, given.results, vars(given)) as results:
        seeds = range(given.seed, given.seed + max(given.flights, 1))
        flights = [fly(seed, given.estimator) for seed in tqdm(seeds, "flights", unit="")]
        steps = {
            m.name: compare(m, [flown[m.name] for flown in flights], reference.get(m.name), published)
            for m in MANOEUVRES
        }
        takeoffs = [takeoff_metrics(flown[TAKEOFF]) for flown in flights]
        takeoff = {"ours": medians(takeoffs), "px4": takeoff_metrics(reference[TAKEOFF])}
        hovering = {"ours": hover_metrics([flown[HOVER] for flown in flights]), "px4": published["hover_cm"]}
        for name, values in steps.items():
            results.add(f"{prefix}.{name}", values)
        results.add(f"{prefix}.takeoff", takeoff)
        results.add(f"{prefix}.hover", hovering)
        replace_file(given.results / f"{prefix}.png", png(flights[0], reference))
        print(f"\n{steps_table(steps)}\n\n{others_table(takeoff, hovering)}\n\n{sources([RECORDED])}")
        complaints = out_of_bounds(steps, takeoff, hovering, published)
        for complaint in complaints:
            print(f"Out of bounds: {complaint}", file=sys.stderr)
    return 1 if complaints else 0


def fly(seed: int, estimator: str) -> dict[str, np.ndarray]:
    """Return the rows of hover, of every manoeuvre and of a take-off, by name."""
    pilot = new_pilot(seed, estimator)
    pilot.take_off(3.0, 18.0)
    flown = {HOVER: pilot.fly(HOVER_S), **{m.name: pilot.manoeuvre(m) for m in MANOEUVRES}}
    return {**flown, TAKEOFF: new_pilot(seed, estimator).take_off(TAKEOFF_HEIGHT_M, 12.0)}


def new_pilot(seed: int, estimator: str) -> Pilot:
    """Return a pilot of the reference quad, which stands on the ground."""
    simulation = Simulation(replace(standing(seed), estimator=estimator))
    assert simulation.px4 is not None
    return Pilot(simulation.px4, partial(stepped, simulation))


def medians(flights: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the median of each metric over the flights."""
    return {name: float(np.median([values[name] for values in flights])) for name in flights[0]}


def compare(
    manoeuvre: Manoeuvre, flown: Sequence[np.ndarray], reference: np.ndarray | None, published: dict
) -> dict:
    """Return the metrics of a manoeuvre, ours and PX4's: of its series or, without one, as published."""
    found = {"ours": medians([asdict(metrics(manoeuvre, rows)) for rows in flown])}
    if reference is None:
        row = next(row for row in published["steps"] if manoeuvre.name in row["manoeuvres"])
        return {**found, "px4": {name: row[name] for name in found["ours"] if name in row}}
    rms = float(np.median([rms_percent(manoeuvre, rows, reference) for rows in flown]))
    return {**found, "px4": asdict(metrics(manoeuvre, reference)), "rms_percent": rms}


def out_of_bounds(steps: dict, takeoff: dict, hover: dict, published: dict) -> list[str]:
    """Return a sentence for each value that differs from the published one by more than 10 %.

    A published row of two manoeuvres is their mean. An overshoot of zero may differ by one point.
    """
    compared = [
        (
            " and ".join(row["manoeuvres"]),
            figure,
            [steps[name]["ours"][figure] for name in row["manoeuvres"]],
            px4,
        )
        for row in published["steps"]
        for figure, px4 in row.items()
        if figure != "manoeuvres"
    ]
    compared += [
        ("take-off", name, [takeoff["ours"][name]], px4) for name, px4 in published["takeoff"].items()
    ]
    compared += [("hover", name, [hover["ours"][name]], px4) for name, px4 in hover["px4"].items()]
    return [
        f"{where}: {figure} is {np.mean(ours):.3g}, PX4's {px4:g}"
        for where, figure, ours, px4 in compared
        if not abs(np.mean(ours) - px4) <= (TOLERANCE * abs(px4) if px4 else 1.0)
    ]


def takeoff_metrics(rows: np.ndarray) -> dict:
    """Return the reference's metrics of a take-off, with heights over the place of take-off."""
    t, height = rows[:, 0], rows[0, COLUMNS.index("down_m")] - rows[:, COLUMNS.index("down_m")]
    return {
        "at_5_cm_s": t[np.argmax(height > 0.05)],
        "at_1_8_m_s": t[np.argmax(height > 1.8)],
        "peak_m_s": -rows[:, COLUMNS.index("v_down")].min(),
        "overshoot_percent": 100.0 * max(height.max() / TAKEOFF_HEIGHT_M - 1.0, 0.0),
    }


def hover_metrics(flights: Sequence[np.ndarray]) -> dict:
    """Return the standard deviations in hover, cm: over all flights, each about its own mean."""
    names = {"x": "north_m", "y": "east_m", "z": "down_m"}
    return {
        axis: 100.0 * float(np.sqrt(np.mean([rows[:, COLUMNS.index(name)].var() for rows in flights])))
        for axis, name in names.items()
    }


def steps_table(steps: dict) -> str:
    """Return the step responses as a table, each cell "ours / PX4"."""
    columns = {
        "rise [s]": ("rise_s", 2),
        "50 % [s]": ("delay_s", 2),
        "overshoot [%]": ("overshoot_percent", 1),
        "settling [s]": ("settling_s", 1),
        "peak tilt [deg]": ("peak_tilt_deg", 1),
    }
    rows = []
    for name, values in steps.items():
        cells = (_pair(values, key, digits) for key, digits in columns.values())
        rms = f"{values['rms_percent']:.1f}" if "rms_percent" in values else ""
        rows.append((name.replace("_", " "), *cells, rms))
    return table((f"step: ours / PX4 ({HEADING})", *columns, "RMS [% of step]"), rows)


def others_table(takeoff: dict, hover: dict) -> str:
    """Return take-off and hover as a table."""
    rows = [
        ("take-off: 5 cm after arming [s]", takeoff, "at_5_cm_s", 2),
        ("take-off: 1.8 of 2 m after arming [s]", takeoff, "at_1_8_m_s", 2),
        ("take-off: greatest speed [m/s]", takeoff, "peak_m_s", 2),
        ("take-off: overshoot [%]", takeoff, "overshoot_percent", 1),
        *((f"hover: standard deviation of {axis} [cm]", hover, axis, 2) for axis in hover["px4"]),
    ]
    return table(("", f"ours / PX4 ({HEADING})"), [(label, _pair(*rest)) for label, *rest in rows])


def _pair(values: dict, key: str, digits: int) -> str:
    theirs = values["px4"].get(key)
    ours = f"{values['ours'][key]:.{digits}f}"
    return f"{ours} / {theirs:.{digits}f}" if theirs is not None else f"{ours} / -"


if __name__ == "__main__":
    sys.exit(main())
