"""The battery and the loads that a model's SDF describes in its plugins.

- Gazebo's LinearBatteryPlugin, by any of its names: the battery, its parameters named as in Gazebo, and the
  coefficients of the rotors' power (`rotor_k1`, `rotor_k2`, `rotor_c2`).
- ``libsimulation_tools_power_load.so``: a device that draws `power_load` watts all the time.
"""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.plugins import PluginReader
from simulation_tools.vehicle.energy.battery import BatteryError, BatteryParameters
from simulation_tools.vehicle.energy.rotor_power import RotorPower

BATTERIES = (
    "libLinearBatteryPlugin.so",
    "ignition-gazebo-linearbatteryplugin-system",
    "gz-sim-linearbatteryplugin-system",
)
POWER_LOAD = "libsimulation_tools_power_load.so"
_TYPICAL_CELL_V = 4.0


@dataclass(frozen=True)
class EnergySupply:
    """What a model's SDF says of its energy."""

    battery: BatteryParameters
    rotors: RotorPower


def read_energy(model: Model) -> EnergySupply | None:
    """Return the battery and what draws from it; None for a model without a battery.

    Raises:
        BatteryError: names the file and line of a plugin that is wrong.
    """
    source = model.source or model.name
    plugins = [plugin for plugin in model.plugins if plugin.filename in BATTERIES]
    if not plugins:
        return None
    if len(plugins) > 1:
        raise BatteryError(f"{source}:{plugins[1].line}: A UAV can have one battery only.")
    read = PluginReader(source, plugins[0], BatteryError)
    usual = RotorPower()
    coefficients = {name: read.number(f"rotor_{name}", getattr(usual, name)) for name in ("k1", "k2", "c2")}
    try:
        return EnergySupply(_battery(read, power_load_w(model)), RotorPower(**coefficients))
    except BatteryError as error:
        text = str(error)
        raise error if text.startswith(source) else read.error(text) from None


def power_load_w(model: Model) -> float:
    """Return what the devices of a model draw together, W; BatteryError if one is negative or no number."""
    total = 0.0
    for plugin in model.plugins:
        if plugin.filename in (POWER_LOAD, *BATTERIES):
            read = PluginReader(model.source or model.name, plugin, BatteryError)
            load = read.number("power_load", 0.0 if plugin.filename != POWER_LOAD else None)
            if load < 0.0:
                raise read.error(f"<power_load> must not be negative, got {load:g}")
            total += load
    return total


def _battery(read: PluginReader, load_w: float) -> BatteryParameters:
    capacity = read.number("capacity")
    voltage = read.number("voltage")
    linear = None
    if read.has("open_circuit_voltage_constant_coef"):
        linear = (
            read.number("open_circuit_voltage_constant_coef"),
            read.number("open_circuit_voltage_linear_coef"),
        )
    return BatteryParameters(
        capacity_ah=capacity,
        initial_charge_ah=read.number("initial_charge", capacity),
        resistance_ohm=read.number("resistance", 0.0),
        cells=int(read.number("cells", max(1.0, round(voltage / _TYPICAL_CELL_V)))),
        smooth_current_tau_s=read.number("smooth_current_tau", 1.0),
        linear_voltage_v=linear,
        power_load_w=load_w,
    )
