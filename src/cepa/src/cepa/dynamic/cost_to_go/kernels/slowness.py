"""What a metre costs in each cell."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.cost_to_go import SLOWER
from kernel_cache.compiler import njit


@njit(cache=True, inline="always")
def extra_slowness(nearness: float) -> float:
    """Return what a metre costs beyond 1. nearness: 0 at the distance r_UB from an obstacle, 1 at r_LB."""
    return nearness + SLOWER * (nearness * nearness)


@njit(cache=True)
def fill_slowness(
    distance: np.ndarray,
    limits: np.ndarray,
    inner: float,
    outer: float,
    column: int,
    row: int,
    stamp: float,
    hold: float,
    states: np.ndarray,
    slowness: np.ndarray,
) -> None:
    """Fill ``slowness`` (n, n) with the cost of a metre: inf where ``distance`` (n, n), m, leaves no room.

    It is 1 at the distance ``outer`` and 2 + SLOWER at ``inner``, m. What has room has a hysteresis.

    limits (3,): a cell closes below the first and opens above the last, m. Between them it stays as it was
    within the last ``hold`` s, and else closes below the middle one. states (m, m, 3): whether each cell of
    the plane was closed, when, and until when it is in any case, at its index modulo m > n. column, row: of
    the middle among these cells.
    """
    n, m = slowness.shape[0], states.shape[0]
    for i in range(n):
        k, h = (row + i - n // 2) % m, (column - n // 2) % m
        for j in range(n):
            d, state = distance[i, j], states[k, h]
            if limits[0] <= d <= limits[2] and stamp - state[1] <= hold:
                is_closed = state[0] > 0.0
            else:
                is_closed = d < limits[1]
            state[0], state[1] = 1.0 if is_closed else 0.0, stamp
            cost = 1.0 + extra_slowness((outer - d) / (outer - inner))
            slowness[i, j] = math.inf if is_closed or stamp < state[2] else cost
            h = h + 1 if h + 1 < m else 0


@njit(cache=True)
def favour(cells: np.ndarray, column: int, row: int, share: float, slowness: np.ndarray) -> None:
    """Lower ``slowness`` (n, n) to ``share`` of it in and around ``cells`` (m, 2: column, row).

    column, row: of the middle among all cells of the plane.
    """
    n = slowness.shape[0]
    marked = np.zeros((n, n), np.bool_)
    for k in range(cells.shape[0]):
        j, i = cells[k, 0] - column + n // 2, cells[k, 1] - row + n // 2
        marked[max(0, i - 1) : max(0, i + 2), max(0, j - 1) : max(0, j + 2)] = True
    for i in range(n):
        for j in range(n):
            if marked[i, j]:
                slowness[i, j] *= share


@njit(cache=True)
def best_layers(
    distance: np.ndarray,
    cell: float,
    extra: np.ndarray,
    closed: float,
    inner: float,
    outer: float,
    way_cell: float,
    offset: np.ndarray,
    slowness: np.ndarray,
) -> None:
    """Fill ``slowness`` (k, k), in cells of ``way_cell``, with the cost of a metre in the best layer.

    distance (layers, n, n), cell: what ``distance_layers`` gives. offset (2,): of the UAV from the middle of
    ``slowness``, m. extra (layers,): what a metre costs more in a layer. A layer nearer than ``closed`` to an
    obstacle is closed (inf); between ``inner`` and ``outer`` a metre costs up to twice as much. Beyond
    the layers all is open.
    """
    side, n = slowness.shape[0], distance.shape[1]
    at = np.empty((2, side), np.int64)
    for axis in range(2):
        for i in range(side):
            node = math.floor(((i - side // 2) * way_cell - offset[axis]) / cell + 0.5) + n // 2
            at[axis, i] = node if 0 <= node < n else -1
    slowness[:] = math.inf
    for layer in range(distance.shape[0]):
        for i in range(side):
            for j in range(side):
                row, column = at[1, i], at[0, j]
                d = distance[layer, row, column] if min(row, column) >= 0 else outer
                if d >= closed:
                    cost = 1.0 + extra[layer] + max(0.0, (outer - d) / (outer - inner))
                    slowness[i, j] = min(slowness[i, j], cost)
