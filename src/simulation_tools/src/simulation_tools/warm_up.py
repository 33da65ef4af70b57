"""Compile every kernel ahead of the first flight: ``python -m simulation_tools.warm_up``."""

from __future__ import annotations

import time
from pathlib import Path

from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

WORLD = Path(__file__).resolve().parents[2] / "worlds/empty.world"


def warm_up() -> float:
    """Fly with each estimator of the flight controller; return the seconds that it took."""
    start = time.perf_counter()
    for gnss in (True, False):
        simulation = Simulation(SimulationParameters(str(WORLD), gnss=gnss, battery=BatteryStart()))
        simulation.warm_up()
        simulation.close()
    return time.perf_counter() - start


if __name__ == "__main__":
    print(f"The simulator's kernels are ready after {warm_up():.1f} s.")
