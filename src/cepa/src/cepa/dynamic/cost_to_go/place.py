"""The cell that the UAV is in; cells are fixed to the odometry's frame."""

from __future__ import annotations

from typing import NamedTuple

from cepa.dynamic.constants.cost_to_go import WAY_CELL_M


class Place(NamedTuple):
    """A cell among all of the plane, and where in it the UAV is."""

    column: int
    row: int
    offset_x_m: float
    """From the cell's middle."""
    offset_y_m: float


def place_of(x_m: float, y_m: float) -> Place:
    """Return the place of a UAV in the odometry's frame."""
    column, row = round(x_m / WAY_CELL_M), round(y_m / WAY_CELL_M)
    return Place(column, row, x_m - column * WAY_CELL_M, y_m - row * WAY_CELL_M)
