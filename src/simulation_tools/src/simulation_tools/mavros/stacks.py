"""What MAVROS does differently for PX4 and for ArduPilot Copter: names of modes, parameters on the wire."""

from __future__ import annotations

from typing import Mapping, Protocol

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools.mavlink import parameter_from_wire, parameter_to_wire
from simulation_tools.mavros import mode_names

_COPTER_MODES: Mapping[str, int] = {
    "STABILIZE": 0,
    "ACRO": 1,
    "ALT_HOLD": 2,
    "AUTO": 3,
    "GUIDED": 4,
    "LOITER": 5,
    "RTL": 6,
    "CIRCLE": 7,
    "POSITION": 8,
    "LAND": 9,
    "OF_LOITER": 10,
    "DRIFT": 11,
    "SPORT": 13,
    "FLIP": 14,
    "AUTOTUNE": 15,
    "POSHOLD": 16,
    "BRAKE": 17,
    "THROW": 18,
    "AVOID_ADSB": 19,
    "GUIDED_NOGPS": 20,
}
_COPTER_NAMES = {number: name for name, number in _COPTER_MODES.items()}
_WHOLE = range(common.MAV_PARAM_TYPE_UINT8, common.MAV_PARAM_TYPE_INT64 + 1)


class Stack(Protocol):
    """The software of a flight controller, as its clients must know it."""

    name: str

    def mode_name(self, custom_mode: int) -> str:
        """Return MAVROS's name of a mode."""

    def custom_mode(self, name: str) -> int | None:
        """Return the mode for MAVROS's name of it, or for a number as text; None when it is neither."""

    def to_wire(self, value: float, is_integer: bool) -> float:
        """Return the float that carries a parameter's value; raises ValueError for one out of range."""

    def from_wire(self, value: float, kind: int) -> float | int:
        """Return a parameter's value. kind: MAV_PARAM_TYPE. Raises ValueError for a type it does not have."""


class Px4Stack:
    """PX4: modes of two numbers; an integer's bits in the float."""

    name = "PX4"
    mode_name = staticmethod(mode_names.mode_name)
    custom_mode = staticmethod(mode_names.custom_mode)
    to_wire = staticmethod(parameter_to_wire)
    from_wire = staticmethod(parameter_from_wire)


class CopterStack:
    """ArduPilot Copter: modes of one number; an integer's value in the float."""

    name = "ArduPilot"

    def mode_name(self, custom_mode: int) -> str:
        """Return MAVROS's name of a mode."""
        return _COPTER_NAMES.get(custom_mode, f"CMODE({custom_mode})")

    def custom_mode(self, name: str) -> int | None:
        """Return the mode for a name or a number as text."""
        if name in _COPTER_MODES:
            return _COPTER_MODES[name]
        return int(name) if name.isdigit() and int(name) < 2**32 else None

    def to_wire(self, value: float, is_integer: bool) -> float:
        """Return the value as it is. A float holds whole numbers up to 2^24 exactly."""
        if not (abs(value) <= 2**24 if is_integer else fit_float32([value])):
            raise ValueError(f"{value} is not a number that ArduPilot's parameters can hold")
        return float(value)

    def from_wire(self, value: float, kind: int) -> float | int:
        """Return a whole number for all types but REAL32."""
        if kind == common.MAV_PARAM_TYPE_REAL32:
            return value
        if kind in _WHOLE:
            return round(value)
        raise ValueError(f"ArduPilot has no parameters of MAVLink type {kind}")


_PX4, _COPTER = Px4Stack(), CopterStack()


def stack_of(autopilot: int | None) -> Stack:
    """Return the stack for MAV_AUTOPILOT in a heartbeat; PX4's before there is one."""
    return _COPTER if autopilot == common.MAV_AUTOPILOT_ARDUPILOTMEGA else _PX4
