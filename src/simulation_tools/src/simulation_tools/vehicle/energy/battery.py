"""A LiPo battery: charge, open-circuit voltage, internal resistance, cold.

The open-circuit voltage of a cell is the curve of Chen and Rincon-Mora ("Accurate electrical battery model
capable of predicting runtime and I-V performance", IEEE Trans. Energy Conversion, 2006), or the straight line
of Gazebo's LinearBatteryPlugin if the model gives its coefficients.
"""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass
from typing import NamedTuple

from flight_basics.checks import check_limits, limited
from simulation_tools.errors import SimulationToolsError

S_PER_H = 3600.0
AVERAGING_S = 20.0
"""Time constant of the mean current from which the time remaining is told."""

WARM_C, COLDEST_C, COLDEST_SHARE = 20.0, -20.0, 0.6
"""A battery of 20 degrees gives all its capacity, one of -20 degrees 60 %; in between a straight line."""


class BatteryError(SimulationToolsError):
    """A battery is described wrongly."""


@dataclass(frozen=True)
class BatteryParameters:
    """A battery, named as in Gazebo's LinearBatteryPlugin.

    capacity_ah: when warm. initial_charge_ah: at the start. resistance_ohm: of all cells together. cells: in
    series, 1 to 10, as MAVLink tells them. smooth_current_tau_s: time constant of the current that is told.
    linear_voltage_v: voltage E0 of the full battery and E1, what is added when it is empty (negative); None:
    the curve of a LiPo cell. power_load_w: what everything but the rotors draws.
    """

    capacity_ah: float = limited(MISSING, above=0.0)
    initial_charge_ah: float = limited(MISSING, 0.0)
    resistance_ohm: float = limited(0.0, 0.0)
    cells: int = limited(3, 1, 10)
    smooth_current_tau_s: float = limited(1.0, 0.0)
    linear_voltage_v: tuple[float, float] | None = None
    power_load_w: float = limited(0.0, 0.0)

    def __post_init__(self) -> None:
        check_limits(self, BatteryError, "The battery's {}")
        if self.initial_charge_ah > self.capacity_ah:
            raise BatteryError(
                f"The battery's initial_charge must be from 0 to its capacity of {self.capacity_ah:g} Ah, "
                f"but is {self.initial_charge_ah} Ah."
            )
        if (
            self.linear_voltage_v is not None
            and not min(self.linear_voltage_v[0], sum(self.linear_voltage_v)) > 0.0
        ):
            raise BatteryError(
                f"The battery's open-circuit voltage {self.linear_voltage_v} V is not positive."
            )

    def open_circuit_voltage_v(self, share: float) -> float:
        """Return the voltage without a current at a charge of 0..1 of the capacity."""
        if self.linear_voltage_v is not None:
            constant, linear = self.linear_voltage_v
            return constant + linear * (1.0 - share)
        return self.cells * cell_voltage_v(share)


@dataclass(frozen=True)
class BatteryStart:
    """How the battery is when the simulation starts.

    charge: 0..1 of what it can give; None: the model's initial_charge. temperature_c: of the battery.
    """

    charge: float | None = limited(None, 0.0, 1.0)
    temperature_c: float = limited(WARM_C, COLDEST_C, 60.0)

    def __post_init__(self) -> None:
        check_limits(self, BatteryError, "The battery's {}")

    @property
    def capacity_share(self) -> float:
        """Share of the capacity that a battery of this temperature gives."""
        cold = (WARM_C - min(self.temperature_c, WARM_C)) / (WARM_C - COLDEST_C)
        return 1.0 - (1.0 - COLDEST_SHARE) * cold


class BatteryReading(NamedTuple):
    """What a battery monitor tells.

    current_a: positive when discharging. remaining: 0..1. time_remaining_s: at the mean current; None if that
    is not known. temperature_c: None if not known.
    """

    voltage_v: float
    current_a: float
    consumed_mah: float
    remaining: float
    cells: int
    time_remaining_s: float | None = None
    temperature_c: float | None = None


def cell_voltage_v(share: float) -> float:
    """Return the open-circuit voltage of a LiPo cell at a charge of 0..1 (Chen and Rincon-Mora, eq. 2)."""
    rising = 3.685 + share * (0.2156 + share * (-0.1178 + share * 0.3201))
    return rising - 1.031 * math.exp(-35.0 * share)


class Battery:
    """A battery in use. is_empty: it gives nothing more."""

    def __init__(self, parameters: BatteryParameters, start: BatteryStart | None = None) -> None:
        """start: by default warm, with the model's initial charge."""
        self.parameters = parameters
        self._start = start or BatteryStart()
        self._capacity_ah = parameters.capacity_ah * self._start.capacity_share
        self.reset()

    def reset(self) -> None:
        """Go back to the start."""
        charge, p = self._start.charge, self.parameters
        self._fill(p.initial_charge_ah / p.capacity_ah if charge is None else charge)

    def swap(self) -> None:
        """Put in a full battery of the same temperature."""
        self._fill(1.0)

    def _fill(self, share: float) -> None:
        self._charge_ah = share * self._capacity_ah
        self._consumed_ah = self._current_a = 0.0
        self._mean_current_a: float | None = None
        self._reading: BatteryReading | None = None

    @property
    def remaining(self) -> float:
        """Charge, 0..1 of what the battery can give."""
        return self._charge_ah / self._capacity_ah

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left."""
        return self._charge_ah <= 0.0

    def current_at(self, power_w: float) -> float:
        """Return the current that gives a power at the terminals, A.

        It solves P = (E - R I) I. A power that the battery cannot give yields the current of its greatest.
        """
        voltage, resistance = (
            self.parameters.open_circuit_voltage_v(self.remaining),
            self.parameters.resistance_ohm,
        )
        if resistance == 0.0:
            return power_w / voltage
        under_root = max(voltage * voltage - 4.0 * resistance * power_w, 0.0)
        return 2.0 * power_w / (voltage + math.sqrt(under_root)) if under_root else 0.5 * voltage / resistance

    def draw(self, power_w: float, dt_s: float) -> None:
        """Give a power for dt_s; an empty battery gives none."""
        self._reading = None
        current_a = 0.0 if self.is_empty else self.current_at(power_w)
        drawn_ah = min(current_a * dt_s / S_PER_H, self._charge_ah)
        self._charge_ah -= drawn_ah
        self._consumed_ah += drawn_ah
        tau_s = self.parameters.smooth_current_tau_s
        self._current_a += (current_a - self._current_a) * min(1.0, dt_s / tau_s if tau_s else 1.0)
        mean_a = current_a if self._mean_current_a is None else self._mean_current_a
        self._mean_current_a = mean_a + (current_a - mean_a) * min(1.0, dt_s / AVERAGING_S)

    @property
    def reading(self) -> BatteryReading:
        """What its monitor tells."""
        if self._reading is None:
            self._reading = self._read()
        return self._reading

    def _read(self) -> BatteryReading:
        p, remaining, mean_a = self.parameters, self.remaining, self._mean_current_a
        return BatteryReading(
            voltage_v=p.open_circuit_voltage_v(remaining) - p.resistance_ohm * self._current_a,
            current_a=self._current_a,
            consumed_mah=1e3 * self._consumed_ah,
            remaining=remaining,
            cells=p.cells,
            time_remaining_s=S_PER_H * self._charge_ah / mean_a if mean_a else None,
            temperature_c=self._start.temperature_c,
        )
