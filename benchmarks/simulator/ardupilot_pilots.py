"""The step responses of `bench ardupilot`, by each of its flight controllers, without ROS and in lockstep."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.px4_vision import PARAMETERS, Vision
from benchmarks.simulator.real_ardupilot import RealArduPilot
from benchmarks.simulator.real_px4 import RealPx4
from benchmarks.simulator.reference_quad import standing, stepped
from benchmarks.simulator.step_response import MANOEUVRES, Pilot
from simulation_tools.autopilot import VehicleState
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.simulation import Simulation, SimulationParameters

LATE = {"VISO_DELAY_MS": 50.0}
HEIGHT_M, TAKE_OFF_S, SETTLE_S, HOVER_S = 3.0, 120.0, 20.0, 60.0
WAIT_S = {True: 60.0, False: 25.0}
"""Until real PX4 takes off, with GNSS and without."""


@dataclass(frozen=True)
class Programs:
    """Where the real flight controllers are: arducopter, and PX4's build folder with its instance number."""

    ardupilot: str
    px4: Path | None
    instance: int

    @property
    def pilots(self) -> tuple[str, ...]:
        """The flight controllers that can fly."""
        return ("ardupilot", "standin") if self.px4 is None else ("ardupilot", "px4", "standin")


def fly_steps(pilot: str, gnss: bool, seed: int, programs: Programs) -> dict[str, np.ndarray]:
    """Return the rows of a hover and of every manoeuvre, by name. pilot: one of `Programs.pilots`."""
    fly = {"ardupilot": fly_ardupilot, "px4": fly_px4, "standin": fly_stand_in}[pilot]
    return fly(gnss, seed, programs)


def fly_stand_in(gnss: bool, seed: int, _: Programs) -> dict[str, np.ndarray]:
    """Fly the stand-in once."""
    simulation = Simulation(_parameters(gnss, seed))
    px4, vision = simulation.px4, Vision(seed)
    assert px4 is not None

    def advance() -> VehicleState:
        state = stepped(simulation)
        if not gnss:
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


def fly_ardupilot(gnss: bool, seed: int, programs: Programs) -> dict[str, np.ndarray]:
    """Fly ArduPilot once."""
    settings, messages = ({}, _nothing) if gnss else (LATE, Vision(seed).messages)
    ardupilot = RealArduPilot(programs.ardupilot, seed, gnss, settings, messages)
    simulation = Simulation(_parameters(gnss, seed), ardupilot)
    try:
        while not ardupilot.is_ready():
            time.sleep(0.02)
        pilot = Pilot(ardupilot, partial(stepped, simulation))
        ardupilot.take_off(HEIGHT_M, pilot, TAKE_OFF_S)
        return _fly(pilot)
    finally:
        simulation.close()


def fly_px4(gnss: bool, seed: int, programs: Programs) -> dict[str, np.ndarray]:
    """Fly real PX4 once."""
    assert programs.px4 is not None
    settings, messages = ({}, _nothing) if gnss else (PARAMETERS, Vision(seed).messages)
    with tempfile.TemporaryDirectory() as folder:
        px4 = RealPx4(programs.px4, programs.instance, Path(folder), settings, seed, messages, gnss)
        try:
            simulation = Simulation(_parameters(gnss, seed), px4)
            try:
                while not px4.is_ready():
                    time.sleep(0.02)
                pilot = Pilot(px4, partial(stepped, simulation))
                pilot.fly(WAIT_S[gnss])
                pilot.take_off(HEIGHT_M, SETTLE_S)
                return _fly(pilot)
            finally:
                simulation.close()
        finally:
            px4.close()


def _nothing(_: VehicleState) -> tuple[()]:
    return ()


def _parameters(gnss: bool, seed: int) -> SimulationParameters:
    parameters = replace(standing(seed), model="iris")
    return parameters if gnss else replace(parameters, gnss=False, px4_parameters=PARAMETERS)


def _fly(pilot: Pilot) -> dict[str, np.ndarray]:
    assert MANOEUVRES[0].before is not None
    pilot.stream(MANOEUVRES[0].before)
    pilot.fly(SETTLE_S)
    return {"hover": pilot.fly(HOVER_S), **{m.name: pilot.manoeuvre(m) for m in MANOEUVRES}}
