"""Hover and a step of 2 m/s by external vision alone: the PX4 stand-in, and beside it real PX4.

Both fly the same body (`reference_quad`) in the same simulator, in lockstep. Poses have 1 cm of noise, come
30 times a second and 50 ms late, and give the height, too. Real PX4 has the sensors of `HilParameters`, the
stand-in its own. You build PX4 yourself (`make px4_sitl`); --px4 is its folder build/px4_sitl_default.
Without it only the stand-in flies.

The hover's spread is the standard deviation of the true position, cm. Beside it stands the uncertainty of the
mean over all flights, from the spread of windows of 30 s.

Keys: px4_vision.{ours, px4}.{hover_cm, hover_error_cm, windows, each_cm} and
px4_vision.{ours, px4}.step.{t10_s, t50_s, t90_s, overshoot_percent}.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections import deque
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Sequence

import numpy as np
from pymavlink.dialects.v20 import common
from tqdm import tqdm

from benchmarks.shared.results import Results, options, table
from benchmarks.simulator.real_px4 import RealPx4
from benchmarks.simulator.reference_quad import standing, stepped
from benchmarks.simulator.step_response import COLUMNS, MANOEUVRES, Pilot, quantity_of
from simulation_tools.autopilot import VehicleState
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Quaternion, Vector3, rpy_from_quaternion
from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.simulation import Simulation, SimulationParameters

PERIOD_US, LATE_US, NOISE_M = 33_333, 50_000, 0.01
PARAMETERS = {"EKF2_AID_MASK": 24, "EKF2_HGT_MODE": 3, "EKF2_EV_DELAY": 50.0}
WAIT_S, HEIGHT_M, SETTLE_S, WINDOW_S = 25.0, 2.0, 30.0, 30.0
_REFERENCE = next(manoeuvre for manoeuvre in MANOEUVRES if manoeuvre.name == "velocity_x_0_to_2")
STEP = replace(_REFERENCE, before_s=20.0, nearer_than_m=math.inf, seconds=8.0)
STEPS = 5
LEVELS = {"t10_s": 0.1, "t50_s": 0.5, "t90_s": 0.9}


class Vision:
    """Poses of a body with noise, that arrive late: NED positions and attitudes (w x y z)."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._due_us = 0
        self._under_way: deque[tuple[int, Vector3, Quaternion]] = deque()

    def arrived(self, state: VehicleState) -> list[tuple[Vector3, Quaternion]]:
        """Look at a state, and return the poses that arrive now."""
        now_us = state.time_us
        if now_us >= self._due_us:
            self._due_us += PERIOD_US
            seen = enu_to_ned(state.pose.position_m) + NOISE_M * self._rng.standard_normal(3)
            attitude = attitude_to_ned(state.pose.orientation_xyzw)
            self._under_way.append((now_us + LATE_US, tuple(seen.tolist()), attitude))
        found = []
        while self._under_way and self._under_way[0][0] <= now_us:
            found.append(self._under_way.popleft()[1:])
        return found

    def messages(self, state: VehicleState) -> list[common.MAVLink_message]:
        """Return what arrives now as VISION_POSITION_ESTIMATE, without covariance."""
        return [
            common.MAVLink_vision_position_estimate_message(
                state.time_us, *position, *rpy_from_quaternion((x, y, z, w)), [math.nan] * 21, 0
            )
            for position, (w, x, y, z) in self.arrived(state)
        ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print and write; 1, with a sentence, when real PX4 does not fly."""
    given = _options(arguments)
    try:
        _measure(given)
    except SimulationToolsError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = options(__doc__)
    parser.add_argument("--px4", type=Path, default=None, help="PX4's folder build/px4_sitl_default")
    parser.add_argument("--instance", type=int, default=7, help="of real PX4 (its option -i)")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3], help="of vision and sensors")
    parser.add_argument("--seconds", type=float, default=600.0, help="of each hover")
    given = parser.parse_args(arguments)
    if given.px4 is not None and not (given.px4 / "bin/px4").is_file():
        parser.error(f"there is no {given.px4}/bin/px4; give PX4's folder build/px4_sitl_default with --px4")
    if not given.seconds >= 2.0 * WINDOW_S:
        parser.error(f"--seconds is {given.seconds:g}; a hover must last at least {2.0 * WINDOW_S:g} s")
    return given


def _measure(given: argparse.Namespace) -> None:
    seconds, seeds = (2.0 * WINDOW_S, given.seeds[:1]) if given.brief else (given.seconds, given.seeds)
    kinds = ["ours"] if given.px4 is None else ["ours", "px4"]
    with Results("px4_vision", given.results, {**vars(given), "px4": str(given.px4)}) as results:
        found = {}
        for kind in kinds:
            flights = []
            for seed in tqdm(seeds, kind, unit=""):
                flights.append(fly_px4(seed, seconds, given) if kind == "px4" else fly_ours(seed, seconds))
            found[kind] = {**hover([h for h, _ in flights]), "step": step([s for _, s in flights])}
            found[kind]["each_cm"] = [hover([h])["hover_cm"] for h, _ in flights]
            results.add(f"px4_vision.{kind}", found[kind])
        print(summary(found))


def fly_ours(seed: int, seconds: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """Fly the stand-in once; return the rows of the hover, and of each step."""
    simulation = Simulation(_parameters(seed))
    px4, vision = simulation.px4, Vision(seed)
    assert px4 is not None

    def advance() -> VehicleState:
        state = stepped(simulation)
        for position, attitude in vision.arrived(state):
            px4.offer_external_vision(ExternalVision(state.time_us, position, attitude=attitude))
        return state

    flown = _fly(Pilot(px4, advance), seconds)
    simulation.close()
    return flown


def fly_px4(seed: int, seconds: float, given: argparse.Namespace) -> tuple[np.ndarray, list[np.ndarray]]:
    """Fly real PX4 once; return the rows of the hover, and of each step."""
    with tempfile.TemporaryDirectory() as folder:
        vision = Vision(seed)
        px4 = RealPx4(given.px4.resolve(), given.instance, Path(folder), PARAMETERS, seed, vision.messages)
        simulation = Simulation(_parameters(seed), px4)
        try:
            while not px4.is_ready():
                time.sleep(0.05)
            return _fly(Pilot(px4, partial(stepped, simulation)), seconds)
        finally:
            simulation.close()
            px4.close()


def _parameters(seed: int) -> SimulationParameters:
    return replace(standing(seed), gnss=False, px4_parameters=PARAMETERS)


def _fly(pilot: Pilot, seconds: float) -> tuple[np.ndarray, list[np.ndarray]]:
    pilot.fly(WAIT_S)
    pilot.take_off(HEIGHT_M, SETTLE_S)
    hovered = pilot.fly(seconds)
    return hovered, [pilot.manoeuvre(STEP) for _ in range(STEPS)]


def hover(flights: Sequence[np.ndarray]) -> dict:
    """Return the spread of all flights, each about its own mean, and how uncertain it is, cm."""
    axes = [COLUMNS.index(name) for name in ("north_m", "east_m", "down_m")]
    centred = [100.0 * (rows[:, axes] - rows[:, axes].mean(axis=0)) for rows in flights]
    length = round(WINDOW_S / np.median(np.diff(flights[0][:, 0])))
    windows = [rows[i : i + length] for rows in centred for i in range(0, len(rows) - length + 1, length)]
    variances = np.array([(rows**2).mean(axis=0) for rows in windows])
    spread = np.sqrt(variances.mean(axis=0))
    error = variances.std(axis=0, ddof=1) / math.sqrt(len(variances)) / (2.0 * spread)  # of a root
    return {"hover_cm": spread.tolist(), "hover_error_cm": error.tolist(), "windows": len(windows)}


def step(flights: Sequence[Sequence[np.ndarray]]) -> dict[str, float]:
    """Return the medians of times and overshoot over every step of every flight."""
    found = []
    for rows in (rows for flight in flights for rows in flight):
        share = quantity_of(STEP, rows) / STEP.last
        times = [rows[np.argmax(share > level), 0] for level in LEVELS.values()]
        found.append([*times, 100.0 * (share.max() - 1.0)])
    return dict(zip((*LEVELS, "overshoot_percent"), np.median(found, axis=0).tolist()))


def summary(found: dict[str, dict]) -> str:
    """Return hover and step as a table."""
    rows = []
    for i, axis in enumerate("xyz"):
        cells = [f"{f['hover_cm'][i]:.3f} +- {f['hover_error_cm'][i]:.3f}" for f in found.values()]
        rows.append((f"hover: standard deviation of {axis} [cm]", *cells))
    for key in (*LEVELS, "overshoot_percent"):
        rows.append((f"step of 2 m/s: {key}", *(f"{f['step'][key]:.2f}" for f in found.values())))
    return table(("", *found), rows)


if __name__ == "__main__":
    sys.exit(main())
