"""Compile every kernel ahead of the first flight: ``python -m simulation_tools.warm_up``."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from simulation_tools.camera.defects import decals_of
from simulation_tools.camera.effects.amounts import effects_in
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_world
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

WORLD = Path(__file__).resolve().parents[2] / "worlds/empty.world"


def warm_up() -> float:
    """Fly with each estimator of the flight controller, and photograph; return the seconds that it took."""
    start = time.perf_counter()
    _photograph()
    for gnss in (True, False):
        simulation = Simulation(SimulationParameters(str(WORLD), gnss=gnss, battery=BatteryStart()))
        simulation.warm_up()
        simulation.close()
    return time.perf_counter() - start


def _photograph() -> None:
    """Photograph the horizon of an empty world, where cells are plain and mixed."""
    surfaces = surfaces_of(load_world(str(WORLD)))
    for effects in (None, effects_in("all")):
        renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics(64, 48), effects)
        renderer.photograph(Pose.from_xyz_rpy(0.0, 0.0, 2.0, -1.8), np.random.default_rng(1))


if __name__ == "__main__":
    print(f"The simulator's kernels are ready after {warm_up():.1f} s.")
