"""URDF: written of models, and read as models."""

from simulation_tools.sdf.urdf.reader import is_urdf, sdf_of
from simulation_tools.sdf.urdf.writer import urdf_of

__all__ = ["is_urdf", "sdf_of", "urdf_of"]
