"""Obstacles that no lidar sees, as a pane of glass: known by a UAV that does not move where all is free."""

from __future__ import annotations

import math

import numpy as np

from exploration.planning.if_free import clearances_if_free
from exploration.planning.parameters import PlannerParameters
from exploration.planning.space import Space, square_to_faces
from exploration.planning.voxel_grid import OCCUPIED
from flight_limits import KeepOutBox

WIDTH_M = 2.0
"""It may reach so far to each side, if the passage is as wide. What is wider is met once more."""
NEAR_SHARE = 0.5
"""A passage that leaves the UAV less than the clearance and this share of the comfort is one that CEPA may
refuse."""


def unseen_obstacle(
    space: Space, here_m: np.ndarray, next_m: np.ndarray, parameters: PlannerParameters, again: bool
) -> KeepOutBox | None:
    """Return what holds a UAV that comes no nearer to the next place (x, y, z) of its way.

    CEPA keeps it off only what is near. So where the way ahead is free and wide, something stands there that
    nothing tells of. It closes the passage: straight ahead, across it, up to what is known on each side.
    None: something known is near. Or it climbs or sinks, where a lidar does not look.

    again: it was held off here before. The first time, a wall beside the way may be the cause, if its surface
    may be nearer than the clearance.
    """
    way_m, radius_m = np.asarray(next_m, float) - here_m, parameters.radius
    length_m = float(np.linalg.norm(way_m))
    if length_m < radius_m or abs(way_m[2]) > np.hypot(way_m[0], way_m[1]):
        return None
    ahead, voxel_m = way_m / length_m, space.grid.resolution_m
    axis = int(np.abs(ahead[:2]).argmax())
    across = [side for side in range(3) if side != axis]
    width_m = 2.0 * (parameters.clearance_m + NEAR_SHARE * parameters.comfort)
    least = space.need if again else max(space.need, square_to_faces(parameters.clearance_m / voxel_m))
    squares = clearances_if_free(space, math.isqrt(least) + 1)
    for along_m in np.arange(0.0, 2.0 * radius_m, 0.5 * voxel_m):
        place_m = here_m + along_m * ahead
        voxel = space.grid.index_of(place_m)
        if voxel is None or squares[voxel] < least:
            return None
        if any(sum(_free_m(space, place_m, side)) - voxel_m < width_m for side in across):
            return None
    # Half a voxel nearer, so that no way leads as near again. The UAV's own voxel stays free.
    sign = int(np.sign(ahead[axis]))
    touched = math.floor((here_m[axis] + sign * (radius_m - 0.5 * voxel_m)) / voxel_m)
    layer = sign * max(sign * touched, sign * math.floor(here_m[axis] / voxel_m) + 1) + 0.5
    met_m = here_m + (layer * voxel_m - here_m[axis]) / ahead[axis] * ahead
    low_m, high_m = met_m.copy(), met_m.copy()
    low_m[axis] -= 0.25 * voxel_m
    high_m[axis] += 0.25 * voxel_m
    for side in across:
        below_m, above_m = _free_m(space, met_m, side)
        low_m[side] -= below_m
        high_m[side] += above_m
    (x0, y0, z0), (x1, y1, z1) = low_m.tolist(), high_m.tolist()
    where = ", ".join(f"{v:.1f}" for v in met_m)
    return KeepOutBox(
        (x0, y0, z0), (x1, y1, z1), f"at ({where}), where something that no beam shows held the UAV"
    )


def _free_m(space: Space, place_m: np.ndarray, side: int) -> tuple[float, float]:
    """Return how far nothing occupied is from a place along an axis, m, down and up, `WIDTH_M` at most.

    Both count the place's own voxel.
    """
    voxel = space.grid.index_of(place_m)
    if voxel is None:
        return 0.0, 0.0
    line = space.grid.kinds[tuple(np.s_[:] if k == 2 - side else v for k, v in enumerate(voxel))] != OCCUPIED
    at, most = voxel[2 - side], math.ceil(WIDTH_M / space.grid.resolution_m)
    ways = (line[: at + 1][::-1][:most], line[at:][:most])
    down, up = (int(np.argmin(np.append(way, False))) * space.grid.resolution_m for way in ways)
    return down, up
