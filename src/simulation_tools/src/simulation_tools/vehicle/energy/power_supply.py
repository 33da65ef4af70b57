"""What draws from the UAV's battery, step by step."""

from __future__ import annotations

import numpy as np

from simulation_tools.sdf.elements import Model
from simulation_tools.vehicle.energy.battery import Battery, BatteryStart
from simulation_tools.vehicle.energy.battery_plugins import EnergySupply, read_energy


class PowerSupply:
    """A battery with the rotors and devices that draw from it. power_w: drawn in the last step.

    The voltage does not change the thrust: PX4 scales its commands to hold the thrust. An empty battery stops
    the rotors.
    """

    def __init__(self, supply: EnergySupply, start: BatteryStart) -> None:
        self.battery = Battery(supply.battery, start)
        self.power_w = 0.0
        self._rotors = supply.rotors

    @classmethod
    def from_sdf(cls, model: Model, start: BatteryStart | None) -> PowerSupply | None:
        """Read it from the model's plugins; None without a battery or a start. Raises BatteryError."""
        supply = read_energy(model)
        return None if supply is None or start is None else cls(supply, start)

    def supplied(self, commands: np.ndarray) -> np.ndarray:
        """Return the rotor commands (n,) that the battery can follow: none when it is empty."""
        return np.zeros_like(commands) if self.battery.is_empty else commands

    def draw(self, thrusts_n: np.ndarray, climb_m_s: float, dt_s: float) -> None:
        """Draw for dt_s what the rotors and devices need.

        thrusts_n: of the rotors, (n,). climb_m_s: through the air along the rotors' axes.
        """
        wanted_w = self._rotors.power_w(thrusts_n, climb_m_s) + self.battery.parameters.power_load_w
        self.power_w = 0.0 if self.battery.is_empty else wanted_w
        self.battery.draw(self.power_w, dt_s)
