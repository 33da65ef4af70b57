"""Chooses the autopilot of the simulated UAV by the node's parameters."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import rospy

from node_tools.compiling import run_compiled
from simulation_tools.px4.mavlink.link import MavlinkLink
from simulation_tools.px4_ports import GCS_PORT, MAVROS_PORT
from simulation_tools.px4_sitl.hil_sensors import HilParameters
from simulation_tools.px4_sitl.own_links import OwnLinks
from simulation_tools.px4_sitl.px4_sitl import Px4Sitl
from simulation_tools.px4_sitl.simulator_link import DEFAULT_PORT, SimulatorLink, how_to_start
from simulation_tools.running.pacing import PacingParameters
from simulation_tools.running.run_loop import Link
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.values import AUTOPILOTS, ParameterError, choice, mavlink_ports
from simulation_tools_ros.gazebo.parameters import number, port


def simulation_with_autopilot(
    parameters: SimulationParameters, pacing: PacingParameters
) -> tuple[Simulation, Link]:
    """Return the simulation and the MAVLink link of its flight controller.

    ~autopilot: standin, or px4 for real PX4 SITL on TCP port ~simulator_port. Raises SimulationToolsError if
    a parameter is wrong.
    """
    autopilot = choice("autopilot", str(rospy.get_param("~autopilot", "standin")), AUTOPILOTS)
    if autopilot == "px4":
        return _with_real_px4(parameters, pacing), OwnLinks()
    ports = mavlink_ports(
        rospy.get_param("~offboard_port", MAVROS_PORT), rospy.get_param("~gcs_port", GCS_PORT)
    )
    simulation = Simulation(parameters)
    run_compiled(rospy.loginfo, simulation.warm_up)
    assert simulation.px4 is not None  # None: the stand-in flies
    link = MavlinkLink(simulation.px4, *ports)
    link.on_warning = rospy.logwarn
    return simulation, link


def _with_real_px4(parameters: SimulationParameters, pacing: PacingParameters) -> Simulation:
    if pacing.lockstep:
        raise ParameterError(
            "lockstep needs the stand-in's MAVLink link; with autopilot px4, start without it: physics and "
            "PX4 are in step with each other anyway."
        )
    link = SimulatorLink(port("simulator_port", DEFAULT_PORT))
    link.on_warning = rospy.logwarn
    hil = HilParameters(origin=parameters.origin, gnss=parameters.gnss)
    rospy.loginfo(f"Waiting for PX4. {how_to_start(link.port)}")
    patience_s = number("px4_patience", 0.0, least=0.0) or math.inf
    rng = np.random.default_rng([parameters.seed, DEFAULT_PORT])
    # Its simulator protocol carries no battery; PX4 SITL simulates one itself (SIM_BAT_DRAIN).
    parameters = replace(parameters, battery=None)
    return Simulation(parameters, Px4Sitl(link, hil, rng, patience_s))
