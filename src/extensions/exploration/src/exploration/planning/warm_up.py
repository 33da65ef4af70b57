"""Compiles the path planner ahead of use."""

from __future__ import annotations

import numpy as np

from exploration.planning.planner import PathPlanner
from exploration.planning.voxel_grid import FREE, OCCUPIED
from flight_basics.errors import NoPathError

SIDE = 16
VOXEL_M = 0.2


def warm_up_planning() -> None:
    """Plan a path in free space, and see that none leads through a wall."""
    planner, kinds = planner_in_free_space()
    planner.is_clear(planner.plan(np.array((0.9, 1.5, 1.5)), np.array((2.1, 1.5, 1.5))).points_m)
    kinds[:, :, SIDE // 2] = OCCUPIED
    planner.update_map(VOXEL_M, SIDE, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    try:
        planner.plan(np.array((0.75, 1.5, 1.5)), np.array((2.35, 1.5, 1.5)))
    except NoPathError:
        return
    raise AssertionError("a path leads through a wall")


def planner_in_free_space() -> tuple[PathPlanner, np.ndarray]:
    """Return a planner that knows one free tile, and the kinds (z, y, x) of the tile's voxels."""
    planner = PathPlanner()
    kinds = np.full((SIDE, SIDE, SIDE), FREE, np.uint8)
    planner.update_map(VOXEL_M, SIDE, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    return planner, kinds
