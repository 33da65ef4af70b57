"""Which commands the UAV can fly and then brake, so that it keeps its distance from everything."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.response import FULL_ERROR_M_S, LEAST_ERROR_SHARE
from cepa.dynamic.kernels.clearance import clearance_of_moving, clearance_of_standing
from cepa.dynamic.kernels.free_space import beyond_free_space, leaves_reach
from cepa.dynamic.kernels.response import Law, State, advance, is_at_rest, law_of, state_of
from cepa.dynamic.kernels.surroundings import Braking, Cushions, Horizon, Surroundings
from kernel_cache.compiler import njit


@njit(cache=True)
def error_share(vx: float, vy: float, ux: float, uy: float) -> float:
    """Return the share of the stated error that the response may have in a flight that begins so."""
    fastest2 = max(vx**2 + vy**2, ux * ux + uy * uy)
    return max(LEAST_ERROR_SHARE, min(1.0, math.sqrt(fastest2) / FULL_ERROR_M_S))


@njit(cache=True)
def braking(
    start: np.ndarray,
    response: np.ndarray,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    clearance: np.ndarray,
    beyond: np.ndarray,
) -> tuple[float, int, float]:
    """Brake at once; return `Braking`'s last two, and how much more than it must the UAV keeps, m.

    Fill ``clearance`` and ``beyond``: see `Braking`.
    """
    distance, cell_m, layer_m, far = around.field
    reach, unseen, unseen_cell_m = around.free_space
    movers = around.movers
    law, state = law_of(response), state_of(start)
    nearest, soon, margin = math.inf, math.inf, math.inf
    tube, share = cushions.tube, error_share(state[0][1], state[1][1], 0.0, 0.0)
    for k in range(horizon.commit + horizon.brake):
        state = advance(state, law, 0.0, 0.0, 0.0)
        clearance[k] = clearance_of_standing(distance, cell_m, layer_m, far, state)
        of_movers = clearance_of_moving(movers, state, (k + 1) * law[-1])
        nearest = min(nearest, of_movers)
        if k < horizon.commit:
            soon = nearest
        beyond[k] = beyond_free_space(reach, unseen, unseen_cell_m, layer_m, state)
        margin = min(margin, clearance[k] - max(cushions.least, cushions.hull + share * tube[k]))
    margin = min(margin, nearest - cushions.hull)
    if nearest < cushions.hull:
        return soon, horizon.commit, margin
    return nearest, horizon.commit + horizon.brake, margin


@njit(cache=True)
def is_admissible(
    state: State,
    law: Law,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    at_once: Braking,
    ux: float,
    uy: float,
    uz: float,
    path: np.ndarray,
) -> bool:
    """Whether flying u for the commit time and then braking keeps its distance, within the free space.

    A path that is nowhere worse than braking at once is admissible, too, and what moves may come as near as
    it comes to a UAV that brakes at once. If that one is hit, only the commit time counts, and the flight on
    is judged by its cost. Else the place where the UAV would be hit decides in which directions it may leave.
    u: m/s. path (2, n) is overwritten.
    """
    distance, cell_m, layer_m, far = around.field
    reach, unseen, unseen_cell_m = around.free_space
    movers = around.movers
    clearance, beyond, nearest_mover, judged = at_once
    tube, share = cushions.tube, error_share(state[0][1], state[1][1], ux, uy)
    step_s, is_layered, flown = law[-1], unseen.shape[0] > 0, 0
    for k in range(horizon.commit + horizon.brake):
        if k == horizon.commit:
            ux = uy = uz = 0.0
        state = advance(state, law, ux, uy, uz)
        if k >= horizon.commit and is_at_rest(state):
            break
        keep = max(cushions.least, cushions.hull + share * tube[k])
        if clearance_of_standing(distance, cell_m, layer_m, far, state) < min(keep, clearance[k]):
            return False
        if k < judged and clearance_of_moving(movers, state, (k + 1) * step_s) < min(keep, nearest_mover):
            return False
        if is_layered and beyond_free_space(reach, unseen, unseen_cell_m, layer_m, state) > max(
            0.0, beyond[k]
        ):
            return False
        path[0, k], path[1, k], flown = state[0][0], state[1][0], k + 1
    return is_layered or not leaves_reach(path, flown, reach, beyond)
