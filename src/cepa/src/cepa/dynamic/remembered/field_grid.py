"""How fine the distance fields are: fine enough for what r_LB leaves beside the body."""

from __future__ import annotations

from typing import NamedTuple

from cepa.dynamic.constants.distance_fields import (
    FIELD_CELL_M,
    FIELD_WINDOW_M,
    FINEST_CELL_M,
    FINEST_LAYER_M,
    LAYER_M,
)
from cepa.parameters import CepaParameters


class FieldGrid(NamedTuple):
    """The grid of a distance field around the UAV."""

    cell_m: float
    side: int
    """Cells along an edge, odd."""
    layer_m: float
    """From layer to layer."""

    @property
    def is_fine(self) -> bool:
        """Whether it is finer than for most UAVs."""
        return self.cell_m < FIELD_CELL_M


def field_grid_of(parameters: CepaParameters) -> FieldGrid:
    """Return the grid for a UAV.

    A grid puts obstacles up to a cell nearer than they are. So a cell may not be greater than what r_LB keeps
    beyond the body, or the grid closes openings that fit. The number of cells stays the same. A search for
    ways (`window_m`) needs the whole window, so with a search the cells stay as they are.
    """
    side = 2 * round(0.5 * FIELD_WINDOW_M / FIELD_CELL_M) + 1
    room_m = parameters.r_lb - parameters.body_radius
    if parameters.window_m > 0.0 or room_m >= FIELD_CELL_M:
        return FieldGrid(FIELD_CELL_M, side, LAYER_M)
    return FieldGrid(max(FINEST_CELL_M, room_m), side, FINEST_LAYER_M)
