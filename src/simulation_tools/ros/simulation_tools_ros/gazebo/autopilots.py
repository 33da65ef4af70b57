"""Chooses the autopilot of the simulated UAV by the node's parameters."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable

import numpy as np
import rospy

from node_tools.compiling import run_compiled
from simulation_tools.ardupilot_sitl.ardupilot_sitl import ArduPilotSitl
from simulation_tools.ardupilot_sitl.json_link import DEFAULT_PORT as JSON_PORT
from simulation_tools.ardupilot_sitl.json_link import JsonLink
from simulation_tools.ardupilot_sitl.json_sensors import JsonSensorParameters, JsonSensors
from simulation_tools.ardupilot_sitl.program import Program, ProgramParameters
from simulation_tools.px4.mavlink.link import MavlinkLink
from simulation_tools.px4_ports import GCS_PORT, MAVROS_PORT
from simulation_tools.px4_sitl.hil_sensors import HilParameters
from simulation_tools.px4_sitl.own_links import OwnLinks
from simulation_tools.px4_sitl.px4_sitl import Px4Sitl
from simulation_tools.px4_sitl.simulator_link import DEFAULT_PORT, SimulatorLink, how_to_start
from simulation_tools.running.pacing import PacingParameters
from simulation_tools.running.run_loop import Link
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.simulation.payload import PayloadSensor
from simulation_tools.values import AUTOPILOTS, ParameterError, choice, mavlink_ports
from simulation_tools_ros.gazebo.parameters import number, port

DOWN = "range_finder"
"""Name of the range finder that looks down, in the UAV's SDF."""


def simulation_with_autopilot(
    parameters: SimulationParameters, pacing: PacingParameters
) -> tuple[Simulation, Link]:
    """Return the simulation and the MAVLink link of its flight controller.

    ~autopilot: standin, px4 for real PX4 SITL on TCP port ~simulator_port, or ardupilot for ArduPilot SITL on
    this UDP port. Raises SimulationToolsError if a parameter is wrong.
    """
    autopilot = choice("autopilot", str(rospy.get_param("~autopilot", "standin")), AUTOPILOTS)
    if autopilot == "standin":
        return _with_stand_in(parameters, pacing.lockstep)
    if pacing.lockstep:
        raise ParameterError(
            f"lockstep needs the stand-in's MAVLink link; with autopilot {autopilot}, start without it: "
            "physics and flight controller are in step with each other anyway."
        )
    # No simulator protocol carries a battery. PX4 (SIM_BAT_DRAIN) and ArduPilot simulate one themselves.
    parameters = replace(parameters, battery=None)
    with_real = {"px4": _with_real_px4, "ardupilot": _with_ardupilot}[autopilot]
    return with_real(parameters), OwnLinks()


def _with_stand_in(parameters: SimulationParameters, lockstep: bool) -> tuple[Simulation, Link]:
    ports = _mavlink_ports()
    simulation = Simulation(parameters)
    run_compiled(rospy.loginfo, simulation.warm_up)
    assert simulation.px4 is not None  # None: the stand-in flies
    link = MavlinkLink(simulation.px4, *ports)
    link.on_warning = rospy.logwarn
    if lockstep:
        link.hold()
    return simulation, link


def _mavlink_ports() -> tuple[int, int]:
    return mavlink_ports(
        rospy.get_param("~offboard_port", MAVROS_PORT), rospy.get_param("~gcs_port", GCS_PORT)
    )


def _with_ardupilot(parameters: SimulationParameters) -> Simulation:
    """Start ~ardupilot with the files ~ardupilot_parameters (space separated)."""
    offboard_port, gcs_port = _mavlink_ports()
    program = ProgramParameters(
        path=str(rospy.get_param("~ardupilot", "")).strip(),
        defaults=tuple(str(rospy.get_param("~ardupilot_parameters", "")).split()),
        origin=parameters.origin,
        offboard_port=offboard_port,
        gcs_port=gcs_port,
        system_id=int(number("target_system_id", 1.0, least=1.0, most=255.0)),
    )
    link = JsonLink(port("simulator_port", JSON_PORT))
    rng = np.random.default_rng([parameters.seed, JSON_PORT])
    sensors = JsonSensors(JsonSensorParameters(), rng)
    patience_s = number("ardupilot_patience", 60.0, least=0.0) or math.inf
    autopilot = ArduPilotSitl(link, sensors, Program(program, link.port), patience_s)
    autopilot.on_warning = rospy.logwarn
    rospy.loginfo(f"ArduPilot starts: {program.path}")
    simulation = Simulation(parameters, autopilot)
    sensors.look_down = next((_reader(each) for each in simulation.payload if each.name == DOWN), None)
    return simulation


def _reader(range_finder: PayloadSensor) -> Callable[[], float]:
    def read() -> float:
        range_m = range_finder.read()
        assert isinstance(range_m, float)
        return range_m

    return read


def _with_real_px4(parameters: SimulationParameters) -> Simulation:
    link = SimulatorLink(port("simulator_port", DEFAULT_PORT))
    link.on_warning = rospy.logwarn
    hil = HilParameters(origin=parameters.origin, gnss=parameters.gnss)
    rospy.loginfo(f"Waiting for PX4. {how_to_start(link.port)}")
    patience_s = number("px4_patience", 0.0, least=0.0) or math.inf
    rng = np.random.default_rng([parameters.seed, DEFAULT_PORT])
    return Simulation(parameters, Px4Sitl(link, hil, rng, patience_s))
