"""How a UAV follows velocity commands: one step of the response, and flights of many steps.

Axes are those of the odometry's frame, with the UAV at the origin. A state (3, 4) holds for x and y position,
velocity, acceleration and integral, and for z position and velocity only. A response (20,) is what
``observer.response_of`` gives. It is one array, because numba takes microseconds to unpack a named tuple.
"""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.response import AT_REST_M_S, AT_REST_M_S2
from kernel_cache.compiler import njit

POSITION, VELOCITY, ACCELERATION, INTEGRAL = 0, 4, 8, 12
"""Of a response: where the row of each begins, with its factors of velocity, acceleration, integral and
command."""
ACCELERATION_MAX, CHANGE_MAX, CLIMB_SHARE, STEP = 16, 17, 18, 19
State = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
"""The numbers of a state (3, 4): four for x, four for y, two for z."""
Law = tuple[
    tuple[float, ...],
    tuple[float, ...],
    tuple[float, ...],
    tuple[float, ...],
    tuple[float, float],
    float,
    float,
]
"""Rows of F and G for position, velocity, acceleration and integral, the limits, climb_share and step_s."""


@njit(cache=True, inline="always")
def law_of(response: np.ndarray) -> Law:
    """Return the response as plain numbers, which stay in registers."""
    r = response
    rows = _row(r, POSITION), _row(r, VELOCITY), _row(r, ACCELERATION), _row(r, INTEGRAL)
    return (*rows, (r[ACCELERATION_MAX], r[CHANGE_MAX]), r[CLIMB_SHARE], r[STEP])


@njit(cache=True, inline="always")
def _row(response: np.ndarray, first: int) -> tuple[float, float, float, float]:
    return response[first], response[first + 1], response[first + 2], response[first + 3]


@njit(cache=True, inline="always")
def state_of(state: np.ndarray) -> State:
    """Return a state (3, 4) as plain numbers."""
    x, y, z = state[0], state[1], state[2]
    return (x[0], x[1], x[2], x[3]), (y[0], y[1], y[2], y[3]), (z[0], z[1])


@njit(cache=True, inline="always")
def advance(state: State, law: Law, ux: float, uy: float, uz: float) -> State:
    """Return the state one step later."""
    (x, vx, ax, ix), (y, vy, ay, iy), (z, vz) = state
    p, v, a, i, (most, most_change), climb_share, step = law
    new_x = a[0] * vx + a[1] * ax + a[2] * ix + a[3] * ux
    new_y = a[0] * vy + a[1] * ay + a[2] * iy + a[3] * uy
    change2 = (new_x - ax) ** 2 + (new_y - ay) ** 2
    if change2 <= most_change**2 and new_x**2 + new_y**2 <= most**2:
        x += p[0] * vx + p[1] * ax + p[2] * ix + p[3] * ux
        y += p[0] * vy + p[1] * ay + p[2] * iy + p[3] * uy
        new_vx = v[0] * vx + v[1] * ax + v[2] * ix + v[3] * ux
        new_vy = v[0] * vy + v[1] * ay + v[2] * iy + v[3] * uy
    else:
        share = min(1.0, most_change / max(math.sqrt(change2), 1e-9))
        new_x, new_y = ax + share * (new_x - ax), ay + share * (new_y - ay)
        share = min(1.0, most / max(math.sqrt(new_x**2 + new_y**2), 1e-9))
        new_x, new_y = share * new_x, share * new_y
        x += step * (vx + step * (2.0 * ax + new_x) / 6.0)
        y += step * (vy + step * (2.0 * ay + new_y) / 6.0)
        new_vx = vx + 0.5 * step * (ax + new_x)
        new_vy = vy + 0.5 * step * (ay + new_y)
    new_ix = i[0] * vx + i[1] * ax + i[2] * ix + i[3] * ux
    new_iy = i[0] * vy + i[1] * ay + i[2] * iy + i[3] * uy
    new_z = z + step * vz, vz + climb_share * (uz - vz)
    return (x, new_vx, new_x, new_ix), (y, new_vy, new_y, new_iy), new_z


