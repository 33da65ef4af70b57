"""Checks before the start that the ports of a launch are free."""

from __future__ import annotations

from typing import Any

from simulation_tools import values
from simulation_tools.ardupilot_sitl import json_link
from simulation_tools.mavlink import open_udp
from simulation_tools.px4_ports import own_ports
from simulation_tools.px4_sitl.simulator_link import check_port_is_free

HOST = "127.0.0.1"
PORTS = ("autopilot", "mavros", "offboard_port", "gcs_port", "simulator_port")
"""Arguments of `check_ports_are_free`."""
_SIMULATOR_PORTS = {"px4": check_port_is_free, "ardupilot": json_link.check_port_is_free}


def check_ports_are_free(
    autopilot: str, mavros: str, offboard_port: Any, gcs_port: Any, simulator_port: Any
) -> None:
    """Check the ports of the simulator and of MAVROS, as `sitl.launch` would start them.

    autopilot: standin, px4 or ardupilot. mavros: sim, real or none. offboard_port, gcs_port, simulator_port:
    as in the launch files; 0: any that is free.

    Raises:
        ParameterError: one is not a port.
        LinkError: one is taken.
    """
    offboard, ground = values.mavlink_ports(offboard_port, gcs_port)
    if mavros in ("sim", "real"):
        _check_udp(offboard, "MAVROS")
    if autopilot in _SIMULATOR_PORTS:
        _SIMULATOR_PORTS[autopilot](values.port("simulator_port", simulator_port))
        return
    for port, purpose in zip(own_ports(offboard, ground), ("the offboard API", "ground stations")):
        _check_udp(port, purpose)


def _check_udp(port: int, purpose: str) -> None:
    open_udp(HOST, port, purpose).close()
