"""Gives a UAV that stands a full battery, whoever simulates it."""

from __future__ import annotations

import time
from typing import Callable

import rospy
from mavros_msgs.msg import ParamValue
from mavros_msgs.srv import ParamGet, ParamSet
from std_srvs.srv import Trigger

from flights.errors import FlightError
from flights_ros.drivers.taking_off import Call, call_service

STAYS_AT = "SIM_BAT_MIN_PCT"
"""Parameter of PX4 SITL: its battery is never below this, %. It rises to it at once, too."""
FULL = 0.95
PATIENCE_S = 60.0
"""Wall time in which the flight controller tells that its battery is full. PX4 tells it every 2 s."""
LOOK_S = 0.2


def swap(autopilot: str, charge: Callable[[], float], call: Call = call_service) -> None:
    """Put a full battery in.

    Args:
        autopilot: standin, px4 or ardupilot. ArduPilot's simulated battery never gets empty.
        charge: the newest one that the flight controller has told, 0..1.
        call: as `call_service`.

    Raises:
        FlightError: it cannot be swapped.
    """
    if autopilot == "px4":
        _fill_px4s(charge, call)
    elif autopilot == "standin":
        call("/gazebo/swap_battery", Trigger)


def _fill_px4s(charge: Callable[[], float], call: Call) -> None:
    """Let the battery begin again that PX4 SITL simulates itself. A restart of PX4 would forget its place."""
    before = call("/mavros/param/get", ParamGet, STAYS_AT).value
    _set(call, 100.0)
    try:
        end_s = time.monotonic() + PATIENCE_S
        while not charge() >= FULL:
            if time.monotonic() > end_s or rospy.is_shutdown():
                raise FlightError(
                    f"PX4's simulated battery does not get full: {PATIENCE_S:g} s after {STAYS_AT} was set "
                    f"to 100, PX4 tells {charge():.0%}."
                )
            time.sleep(LOOK_S)
    finally:
        _set(call, before.real or float(before.integer))


def _set(call: Call, percent: float) -> None:
    call("/mavros/param/set", ParamSet, STAYS_AT, ParamValue(integer=0, real=percent))
