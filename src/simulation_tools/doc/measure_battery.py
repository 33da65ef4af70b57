"""Measures battery.md's table: the UAV hovers at 2 m until the battery is empty.

Run: .venv/bin/python src/simulation_tools/doc/measure_battery.py
"""

from __future__ import annotations

from pathlib import Path

from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

EMPTY = str(Path(__file__).parents[1] / "worlds" / "empty.world")
CASES = (("iris", None), ("iris", "ust"), ("iris", "puck"), ("small_quad", "ust"), ("small_quad", "puck"))
HOVER_FROM_S, HOVER_TO_S = 20.0, 40.0
LEFT = (0.2, 0.07, 0.0)


def main() -> None:
    """Print a row for each UAV: hover power, and the minutes from the start to each charge of `LEFT`."""
    for model, lidar in CASES:
        simulation = Simulation(SimulationParameters(EMPTY, model, lidar, battery=BatteryStart()))
        mass_kg = simulation.world.mass_kg(simulation.uav_name)
        power_w, minutes = _hover(simulation)
        simulation.close()
        print(
            model,
            lidar,
            f"{mass_kg:.2f} kg {power_w:.1f} W",
            *(f"{each:.1f} min" for each in minutes),
            flush=True,
        )


def _hover(simulation: Simulation) -> tuple[float, list[float]]:
    """Return the mean power in hover, and the minutes after which the battery is at each charge of `LEFT`."""
    px4, supply = simulation.px4, simulation.power
    assert px4 is not None  # the stand-in flies
    assert supply is not None  # with a battery
    powers: list[float] = []
    minutes: list[float] = []
    step = 0
    while len(minutes) < len(LEFT):
        if step % 10 == 0:
            px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 2.0), 0.0))
            if not px4.status.armed and px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED:
                px4.request_arm()
        simulation.step()
        step += 1
        time_s = 1e-6 * simulation.time_us
        if HOVER_FROM_S < time_s < HOVER_TO_S:
            powers.append(supply.power_w)
        if supply.battery.remaining <= LEFT[len(minutes)]:
            minutes.append(time_s / 60.0)
    return sum(powers) / len(powers), minutes


if __name__ == "__main__":
    main()
