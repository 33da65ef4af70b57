"""Rolls commands through the UAV's response: which are admissible, and what flying them brings."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.choice import DEEPER_M
from cepa.dynamic.constants.cost_to_go import WAY_SLOPE_LEAST, WAY_SLOPE_MOST
from cepa.dynamic.kernels.admissible import is_admissible
from cepa.dynamic.kernels.clearance import clearance_of_moving, clearance_of_standing
from cepa.dynamic.kernels.progress import cost_to_go_at, slope_at
from cepa.dynamic.kernels.response import Law, State, advance, law_of, state_of
from cepa.dynamic.kernels.surroundings import Cushions, Horizon, Surroundings
from kernel_cache.compiler import njit

PROGRESS, DISCOMFORT, LOSS, HEIGHT, HIT, OUTCOME_COLUMNS = range(6)
"""Columns of the results."""


@njit(cache=True)
def fly_on(
    state: State,
    law: Law,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    ux: float,
    uy: float,
    uz: float,
    direction: np.ndarray,
    result: np.ndarray,
) -> None:
    """Fly u for the whole horizon; fill ``result`` (5,): see ``roll_out``."""
    distance, cell_m, layer_m, far = around.field
    movers = around.movers
    way, way_cell_m, way_x, way_y, slowing = around.cost_to_go
    inner, outer = cushions.inner, cushions.outer
    least = min(cushions.least, clearance_of_standing(distance, cell_m, layer_m, far, state) - DEEPER_M)
    least_of_movers = min(cushions.least, clearance_of_moving(movers, state, 0.0) - DEEPER_M)
    discomfort = 0.0
    result[LOSS] = result[HIT] = 0.0
    speed = math.sqrt(ux * ux + uy * uy)
    for k in range(horizon.cost):
        before = state
        if k >= horizon.hold and way.size and not movers.size:  # the way does not know what moves
            gx, gy = slope_at(way, way_cell_m, state[0][0] + way_x, state[1][0] + way_y, direction)
            size = math.sqrt(gx * gx + gy * gy)
            if WAY_SLOPE_LEAST * way_cell_m < size < WAY_SLOPE_MOST * way_cell_m:
                ux, uy = -speed * gx / size, -speed * gy / size
            if slowing < math.inf:
                left = cost_to_go_at(way, way_cell_m, state[0][0] + way_x, state[1][0] + way_y, direction)
                share = min(1.0, slowing * left / max(math.sqrt(ux * ux + uy * uy), 1e-9))
                ux, uy = share * ux, share * uy
        state = advance(state, law, ux, uy, uz)
        d = clearance_of_standing(distance, cell_m, layer_m, far, state)
        d_of_movers = clearance_of_moving(movers, state, (k + 1) * law[-1])
        if d < least or d_of_movers < least_of_movers:
            state = before[0], before[1], state[2]
            result[LOSS if d < least else HIT] = 1.0 - k / horizon.cost
            discomfort += horizon.cost - k
            break
        d = min(d, d_of_movers)
        if d < outer:
            discomfort += ((outer - d) / (outer - inner)) ** 2
    x, y = state[0][0], state[1][0]
    if way.size:
        here = cost_to_go_at(way, way_cell_m, way_x, way_y, direction)
        result[PROGRESS] = here - cost_to_go_at(way, way_cell_m, x + way_x, y + way_y, direction)
    else:
        result[PROGRESS] = x * direction[0] + y * direction[1]
    result[DISCOMFORT] = discomfort / horizon.cost
    result[HEIGHT] = state[2][0]


@njit(cache=True)
def roll_out(
    start: np.ndarray,
    commands: np.ndarray,
    response: np.ndarray,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    least: np.ndarray,
    most: np.ndarray,
    nearest: float,
    direction: np.ndarray,
    admissible: np.ndarray,
    results: np.ndarray,
) -> None:
    """Judge every command (n, 3) in m/s: fill ``admissible`` (n,) and, where it is, ``results`` (n, 5).

    least, most, nearest: what ``braking`` gives. direction: unit vector of the reference. results: PROGRESS,
    m; DISCOMFORT; LOSS, share of the horizon that is lost to a contact with what stands; HEIGHT at the end,
    m; HIT, share that is lost to a contact with what moves.
    """
    world = law_of(response), around, horizon, cushions
    state, path = state_of(start), np.empty((2, horizon.commit + horizon.brake))
    for n in range(commands.shape[0]):
        ux, uy, uz = commands[n]
        admissible[n] = is_admissible(state, *world, least, most, nearest, ux, uy, uz, path)
        if admissible[n]:
            fly_on(state, *world, ux, uy, uz, direction, results[n])
