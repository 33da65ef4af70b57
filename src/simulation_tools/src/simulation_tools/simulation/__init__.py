"""The simulation without ROS: `Simulation` steps world, UAV, flight controller and sensors together."""

from simulation_tools.simulation.parameters import PhysicsDivergedError, SimulationError, SimulationParameters
from simulation_tools.simulation.sensor_suite import StepOutput
from simulation_tools.simulation.simulation import Simulation

__all__ = [
    "PhysicsDivergedError",
    "Simulation",
    "SimulationError",
    "SimulationParameters",
    "StepOutput",
]
