"""The body on which PX4's step responses were measured. It stands in an empty world, its nose to north."""

from __future__ import annotations

import math

from benchmarks.shared.results import ROOT
from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import Pose, quaternion_from_rpy, rotate_inverse
from simulation_tools.simulation import Simulation, SimulationParameters

PACKAGE = ROOT / "src/simulation_tools"
NORTH_RAD = 0.5 * math.pi


def standing(seed: int) -> SimulationParameters:
    """Return the simulation's parameters."""
    return SimulationParameters(
        world=str(PACKAGE / "worlds/empty.world"),
        model="reference_quad",
        lidar=None,
        model_path=(str(PACKAGE / "models"),),
        spawn_pose=Pose((0.0, 0.0, 0.0), quaternion_from_rpy(0.0, 0.0, NORTH_RAD)),
        seed=seed,
    )


def stepped(simulation: Simulation) -> VehicleState:
    """Advance by one time step; return the true state then."""
    simulation.step()
    body = simulation.world.get_state(simulation.uav_name)
    rates = rotate_inverse(body.pose.orientation_xyzw, body.angular_velocity_rad_s)
    return VehicleState(simulation.time_us, body.pose, body.linear_velocity_m_s, rates)
