"""How far a UAV that stands may rise, by what the map shows above it."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.voxel_grid import OCCUPIED, VoxelGrid, placed

BODY_M = 0.3
"""What is higher over the UAV's origin is above it; what is lower is beside it, and stays so."""
STEP_M = 0.05


def room_above_m(
    grid: VoxelGrid,
    place_m: np.ndarray,
    rise_max_m: float,
    radius_m: float,
    clearance_m: float,
    drift_m: float,
) -> float:
    """Return how far a UAV may rise straight up, at most `rise_max_m`; see `rise_m`.

    What is unknown does not count: nothing is known yet above a first take-off.

    Args:
        grid: the map.
        place_m: (3,) x, y, z of the UAV, which stands.
        rise_max_m: how far it is to rise.
        radius_m: of the UAV.
        clearance_m: that its centre keeps from the centres of occupied voxels above it.
        drift_m: so far to the side wind may carry it meanwhile.
    """
    reach_m = clearance_m + drift_m
    away_m, above_m = _occupied(grid, place_m, rise_max_m + reach_m, reach_m)
    return rise_m(away_m, above_m, rise_max_m, radius_m, clearance_m, drift_m)


def rise_m(
    away_m: np.ndarray,
    above_m: np.ndarray,
    rise_max_m: float,
    radius_m: float,
    clearance_m: float,
    drift_m: float = 0.0,
) -> float:
    """Return how far a UAV may rise among points, at most `rise_max_m`.

    Beside a wall it keeps what it has there, but never less than its radius.

    Args:
        away_m: (n,) how far points are to the side.
        above_m: (n,) how far they are above the UAV's origin.
        rise_max_m: how far it is to rise.
        radius_m: of the UAV.
        clearance_m: that its centre keeps from what is above it.
        drift_m: so far to the side wind may carry it meanwhile.
    """
    is_above = above_m > BODY_M
    beside_m = away_m[~is_above].min(initial=math.inf)
    kept_m = min(max(beside_m, radius_m), clearance_m + drift_m)
    clearance_m = min(kept_m, clearance_m)
    away_m, above_m = np.maximum(away_m[is_above] - (kept_m - clearance_m), 0.0), above_m[is_above]
    for risen_m in np.arange(STEP_M, rise_max_m + STEP_M, STEP_M):
        if np.hypot(away_m, above_m - risen_m).min(initial=math.inf) < clearance_m - 1e-9:
            return float(risen_m - STEP_M)
    return rise_max_m


def _occupied(
    grid: VoxelGrid, place_m: np.ndarray, reach_up_m: float, reach_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far to the side (n,) and up (n,) occupied voxels are that are no lower than a place."""
    size = grid.resolution_m
    reaches_m = np.array([(-reach_m, -reach_m, 0.0), (reach_m, reach_m, reach_up_m)])
    low, high = np.floor((place_m + reaches_m) / size).astype(np.int64) - grid.corner + ((0, 0, 0), (1, 1, 1))
    low, high = np.clip(low, 0, grid.shape_xyz), np.clip(high, 0, grid.shape_xyz)
    part = grid.kinds[placed(low, tuple((high - low)[::-1]))]
    centres_m = grid.centres_m(np.argwhere(part == OCCUPIED) + low[::-1])
    dx, dy, dz = (centres_m - place_m).T
    away_m = np.hypot(dx, dy)
    is_near = (away_m <= reach_m) & (dz >= 0.0)
    return away_m[is_near], dz[is_near]
