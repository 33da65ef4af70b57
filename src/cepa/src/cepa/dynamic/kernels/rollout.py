"""Rolls commands through the UAV's response: which are admissible, and what flying them brings."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.choice import DEEPER_M, HURRIED_M_S, UNHURRIED_M_S
from cepa.dynamic.constants.cost_to_go import WAY_SLOPE_LEAST, WAY_SLOPE_MOST
from cepa.dynamic.cost_to_go.kernels.slowness import extra_slowness
from cepa.dynamic.kernels.admissible import is_admissible
from cepa.dynamic.kernels.clearance import (
    clearance_as_known,
    clearance_of_moving,
    clearance_of_standing,
)
from cepa.dynamic.kernels.progress import cost_to_go_at, slope_at
from cepa.dynamic.kernels.response import Law, State, advance, law_of, state_of
from cepa.dynamic.kernels.surroundings import Braking, Cushions, Horizon, Surroundings
from kernel_cache.compiler import njit

PROGRESS, DISCOMFORT, LOSS, HEIGHT, HIT, OUTCOME_COLUMNS = range(6)
"""Columns of the outcomes, which `cepa.dynamic.cost` weighs."""


@njit(cache=True, inline="always")
def contact_of_moving(least: float, here: float) -> float:
    """Return how near what moves may come before it counts as a contact, m; ``here``: how near it is.

    If it is too near already, a contact is far nearer, or inside. So of all flights away the fastest is the
    best. Would it be a contact at once, all flights would be as bad, and the UAV would stop.
    """
    if here >= least:
        return least
    return 0.5 * here if here > 0.0 else here - least


@njit(cache=True)
def steps_until_met(
    movers: np.ndarray, state: State, first: int, last: int, step_s: float, least: float
) -> int:
    """Return after how many steps a UAV that stays from step ``first`` on is met; ``last``: never.

    Who flies as far as a wall is met there by what comes. Else no way past it would be as good.
    """
    for k in range(first, last):
        if clearance_of_moving(movers, state, (k + 1) * step_s) < least:
            return k
    return last


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
    outcome: np.ndarray,
) -> None:
    """Fly u, m/s, for the whole horizon; fill ``outcome`` (5,): see ``roll_out``.

    After the first steps (``hold``) it flies along the way out. The first contact ends the flight. At what
    stands, the UAV stays, and what moves may meet it there. A fast climb leaves the layers before the end;
    that alone costs nothing, for `is_admissible` keeps within them.

    The way out counts a metre beside an obstacle as up to three, so what is left of it falls by three for a
    metre that is flown there. What the path's own metres cost beyond 1 is taken off again if they are flown
    fast. Else it would pay to cut a corner close to an obstacle. Who flies slowly keeps what draws it
    through narrow gaps.
    """
    distance, cell_m, layer_m, far = around.field
    movers = around.movers
    length, way_cell_m, offset_x, offset_y, slowing = around.cost_to_go
    inner, outer = cushions.inner, cushions.outer
    least = min(cushions.least, clearance_of_standing(distance, cell_m, layer_m, far, state) - DEEPER_M)
    least_of_movers = contact_of_moving(cushions.least, clearance_of_moving(movers, state, 0.0))
    discomfort = extra_m = 0.0
    outcome[LOSS] = outcome[HIT] = 0.0
    speed = math.sqrt(ux * ux + uy * uy)
    for k in range(horizon.cost):
        before = state
        if k >= horizon.hold and length.size and not movers.size:  # the way does not know what moves
            x, y = state[0][0] + offset_x, state[1][0] + offset_y
            gx, gy = slope_at(length, way_cell_m, x, y, direction)
            size = math.sqrt(gx * gx + gy * gy)
            if WAY_SLOPE_LEAST * way_cell_m < size < WAY_SLOPE_MOST * way_cell_m:
                ux, uy = -speed * gx / size, -speed * gy / size
            if slowing < math.inf:
                left = cost_to_go_at(length, way_cell_m, x, y, direction)
                share = min(1.0, slowing * left / max(math.sqrt(ux * ux + uy * uy), 1e-9))
                ux, uy = share * ux, share * uy
        state = advance(state, law, ux, uy, uz)
        d = clearance_as_known(distance, cell_m, layer_m, far, state)
        d_of_movers = clearance_of_moving(movers, state, (k + 1) * law[-1])
        if d < least or d_of_movers < least_of_movers:
            state = before[0], before[1], state[2]
            outcome[LOSS if d < least else HIT] = 1.0 - k / horizon.cost
            discomfort += horizon.cost - k
            if d < least and movers.size:
                met = steps_until_met(movers, state, k, horizon.cost, law[-1], least_of_movers)
                outcome[HIT] = 1.0 - met / horizon.cost
            break
        if d < outer:
            flown_m = math.hypot(state[0][0] - before[0][0], state[1][0] - before[1][0])
            haste = (flown_m / law[-1] - UNHURRIED_M_S) / (HURRIED_M_S - UNHURRIED_M_S)
            extra_m += min(1.0, max(0.0, haste)) * extra_slowness((outer - d) / (outer - inner)) * flown_m
        d = min(d, d_of_movers)
        if d < outer:
            discomfort += ((outer - d) / (outer - inner)) ** 2
    x, y = state[0][0], state[1][0]
    if length.size:
        here = cost_to_go_at(length, way_cell_m, offset_x, offset_y, direction)
        there = cost_to_go_at(length, way_cell_m, x + offset_x, y + offset_y, direction)
        outcome[PROGRESS] = here - there - extra_m
    else:
        outcome[PROGRESS] = x * direction[0] + y * direction[1]
    outcome[DISCOMFORT] = discomfort / horizon.cost
    outcome[HEIGHT] = state[2][0]


@njit(cache=True)
def roll_out(
    start: np.ndarray,
    commands: np.ndarray,
    response: np.ndarray,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    at_once: Braking,
    direction: np.ndarray,
    admissible: np.ndarray,
    outcomes: np.ndarray,
) -> None:
    """Judge every command (n, 3) in m/s: fill ``admissible`` (n,) and, where it is, ``outcomes`` (n, 5).

    at_once: how the UAV fares that brakes. direction: unit vector of the reference. outcomes: PROGRESS, m,
    see `fly_on`; DISCOMFORT; LOSS, share of the horizon that is lost to a contact with what stands; HEIGHT
    at the end, m; HIT, share that is lost to a contact with what moves.
    """
    world = law_of(response), around, horizon, cushions
    state, path = state_of(start), np.empty((2, horizon.commit + horizon.brake))
    for n in range(commands.shape[0]):
        ux, uy, uz = commands[n]
        admissible[n] = is_admissible(state, *world, at_once, ux, uy, uz, path)
        if admissible[n]:
            fly_on(state, *world, ux, uy, uz, direction, outcomes[n])
