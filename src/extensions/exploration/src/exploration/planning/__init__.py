"""Paths through known free space on a map of voxels. It needs numba, so import it by its own name."""

from exploration.planning.limits import read_limits
from exploration.planning.parameters import PlannerParameters
from exploration.planning.planner import PathPlanner, Plan
from exploration.planning.voxel_grid import FREE, OCCUPIED, UNKNOWN, VoxelGrid
from flight_limits import KeepOutBox, Limits

__all__ = [
    "FREE",
    "OCCUPIED",
    "UNKNOWN",
    "KeepOutBox",
    "Limits",
    "PathPlanner",
    "Plan",
    "PlannerParameters",
    "VoxelGrid",
    "read_limits",
]
