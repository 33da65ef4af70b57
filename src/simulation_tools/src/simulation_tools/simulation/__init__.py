"""The simulation without ROS: `Simulation` steps world, UAV, flight controller and sensors together."""

from simulation_tools.simulation.parameters import SimulationError, SimulationParameters
from simulation_tools.simulation.simulation import PhysicsDivergedError, Simulation, StepOutput

__all__ = [
    "PhysicsDivergedError",
    "Simulation",
    "SimulationError",
    "SimulationParameters",
    "StepOutput",
]
