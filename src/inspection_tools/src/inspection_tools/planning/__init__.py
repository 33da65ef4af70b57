"""Paths through known free space on a map of voxels. It needs numba, so import it by its own name."""

from flight_limits import KeepOutBox, Limits
from inspection_tools.planning.limits import read_limits
from inspection_tools.planning.parameters import PlannerParameters
from inspection_tools.planning.planner import PathPlanner, Plan
from inspection_tools.planning.voxel_grid import FREE, OCCUPIED, UNKNOWN, VoxelGrid

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
