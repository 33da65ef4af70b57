"""Checks the simulator's parameters, packages and ports before it starts."""

from __future__ import annotations

from typing import Any, Callable, Mapping

from flights.errors import ScenarioError
from flights.worlds import scenario
from simulation_tools import values
from simulation_tools.launch_check.launch_autopilot import check_autopilot
from simulation_tools.launch_check.launch_files import LaunchError
from simulation_tools.launch_check.launch_packages import check_mavros_is_there
from simulation_tools.launch_check.launch_ports import PORTS, check_ports_are_free
from simulation_tools.vehicle.uav import load_uav

PX4_INSTANCES = (0, 254)
"""The instance's MAVLink system id, which is greater by 1, is a byte."""
LIDAR_DRIVER = "urg_node"


def check(asked: Mapping[str, Any]) -> None:
    """Check a launch file's values for the simulator.

    Raises:
        ScenarioError, SimulationToolsError: one sentence.
    """
    if "px4_instance" in asked:
        scenario.whole_number("px4_instance", asked["px4_instance"], *PX4_INSTANCES)
        values.port("simulator_port", asked["simulator_port"])
    if "offboard_port" in asked:
        values.mavlink_ports(asked["offboard_port"], asked["gcs_port"])
    if "autopilot" in asked:
        values.choice("autopilot", str(asked["autopilot"]), values.AUTOPILOTS)
        if "ardupilot" in asked:  # a real UAV brings its own
            _check_autopilot(asked)
    for name, least in (("real_time_factor", 0.0), ("lockstep_timeout", 0.001), ("lidar_range_max", 0.0)):
        if name in asked:
            values.number(name, asked[name], least)
    if "mavros" in asked:
        scenario.choose("mavros", str(asked["mavros"]), scenario.MAVROS)
    sensors, model = str(asked.get("sensors", "")).split(), str(asked.get("model", "iris"))
    if sensors or model != "iris":
        load_uav(model, sensors=sensors)


def _check_autopilot(asked: Mapping[str, Any]) -> None:
    try:
        check_autopilot(asked)
    except LaunchError as error:
        raise ScenarioError(str(error)) from None


def check_packages(asked: Mapping[str, Any], find: Callable[[str], object]) -> None:
    """Check that real MAVROS and the lidar's driver are there if a launch starts them.

    Raises SimulationToolsError.

    find: raises LookupError for a package that is not there.
    """
    gnss = str(asked.get("gnss", "true")).lower() == "true"
    check_mavros_is_there(str(asked.get("mavros", "sim")), gnss, find)
    fcu_url, lidar_ip = (str(asked.get(name, "")).strip() for name in ("fcu_url", "lidar_ip"))
    if fcu_url:
        check_mavros_is_there("real", gnss, find, word=f"fcu_url:={fcu_url}")
    if lidar_ip:
        _check_driver(f"lidar_ip:={lidar_ip}", find)


def _check_driver(word: str, find: Callable[[str], object]) -> None:
    try:
        find(LIDAR_DRIVER)
    except LookupError:
        raise LaunchError(
            f"{word} needs the package {LIDAR_DRIVER}, and ROS does not find it. Build it beside MAVROS, or "
            f"leave out {word}, and start your lidar's driver yourself."
        ) from None


def check_ports(asked: Mapping[str, Any]) -> None:
    """Check that the ports of a launch are free, if it names them; raises SimulationToolsError."""
    if all(name in asked for name in PORTS):
        check_ports_are_free(**{name: asked[name] for name in PORTS})
