"""What one plan may use: clearances with all that is closed, and what a voxel's length costs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from exploration.planning.closures import Closure
from exploration.planning.kernels.pulling import leg_costs
from exploration.planning.parameters import PlannerParameters
from exploration.planning.voxel_grid import VoxelGrid
from flight_limits import Limits

LEAST_NEED = 2
"""Squared voxels. With less, a diagonal step could pass between two blocked voxels."""

TOO_NEAR = 5.0
"""A length on which a surface may be nearer than the clearance seems so many times longer. So a way leads
there only through a narrow opening, and away from where the UAV is too near."""


@dataclass(frozen=True)
class Space:
    """Arguments of the kernels, and what they come from.

    Attributes:
        grid: the map. limits: as given. closed: what is closed.
        squares: (d, h, w) squared clearances, voxels; 0: blocked, closed, far, or centred above the ceiling.
        need: squared clearance that a path keeps. factors: (k,) cost of a length, by squared clearance.
        corner: (3,) x, y, z of the squares' first voxel. The grid's own may change when it grows.
        far: (d, h, w) what is too far from all that tells the lidar its place; None: nothing is.
    """

    grid: VoxelGrid
    limits: Limits
    closed: Sequence[Closure]
    squares: np.ndarray
    need: int
    factors: np.ndarray
    corner: np.ndarray
    far: np.ndarray | None = None

    @classmethod
    def of(
        cls,
        grid: VoxelGrid,
        squares: np.ndarray,
        parameters: PlannerParameters,
        limits: Limits,
        closed: Sequence[Closure],
        height_m: float,
        far: np.ndarray | None = None,
    ) -> Space:
        """Return the space of a UAV at a height; one above the ceiling may stay there, but not climb."""
        if far is not None:
            squares = np.where(far, np.uint16(0), squares)
        elif closed or math.isfinite(limits.ceiling_m):
            squares = squares.copy()
        if math.isfinite(limits.ceiling_m):
            layer = math.floor(limits.ceiling_m / grid.resolution_m - 0.5)
            highest = max(layer, math.floor(height_m / grid.resolution_m)) - int(grid.corner[2])
            squares[max(highest + 1, 0) :] = 0
        for closure in closed:
            _close(squares, grid, closure)
        need = max(math.ceil((parameters.clearance_m / grid.resolution_m) ** 2 - 1e-9), LEAST_NEED)
        factors = _factors(parameters, grid.resolution_m)
        factors[: square_to_faces(parameters.clearance_m / grid.resolution_m)] *= TOO_NEAR
        return cls(grid, limits, closed, squares, need, factors, grid.corner, far)

    @property
    def is_even(self) -> bool:
        """Whether, on a straight edge between two voxels that are not blocked, each clearance is the map's.

        Balls that are closed and what is far may lie between. A ceiling lies above both ends.
        """
        return self.far is None and not self.closed

    @property
    def clearance_m(self) -> float:
        """Least distance that a path keeps, in whole voxels' squares."""
        return math.sqrt(self.need) * self.grid.resolution_m

    def inner(self, place_m: np.ndarray) -> np.ndarray:
        """Return a place or places (..., 3), x, y, z, as z, y, x in voxels from the grid's corner."""
        return (np.asarray(place_m) / self.grid.resolution_m - self.corner)[..., ::-1].copy()

    def outer(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 3), z, y, x in voxels, as x, y, z in the map's frame, m."""
        return (points[:, ::-1] + self.corner) * self.grid.resolution_m

    def is_clear(self, begin_m: np.ndarray, end_m: np.ndarray) -> bool:
        """Return whether a straight leg between two places (x, y, z) keeps what a plan promises."""
        return math.isfinite(self.cost_m(begin_m, end_m))

    def cost_m(self, begin_m: np.ndarray, end_m: np.ndarray) -> float:
        """Return how long a straight leg seems, m: longer without comfort, infinite if it is not clear."""
        return float(self._costs_m(np.array(begin_m, float)[None], np.array(end_m, float)[None])[0])

    def _costs_m(self, begins_m: np.ndarray, ends_m: np.ndarray) -> np.ndarray:
        """Return `cost_m` (n,) of legs between places (n, 3)."""
        given = self.squares, self.need, self.factors, self.inner(begins_m), self.inner(ends_m)
        return leg_costs(*given) * self.grid.resolution_m

    def cost_whatever_climb_m(self, begin_m: np.ndarray, end_m: np.ndarray) -> np.ndarray:
        """Return legs' costs (...); infinite also if a UAV that is early at a leg's end's height has no room.

        Up and down it flies on when CEPA slows it down on the level. begin_m, end_m: (..., 3), one or many.
        """
        begins_m, ends_m = (np.asarray(each, float).reshape(-1, 3) for each in (begin_m, end_m))
        above_m = np.column_stack((begins_m[:, :2], ends_m[:, 2]))
        up, on = self._costs_m(begins_m, above_m), self._costs_m(above_m, ends_m)
        costs_m = np.where(np.isfinite(up + on), self._costs_m(begins_m, ends_m), np.inf)
        return costs_m.reshape(np.shape(begin_m)[:-1])


def square_to_faces(clearance: float) -> int:
    """Return from which squared distance of centres on the nearest point of a voxel is that far away too.

    All in voxels. Of a voxel this many beside, along each axis, the near face is half a voxel nearer.
    """
    axis = np.arange(math.ceil(clearance) + 2)
    faces, centres = np.maximum(axis - 0.5, 0.0) ** 2, axis**2
    to_faces, squares = (each[:, None, None] + each[:, None] + each for each in (faces, centres))
    return 1 + int(squares[to_faces < clearance**2 - 1e-9].max())


def _factors(parameters: PlannerParameters, resolution_m: float) -> np.ndarray:
    reach_m = parameters.clearance_m + parameters.comfort
    squares = np.arange((math.ceil(reach_m / resolution_m) + 1) ** 2 + 1)
    lacking_m = reach_m - np.sqrt(squares) * resolution_m
    share = np.clip(lacking_m / max(parameters.comfort, 1e-9), 0.0, 1.0)
    return 1.0 + parameters.preference * share


def _close(squares: np.ndarray, grid: VoxelGrid, closure: Closure) -> None:
    """Set the squares of all voxels to 0 whose centres are in a ball."""
    if closure.radius_m <= 0.0:
        return
    centre = (np.array(closure.place_m) / grid.resolution_m - grid.corner)[::-1]
    reach = closure.radius_m / grid.resolution_m
    low = np.clip(np.floor(centre - reach).astype(np.int64), 0, squares.shape)
    high = np.clip(np.ceil(centre + reach).astype(np.int64) + 1, 0, squares.shape)
    axes = [(np.arange(a, b) + 0.5 - c) ** 2 for a, b, c in zip(low, high, centre)]
    far = axes[0][:, None, None] + axes[1][:, None] + axes[2]
    part = squares[tuple(map(slice, low.tolist(), high.tolist()))]
    part[far <= reach**2] = 0
