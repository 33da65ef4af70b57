"""Checks the arguments of real.launch that say how a real UAV is built and flown."""

from __future__ import annotations

import ipaddress
import os
import re
from pathlib import Path
from typing import Any, Mapping

from flight_basics.errors import FlightBasicsError
from flights.errors import ScenarioError
from flights.worlds import scenario
from simulation_tools import values
from simulation_tools.vehicle.uav import load_uav

SYSTEM_IDS = (1, 255)
CLEARANCES_M = (0.0, 5.0)
HOVER_HEIGHTS_M = (0.3, 20.0)
"""As mavros_publisher's dynamic_reconfigure."""
NO_LIDAR = "none"
AUTOPILOTS = ("px4", "ardupilot")
TOPICS = {"range_finder": "/range_finder", "joy": "/joy"}
"""Arguments that are topics, each with an example."""

_TOPIC = re.compile(r"[~/A-Za-z](\w|/)*")
_HOST_NAME = re.compile(r"[A-Za-z0-9]([\w.-]*[A-Za-z0-9])?")


def check(asked: Mapping[str, Any]) -> None:
    """Check the arguments.

    Raises:
        ScenarioError, SimulationToolsError: one sentence.
    """
    scenario.whole_number("tgt_system", asked["tgt_system"], *SYSTEM_IDS)
    scenario.choose("autopilot", str(asked["autopilot"]), AUTOPILOTS)
    scenario.choose("algorithm", str(asked["algorithm"]), scenario.ALGORITHMS)
    scenario.number("speed", asked["speed"], *scenario.SPEEDS_M_S)
    clearance_m = scenario.number("ground_clearance", asked["ground_clearance"], *CLEARANCES_M)
    hover_m = scenario.number("hover_height", asked["hover_height"], *HOVER_HEIGHTS_M)
    if hover_m <= clearance_m:
        raise ScenarioError(
            f"The UAV would hover at {hover_m:g} m, and its origin is at {clearance_m:g} m on the ground; "
            "give a greater hover_height."
        )
    _check_address(str(asked["lidar_ip"]).strip())
    for name, example in TOPICS.items():
        if not _TOPIC.fullmatch(str(asked[name])):
            raise ScenarioError(f"'{asked[name]}' is no {name}; give a topic, for example {name}:={example}.")
    _check_battery(str(asked["battery"]).strip())
    if scenario.flag("record", asked["record"]):
        _check_bags(str(asked["bags"]))
    _check_leaders(asked)
    _check_limits(asked)
    _check_uav(str(asked["model"]), str(asked["lidar"]), str(asked["sensors"]).split())


def _check_leaders(asked: Mapping[str, Any]) -> None:
    """Check what explore and inspection need, as their own launch files have it."""
    names = [name for name in ("explore", "inspection") if scenario.flag(name, asked.get(name, False))]
    if not names:
        return
    if scenario.flag("gnss", asked["gnss"]):
        raise ScenarioError(f"{names[0]}:=true flies without satellites; add gnss:=false.")
    if str(asked["lidar"]) not in scenario.CLOUD_LIDARS:
        raise ScenarioError(
            f"{names[0]}:=true needs clouds, which lidar:={asked['lidar']} does not give; "
            f"choose lidar:={', '.join(scenario.CLOUD_LIDARS)}."
        )
    for name, least in (("radius", 0.01), ("margin", 0.0), ("resolution", 0.01), ("time", 1.0)):
        values.number(name, asked[name], least)
    if "inspection" in names:
        _check_plan(str(asked.get("plan", "")).strip())
        _check_drawing(str(asked.get("drawing", "")).strip(), asked["drawing_home"])


def _check_limits(asked: Mapping[str, Any]) -> None:
    """Check the file of limits, and that somebody keeps it."""
    path = str(asked.get("limits", "")).strip()
    is_led = scenario.flag("explore", asked["explore"]) or scenario.flag("inspection", asked["inspection"])
    if path and not is_led:
        if not scenario.flag("slam", asked["slam"]):
            raise ScenarioError(f"limits:={path} counts in the map of SLAM; add slam:=true.")
        if asked["algorithm"] != "dynamic":
            raise ScenarioError(
                f"algorithm:={asked['algorithm']} keeps no limits; choose algorithm:=dynamic."
            )
    check_limits(path)


def check_limits(path: str) -> None:
    """Check the file of limits before a node reads it; empty: none. Raises ScenarioError."""
    if not path:
        return
    scenario.absolute("limits", path)
    from exploration.planning import read_limits  # needed by explorations and inspections only

    try:
        read_limits(path)
    except FlightBasicsError as error:
        raise ScenarioError(str(error)) from None


def _check_drawing(drawing: str, home: Any) -> None:
    """Check that the drawing is there, and the place in it; empty: none."""
    if drawing and not scenario.absolute("drawing", drawing).is_file():
        raise ScenarioError(f"{drawing}: there is no such drawing. Give a mesh.")
    scenario.place("drawing_home", home)


def _check_battery(battery: str) -> None:
    if battery not in ("", "endless"):
        raise ScenarioError(
            f"battery:={battery} is for a simulated battery, and a real UAV tells its charge itself; leave "
            "battery out, or give battery:=endless, for example on a tether."
        )


def _check_bags(bags: str) -> None:
    """Check the folder of the recording, which rosbag does not make."""
    folder = scenario.absolute("bags", bags)
    if not folder.is_dir():
        raise ScenarioError(f"{folder}: there is no such folder for the recording; make it with mkdir.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ScenarioError(f"{folder} may not be written to; choose another folder with bags:=FOLDER.")


def _check_plan(plan: str) -> None:
    """Check the plan before the UAV is in the air; empty: none."""
    if not plan:
        return
    if not Path(plan).is_absolute():
        raise ScenarioError(f"plan:={plan} is relative, but nodes run elsewhere; give plan:=$PWD/{plan}.")
    from inspection.survey.plan_file import read_plan  # needed by inspections only

    try:
        read_plan(Path(plan))
    except FlightBasicsError as error:
        raise ScenarioError(str(error)) from None


def _check_address(lidar_ip: str) -> None:
    """Check an IPv4 address or a host's name; empty: none."""
    is_number = not lidar_ip.strip("0123456789.")
    try:
        if lidar_ip and is_number:
            ipaddress.IPv4Address(lidar_ip)
    except ValueError:
        is_valid = False
    else:
        is_valid = not lidar_ip or is_number or _HOST_NAME.fullmatch(lidar_ip) is not None
    if not is_valid:
        raise ScenarioError(
            f"'{lidar_ip}' is no lidar_ip; give the Hokuyo's address, for example lidar_ip:=192.168.0.10."
        )


def _check_uav(model: str, lidar: str, sensors: list[str]) -> None:
    """Check that the UAV can be loaded, and that CEPA can read the scans of a lidar that is mounted on it."""
    load_uav(model, None if lidar == NO_LIDAR else lidar, sensors=sensors)
    if lidar not in (NO_LIDAR, *scenario.LIDARS):
        from flights.launch_arguments.lidar_beams import check_beams  # loads numba

        check_beams(model, lidar)
