"""What views would reveal of the unknown: their information gain by volume.

Beams are cast through the unknown, as Bircher et al. count it (Receding horizon next-best-view, 2016). Here
they also end where walls and floors that are known in part would go on.
"""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.kernels.gates import mark_gates
from exploration.next_view.kernels.revealed import count_unknown, mark_walls, revealed
from exploration.next_view.views.no_gain import CellsWithoutGain
from exploration.planning.space import Space
from exploration.planning.voxel_grid import FREE, OCCUPIED, UNKNOWN

CELL_M = 0.4
"""Unknown voxels in a cube of this side count together."""
GOES_ON_M = 1.5
"""Walls and floors are taken to go on so far beyond what is known of them."""
INTO_M = 2.0
"""A beam is taken to go on so far in the unknown."""
EDGE_RAD = math.radians(2.0)
"""So much within the outermost beams a view surely shows what is there: between two rings of a Puck."""
AROUND, RINGS = 72, 5
"""Beams of a view: around, and above each other."""
ROUGHLY = 3
"""For a first look, every so many beams around."""


class Prospect:
    """What is unknown in a map, and what beams from a place would reveal of it.

    Args:
        space: with the map. elevations_rad: of the lowest and the highest beam.
        reaches_m: nearest and farthest distance that the lidar sees. no_gain: cells that count no more.
    """

    def __init__(
        self,
        space: Space,
        elevations_rad: tuple[float, float],
        reaches_m: tuple[float, float],
        no_gain: CellsWithoutGain,
    ) -> None:
        grid, self._no_gain = space.grid, no_gain
        self._voxel_m = grid.resolution_m
        self._side = max(1, round(CELL_M / self._voxel_m))
        self._pad = math.ceil(INTO_M / self._voxel_m)
        kinds = np.where(grid.is_assumed_free & (grid.kinds == UNKNOWN), FREE, grid.kinds)
        self._kinds = np.pad(kinds, self._pad)
        self._is_wall = self._walls()
        is_gate = np.zeros(self._kinds.shape, bool)
        mark_gates(self._kinds, self._is_wall, is_gate)
        self._gates = np.argwhere(is_gate)
        first = grid.corner[::-1] - self._pad
        self._first_cell = np.floor_divide(first, self._side)
        self._offset = first - self._first_cell * self._side
        shape = (np.array(self._kinds.shape) + self._offset - 1) // self._side + 1
        self._counts = np.zeros(shape, np.int64)
        count_unknown(self._kinds, self._is_wall, self._side, self._offset, self._counts)
        self._is_without_gain = np.zeros(shape, bool)
        self._leave_out_no_gain()
        self._beams = _beams(elevations_rad)
        up, level = self._beams[:, 0, 0], np.hypot(self._beams[:, 0, 1], self._beams[:, 0, 2])
        self._slopes = float(up[0] / level[0]), float(up[-1] / level[-1])
        near, far = (reach_m / self._voxel_m for reach_m in reaches_m)
        self._reaches = near, far, INTO_M / self._voxel_m

    def _walls(self) -> np.ndarray:
        """Return where walls and floors would go on. Nothing counts above and below all that is known."""
        is_wall = np.zeros(self._kinds.shape, bool)
        mark_walls(self._kinds, round(GOES_ON_M / self._voxel_m), is_wall)
        layers = np.flatnonzero(self._kinds.any(axis=(1, 2)))
        if len(layers):
            is_wall[: layers[0]] = is_wall[layers[-1] + 1 :] = True
        return is_wall

    def _leave_out_no_gain(self) -> None:
        cells = self._no_gain.left() - self._first_cell
        cells = cells[((cells >= 0) & (cells < self._counts.shape)).all(axis=1)]
        is_left = self._no_gain.is_left(cells + self._first_cell, self._counts[tuple(cells.T)])
        self._is_without_gain[tuple(cells[is_left].T)] = True
        self._counts[self._is_without_gain] = 0

    def is_without_gain(self, voxels: np.ndarray) -> np.ndarray:
        """Return (n,) whether voxels (n, 3) of the map are in cells that were looked at without gain."""
        cells = (voxels + self._pad + self._offset) // self._side
        is_without_gain: np.ndarray = self._is_without_gain[tuple(cells.T)]
        return is_without_gain

    @property
    def is_blocked(self) -> np.ndarray:
        """(d, h, w) of the map's voxels: occupied, or where a wall would go on."""
        inside = (slice(self._pad, -self._pad),) * 3
        blocked: np.ndarray = (self._kinds == OCCUPIED)[inside] | self._is_wall[inside]
        return blocked

    def gains_m3(self, places: np.ndarray, views: np.ndarray, roughly: bool = False) -> np.ndarray:
        """Return (v,) what is unknown in the cells that each view would meet.

        places: (n, 3) z, y, x of the map's voxels. views: (n,) the view that each place belongs to, from 0.
        roughly: by fewer beams.
        """
        return self._revealed(places, views, roughly)[0] * self._voxel_m**3

    def note(self, place: np.ndarray, view: float) -> None:
        """The UAV looked from a voxel (z, y, x). What is still unknown there was looked at without gain.

        view: what the view counts.
        """
        _, stamps = self._revealed(place[None], np.zeros(1, np.int64), False)
        cells = np.argwhere((stamps > 0) & (self._counts > 0))
        counts = self._counts[tuple(cells.T)]
        self._no_gain.note(cells + self._first_cell, counts, np.full(len(counts), view))
        self._leave_out_no_gain()

    def _revealed(
        self, places: np.ndarray, views: np.ndarray, roughly: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        stamps = np.zeros(self._counts.shape, np.int32)
        if not len(places):
            return np.zeros(0, np.int64), stamps
        beams = self._beams[::2, ::ROUGHLY] if roughly else self._beams
        gains = revealed(
            self._kinds,
            self._is_wall,
            self._gates,
            self._counts,
            self._side,
            self._offset,
            places + self._pad,
            views,
            np.ascontiguousarray(beams),
            self._slopes,
            self._reaches,
            stamps,
        )
        return gains, stamps


def _beams(elevations_rad: tuple[float, float]) -> np.ndarray:
    """Return (r, a, 3) directions z, y, x of unit length, without the outermost."""
    low, high = elevations_rad
    edge = min(EDGE_RAD, (high - low) / 4)
    elevations, azimuths = np.meshgrid(
        np.linspace(low + edge, high - edge, RINGS),
        np.linspace(0.0, math.tau, AROUND, endpoint=False),
        indexing="ij",
    )
    level = np.cos(elevations)
    return np.stack((np.sin(elevations), level * np.sin(azimuths), level * np.cos(azimuths)), axis=-1)
