"""URDF: written of models, and read as models."""

from simulation_tools.sdf.urdf.reader import sdf_of
from simulation_tools.sdf.urdf.writer import urdf_of

__all__ = ["sdf_of", "urdf_of"]