@njit(cache=True, inline="always")
def is_at_rest(state: State) -> bool:
    """Whether the UAV stands, and will not set off by itself."""
    (_, vx, ax, _), (_, vy, ay, _), (_, vz) = state
    return vx**2 + vy**2 + vz**2 < AT_REST_M_S**2 and ax**2 + ay**2 < AT_REST_M_S2**2


@njit(cache=True)
def fly(
    state: np.ndarray,
    commands: np.ndarray,
    first: int,
    last: int,
    from_s: float,
    to_s: float,
    response: np.ndarray,
) -> None:
    """Advance ``state`` (3, 4) from one time to another under the commands that were given.

    commands (n, 5): ring of when each begins and is braked, s, and its velocity, m/s; ``first`` to ``last``
    count, modulo n. Each holds until the next one begins, or it is braked.
    """
    n = commands.shape[0]
    law, now_state = law_of(response), state_of(state)
    step_s = law[-1]
    k = first
    for step in range(math.floor((to_s - from_s) / step_s + 0.5)):
        t = from_s + (step + 0.5) * step_s
        while k + 1 < last and commands[(k + 1) % n, 0] <= t:
            k += 1
        now = k % n
        holds = 1.0 if k < last and commands[now, 0] <= t < commands[now, 1] else 0.0
        ux, uy, uz = commands[now, 2], commands[now, 3], commands[now, 4]
        now_state = advance(now_state, law, holds * ux, holds * uy, holds * uz)
    along_x, along_y, along_z = now_state
    for column in range(4):
        state[0, column], state[1, column] = along_x[column], along_y[column]
    state[2, 0], state[2, 1] = along_z


@njit(cache=True)
def observe(
    state: np.ndarray,
    vx: float,
    vy: float,
    vz: float,
    gains: np.ndarray,
    commands: np.ndarray,
    first: int,
    last: int,
    from_s: float,
    told_s: float,
    scan_s: float,
    later_s: float,
    response: np.ndarray,
    moved: np.ndarray,
    later: np.ndarray,
) -> int:
    """Advance ``state`` as ``fly`` does to ``told_s``, and correct it by a velocity that was measured then.

    gains (3,): on velocity, acceleration and integral. The position starts again at 0. Fill ``moved`` (3,),
    m, from there to where the UAV is at ``scan_s``, and the state ``later`` (3, 4) at ``later_s``. Its
    position counts from ``scan_s``. Return the first command that still counts. The arguments are loose,
    because numba takes microseconds to unpack a named tuple, and this runs at every scan.
    """
    if told_s > from_s:
        fly(state, commands, first, last, from_s, told_s, response)
        for axis, velocity in enumerate((vx, vy)):
            innovation = velocity - state[axis, 1]
            for k in range(3):
                state[axis, 1 + k] += innovation * gains[k]
        state[:, 0] = 0.0
        state[2, 1] = vz
    while first + 1 < last and commands[(first + 1) % commands.shape[0], 0] <= told_s:
        first += 1
    later[:] = state
    fly(later, commands, first, last, told_s, scan_s, response)
    moved[:] = later[:, 0]
    later[:] = state
    fly(later, commands, first, last, told_s, later_s, response)
    later[:, 0] -= moved
    return first


@njit(cache=True)
def roll(start: np.ndarray, command: np.ndarray, response: np.ndarray, flown: int, path: np.ndarray) -> int:
    """Fly ``command`` (3,) for ``flown`` steps, then brake; fill ``path`` (n, 3), m; return its length."""
    law, state = law_of(response), state_of(start)
    ux, uy, uz = command
    for k in range(path.shape[0]):
        if k == flown:
            ux = uy = uz = 0.0
        state = advance(state, law, ux, uy, uz)
        if k >= flown and is_at_rest(state):
            return k
        path[k, 0], path[k, 1], path[k, 2] = state[0][0], state[1][0], state[2][0]
    return path.shape[0]
