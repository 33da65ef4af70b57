"""The PX4 stand-in beside real PX4: every manoeuvre of the reference, flown on the same body.

Flown by `Simulation` (PyBullet, the model `reference_quad`, an empty world, noise like that of PX4's
estimates), through the flight controller's setpoints; the reference was recorded on PX4 SITL.

Figures: px4.MANOEUVRE.{ours, px4}.{rise_s, delay_s, overshoot_percent, settling_s, peak_tilt_deg},
px4.MANOEUVRE.rms_percent, px4.takeoff.{ours, px4}, px4.hover.{ours, px4}; and results/px4.png.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks._anchors import HEADING, Anchor, sources
from benchmarks._px4_figure import png
from benchmarks._report import ROOT, Report, options, table, write_atomically
from simulation_tools.geometry import Pose, quaternion_from_rpy, rotate_inverse
from simulation_tools.px4.autopilot import VehicleState
from simulation_tools.px4.step_response import (
    COLUMNS,
    MANOEUVRES,
    TAKEOFF,
    Manoeuvre,
    Pilot,
    figures,
    read_reference,
    rms_percent,
)
from simulation_tools.simulation import Simulation, SimulationParameters

PACKAGE = ROOT / "src/simulation_tools"
REFERENCE = PACKAGE / "test/px4/data/px4_steps.csv.gz"
UNRECORDED = {
    "position_x_+1": {"rise_s": 1.27, "overshoot_percent": 15.0, "settling_s": 4.0, "peak_tilt_deg": 8.0}
}
"""Figures of manoeuvres whose time series the reference does not hold."""
HOVER_CM = {"x": 1.4, "y": 1.4, "z": 0.3}
"""PX4's standard deviations in hover."""
RECORDED = Anchor("PX4", "PX4 SITL, master of July 2021, on the same body; recorded once (px4_steps.csv.gz)")
TAKEOFF_HEIGHT_M = 2.0
NORTH_RAD = 0.5 * np.pi


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = options(__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the estimate's noise")
    given = parser.parse_args(arguments)
    reference = read_reference(REFERENCE)
    with Report("px4", given.results, vars(given)) as report:
        pilot = new_pilot(given.seed)
        pilot.take_off(3.0, 18.0)
        hover = pilot.fly(30.0)
        flown = {m.name: pilot.manoeuvre(m) for m in tqdm(MANOEUVRES, "manoeuvres", unit="")}
        flown[TAKEOFF] = new_pilot(given.seed).take_off(TAKEOFF_HEIGHT_M, 12.0)
        steps = {m.name: compare(m, flown[m.name], reference.get(m.name)) for m in MANOEUVRES}
        takeoff = {"ours": takeoff_figures(flown[TAKEOFF]), "px4": takeoff_figures(reference[TAKEOFF])}
        hovering = {"ours": hover_figures(hover), "px4": HOVER_CM}
        for name, values in steps.items():
            report.add(f"px4.{name}", values)
        report.add("px4.takeoff", takeoff)
        report.add("px4.hover", hovering)
        write_atomically(given.results / "px4.png", png(flown, reference))
        print(f"\n{steps_table(steps)}\n\n{others_table(takeoff, hovering)}\n\n{sources([RECORDED])}")


def new_pilot(seed: int) -> Pilot:
    """Return a pilot of a reference quad that stands on the ground, its nose to the north."""
    simulation = Simulation(
        SimulationParameters(
            world=str(PACKAGE / "worlds/empty.world"),
            model="reference_quad",
            lidar=None,
            model_path=(PACKAGE / "models",),
            spawn_pose=Pose((0.0, 0.0, 0.0), quaternion_from_rpy(0.0, 0.0, NORTH_RAD)),
            seed=seed,
        )
    )

    def step() -> VehicleState:
        simulation.step()
        body = simulation.world.get_state(simulation.uav_name)
        rates = rotate_inverse(body.pose.orientation_xyzw, body.angular_velocity_rad_s)
        return VehicleState(simulation.time_us, body.pose, body.linear_velocity_m_s, rates)

    return Pilot(simulation.px4, step)


def compare(manoeuvre: Manoeuvre, rows: np.ndarray, reference: np.ndarray | None) -> dict:
    """Return the figures of a manoeuvre, ours and PX4's."""
    found = {"ours": asdict(figures(manoeuvre, rows))}
    if reference is None:
        return {**found, "px4": UNRECORDED[manoeuvre.name]}
    rms = rms_percent(manoeuvre, rows, reference)
    return {**found, "px4": asdict(figures(manoeuvre, reference)), "rms_percent": rms}


def takeoff_figures(rows: np.ndarray) -> dict:
    """Return what the reference says of a take-off; heights from where it stood."""
    t, height = rows[:, 0], rows[0, COLUMNS.index("down_m")] - rows[:, COLUMNS.index("down_m")]
    return {
        "at_5_cm_s": t[np.argmax(height > 0.05)],
        "at_1_8_m_s": t[np.argmax(height > 1.8)],
        "peak_m_s": -rows[:, COLUMNS.index("v_down")].min(),
        "overshoot_percent": 100.0 * max(height.max() / TAKEOFF_HEIGHT_M - 1.0, 0.0),
    }


def hover_figures(rows: np.ndarray) -> dict:
    """Return the standard deviations in hover, cm."""
    names = {"x": "north_m", "y": "east_m", "z": "down_m"}
    return {axis: 100.0 * rows[:, COLUMNS.index(name)].std() for axis, name in names.items()}


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
        *((f"hover: standard deviation of {axis} [cm]", hover, axis, 2) for axis in HOVER_CM),
    ]
    return table(("", f"ours / PX4 ({HEADING})"), [(label, _pair(*rest)) for label, *rest in rows])


def _pair(values: dict, key: str, digits: int) -> str:
    theirs = values["px4"].get(key)
    ours = f"{values['ours'][key]:.{digits}f}"
    return f"{ours} / {theirs:.{digits}f}" if theirs is not None else f"{ours} / -"


if __name__ == "__main__":
    main()
