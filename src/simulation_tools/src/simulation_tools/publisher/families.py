"""Families of flight controllers: in what they differ for a client that flies them by setpoints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

from simulation_tools.values import choice


@dataclass(frozen=True)
class Family:
    """One family of flight controllers. The modes have MAVROS's names.

    guided: mode in which it obeys setpoints. landing: mode in which it lands and disarms.
    takes_off_by_command: it leaves the ground by a command, and a setpoint would end its climb. False: it
    climbs to a setpoint. comes_back: after a failsafe the client takes the UAV back. False: the failsafe has
    the last word. brakes_by_plan: without a pose, `Brake` flies it to a standstill. False: it gets velocities
    of zero. needs_origin: without GNSS it arms only after a client has told it a place on earth.
    levelled: mode in which it obeys attitudes and needs no place. A UAV that lands without a pose comes down
    in it, because the landing itself would follow a velocity that nobody measures. Empty: the landing comes
    down level by itself.
    """

    guided: str
    landing: str
    takes_off_by_command: bool
    comes_back: bool
    brakes_by_plan: bool
    needs_origin: bool
    levelled: str


PX4 = Family(
    "OFFBOARD",
    "AUTO.LAND",
    takes_off_by_command=False,
    comes_back=True,
    brakes_by_plan=True,
    needs_origin=False,
    levelled="",
)
ARDUPILOT = Family(
    "GUIDED",
    "LAND",
    takes_off_by_command=True,
    comes_back=False,
    brakes_by_plan=False,
    needs_origin=True,
    levelled="GUIDED_NOGPS",
)

_FAMILIES: Mapping[str, Family] = {"standin": PX4, "px4": PX4, "ardupilot": ARDUPILOT}


def family_of(autopilot: str) -> Family:
    """Return the family of an autopilot: standin, px4 or ardupilot. Raises ParameterError."""
    return _FAMILIES[choice("autopilot", autopilot, tuple(_FAMILIES))]
