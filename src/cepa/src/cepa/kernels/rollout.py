"""Rolls commands through the UAV's response and judges the paths: admissible, progress, discomfort.

Axes are those of the odometry's frame, with the UAV at the origin. A state (3, 4) holds for x and y position,
velocity, acceleration and integral, and for z position and velocity only. A response (20,) is what
``observer.response_of`` gives. It is one array, because numba takes microseconds to unpack a named tuple.
"""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

from cepa.kernels.surroundings import Cushions, Horizon, Surroundings
from kernel_cache.compiler import njit

POSITION, VELOCITY, ACCELERATION, INTEGRAL = 0, 4, 8, 12
"""Of a response: where the row of each begins, with its factors of velocity, acceleration, integral and
command."""
ACCELERATION_MAX, CHANGE_MAX, CLIMB_SHARE, STEP = 16, 17, 18, 19
AT_REST_M_S, AT_REST_M_S2 = 0.05, 0.2
FULL_ERROR_M_S, LEAST_ERROR_SHARE = 2.0, 0.33
"""From this speed on the response may have its whole stated error; a slower flight has less of it."""
ANGLE_ERROR_RAD = 3e-4
LEAST_M = 1e-300
"""The least distance whose direction is known."""
BY_SIGHT = 2
"""Of ``unseen``: ``sight`` tells how far the UAV may go there."""
DEEPER_M = 0.02
"""What stands nearer than the least distance may come so much nearer, or noise would hold the UAV there."""
State = Tuple[Tuple[float, ...], Tuple[float, ...], Tuple[float, ...]]
"""The numbers of a state (3, 4): four for x, four for y, two for z."""
Law = Tuple[
    Tuple[float, ...],
    Tuple[float, ...],
    Tuple[float, ...],
    Tuple[float, ...],
    Tuple[float, float],
    float,
    float,
]
"""Rows of F and G for position, velocity, acceleration and integral, the limits, climb_share and step_s."""


@njit(cache=True, inline="always")
def _law(response: np.ndarray) -> Law:
    """Return the response as plain numbers, which stay in registers."""
    r = response
    rows = _row(r, POSITION), _row(r, VELOCITY), _row(r, ACCELERATION), _row(r, INTEGRAL)
    return (*rows, (r[ACCELERATION_MAX], r[CHANGE_MAX]), r[CLIMB_SHARE], r[STEP])


@njit(cache=True, inline="always")
def _row(response: np.ndarray, first: int) -> tuple[float, float, float, float]:
    return response[first], response[first + 1], response[first + 2], response[first + 3]


@njit(cache=True, inline="always")
def _of_array(state: np.ndarray) -> State:
    x, y, z = state[0], state[1], state[2]
    return (x[0], x[1], x[2], x[3]), (y[0], y[1], y[2], y[3]), (z[0], z[1])


@njit(cache=True, inline="always")
def _advance(state: State, law: Law, ux: float, uy: float, uz: float) -> State:
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
    law, now_state = _law(response), _of_array(state)
    step_s = law[-1]
    k = first
    for step in range(math.floor((to_s - from_s) / step_s + 0.5)):
        t = from_s + (step + 0.5) * step_s
        while k + 1 < last and commands[(k + 1) % n, 0] <= t:
            k += 1
        now = k % n
        holds = 1.0 if k < last and commands[now, 0] <= t < commands[now, 1] else 0.0
        ux, uy, uz = commands[now, 2], commands[now, 3], commands[now, 4]
        now_state = _advance(now_state, law, holds * ux, holds * uy, holds * uz)
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
    way: np.ndarray,
    later: np.ndarray,
) -> int:
    """Advance ``state`` as ``fly`` does to ``told_s``, and correct it by a velocity that was measured then.

    gains (3,): on velocity, acceleration and integral. The position starts again at 0. Fill ``way`` (3,), m,
    from there to where the UAV is at ``scan_s``, and the state ``later`` (3, 4) at ``later_s``. Its position
    counts from ``scan_s``. Return the first command that still counts.
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
    way[:] = later[:, 0]
    later[:] = state
    fly(later, commands, first, last, told_s, later_s, response)
    later[:, 0] -= way
    return first


@njit(cache=True)
def roll(start: np.ndarray, command: np.ndarray, response: np.ndarray, flown: int, path: np.ndarray) -> int:
    """Fly ``command`` (3,) for ``flown`` steps, then brake; fill ``path`` (n, 3), m; return its length."""
    law, state = _law(response), _of_array(start)
    ux, uy, uz = command
    for k in range(path.shape[0]):
        if k == flown:
            ux = uy = uz = 0.0
        state = _advance(state, law, ux, uy, uz)
        if k >= flown and _is_at_rest(state):
            return k
        path[k, 0], path[k, 1], path[k, 2] = state[0][0], state[1][0], state[2][0]
    return path.shape[0]


@njit(cache=True, inline="always")
def _is_at_rest(state: State) -> bool:
    (_, vx, ax, _), (_, vy, ay, _), (_, vz) = state
    return vx**2 + vy**2 + vz**2 < AT_REST_M_S**2 and ax**2 + ay**2 < AT_REST_M_S2**2


@njit(cache=True, inline="always")
def _bilinear(grid: np.ndarray, layer: int, cell: float, x: float, y: float, outside: float) -> float:
    half = 0.5 * (grid.shape[1] - 1)
    column, row = x / cell + half, y / cell + half
    j, i = math.floor(column), math.floor(row)
    if i < 0 or j < 0 or i >= grid.shape[1] - 1 or j >= grid.shape[1] - 1:
        return outside
    s, t = column - j, row - i
    return (1.0 - t) * ((1.0 - s) * grid[layer, i, j] + s * grid[layer, i, j + 1]) + t * (
        (1.0 - s) * grid[layer, i + 1, j] + s * grid[layer, i + 1, j + 1]
    )


@njit(cache=True, inline="always")
def _layer(count: int, layer_m: float, z: float) -> int:
    """Return the layer at height z, or -1 beyond the layers; a single layer has no height."""
    if count == 1:
        return 0
    layer = math.floor(z / layer_m + 0.5) + count // 2
    return layer if 0 <= layer < count else -1


@njit(cache=True, inline="always")
def _clearance(distance: np.ndarray, cell_m: float, layer_m: float, far: float, state: State) -> float:
    """Return the distance to the nearest of what stands, m."""
    layer = _layer(distance.shape[0], layer_m, state[2][0])
    return _bilinear(distance, layer, cell_m, state[0][0], state[1][0], far) if layer >= 0 else 0.0


@njit(cache=True, inline="always")
def _clearance_of_movers(movers: np.ndarray, state: State, t: float) -> float:
    """Return the distance to the nearest of what moves, m, after t s."""
    x, y = state[0][0], state[1][0]
    d = math.inf
    for k in range(movers.shape[0]):
        dx, dy = x - movers[k, 0] - movers[k, 2] * t, y - movers[k, 1] - movers[k, 3] * t
        d = min(d, math.sqrt(dx * dx + dy * dy) - movers[k, 4] - movers[k, 5] * t)
    return d


@njit(cache=True, inline="always")
def _angle(x: float, y: float) -> float:
    """Return atan2(y, x) within ANGLE_ERROR_RAD, in a third of the time, and without a branch."""
    across, along = abs(y), abs(x)
    a = min(across, along) / max(across, along, LEAST_M)
    a2 = a * a
    angle = a * (1.0 + a2 * (-0.327622764 + a2 * (0.15931422 - 0.0464964749 * a2)))
    angle = 0.5 * math.pi - angle if across > along else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@njit(cache=True, inline="always")
def _past_sight(sight: np.ndarray, x: float, y: float) -> float:
    """Return how far (x, y) is beyond ``sight``, m."""
    bins = np.int32(sight.size)
    b = np.int32(math.floor(_angle(x, y) * bins / (2.0 * math.pi) + 0.5))
    return math.sqrt(x * x + y * y) - sight[np.uint32(b + bins if b < 0 else b)]


@njit(cache=True, inline="always")
def _beyond_sight(
    sight: np.ndarray, unseen: np.ndarray, unseen_cell_m: float, layer_m: float, state: State
) -> float:
    """Return how far the UAV is beyond what has been seen, m; with layers 1 or 0 but for BY_SIGHT."""
    x, y = state[0][0], state[1][0]
    if unseen.shape[0]:
        layer = _layer(unseen.shape[0], layer_m, state[2][0])
        half = unseen.shape[1] // 2
        i = math.floor(y / unseen_cell_m + 0.5) + half
        j = math.floor(x / unseen_cell_m + 0.5) + half
        outside = layer < 0 or min(i, j) < 0 or max(i, j) > 2 * half
        if outside or unseen[layer, i, j] != BY_SIGHT:
            return 1.0 if outside or unseen[layer, i, j] else 0.0
    return _past_sight(sight, x, y)


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
) -> tuple[float, float]:
    """Brake at once; return how near what moves comes, and how much more than it must the UAV keeps, m.

    Fill (n,) ``clearance`` of what stands, and ``beyond``, how far out of sight, m; n = commit + brake.
    """
    distance, cell_m, layer_m, far, sight, unseen, unseen_cell_m, movers, _, _, _, _, _ = around
    law, state = _law(response), _of_array(start)
    nearest, margin = math.inf, math.inf
    tube, share = cushions.tube, error_share(state[0][1], state[1][1], 0.0, 0.0)
    for k in range(horizon.commit + horizon.brake):
        state = _advance(state, law, 0.0, 0.0, 0.0)
        clearance[k] = _clearance(distance, cell_m, layer_m, far, state)
        nearest = min(nearest, _clearance_of_movers(movers, state, (k + 1) * law[-1]))
        beyond[k] = _beyond_sight(sight, unseen, unseen_cell_m, layer_m, state)
        margin = min(margin, clearance[k] - max(cushions.least, cushions.hull + share * tube[k]))
    return nearest, min(margin, nearest - cushions.hull)


@njit(cache=True)
def _leaves_sight(path: np.ndarray, flown: int, sight: np.ndarray, most: np.ndarray) -> bool:
    """Whether one of the ``flown`` first places of ``path`` (2, n), m, is beyond sight.

    ``most`` (n,): it may be so far beyond, m.
    """
    leaves = False
    for k in range(flown):  # without a branch, so that several places go at once
        leaves |= _past_sight(sight, path[0, k], path[1, k]) > max(0.0, most[k])
    return leaves


@njit(cache=True)
def _is_admissible(
    state: State,
    law: Law,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    least: np.ndarray,
    most: np.ndarray,
    nearest: float,
    ux: float,
    uy: float,
    uz: float,
    path: np.ndarray,
) -> bool:
    """Whether flying u for the commit time and then braking keeps its distance and stays within sight.

    A path that is nowhere worse than braking at once (``least``, ``most``) is admissible, too, and what moves
    may come as near as it comes to a UAV that brakes at once (``nearest``). path (2, n) is overwritten.
    """
    distance, cell_m, layer_m, far, sight, unseen, unseen_cell_m, movers, _, _, _, _, _ = around
    tube, share = cushions.tube, error_share(state[0][1], state[1][1], ux, uy)
    step_s, is_layered, flown = law[-1], unseen.shape[0] > 0, 0
    for k in range(horizon.commit + horizon.brake):
        if k == horizon.commit:
            ux = uy = uz = 0.0
        state = _advance(state, law, ux, uy, uz)
        if k >= horizon.commit and _is_at_rest(state):
            break
        keep = max(cushions.least, cushions.hull + share * tube[k])
        if _clearance(distance, cell_m, layer_m, far, state) < min(keep, least[k]):
            return False
        if _clearance_of_movers(movers, state, (k + 1) * step_s) < min(keep, nearest):
            return False
        if is_layered and _beyond_sight(sight, unseen, unseen_cell_m, layer_m, state) > max(0.0, most[k]):
            return False
        path[0, k], path[1, k], flown = state[0][0], state[1][0], k + 1
    return is_layered or not _leaves_sight(path, flown, sight, most)


@njit(cache=True)
def _way_from(way: np.ndarray, cell_m: float, x: float, y: float, direction: np.ndarray) -> float:
    """Return the length of the shortest way out from (x, y), m; outside of the window along ``direction``."""
    half = 0.5 * (way.shape[1] - 1) * cell_m
    farthest = max(abs(x), abs(y))
    scale = min(1.0, 0.999 * half / farthest) if farthest > 0.0 else 1.0
    beyond = (1.0 - scale) * (x * direction[0] + y * direction[1])
    return _bilinear(way, 0, cell_m, scale * x, scale * y, math.inf) - beyond


@njit(cache=True, inline="always")
def _way_slope(
    way: np.ndarray, cell_m: float, x: float, y: float, direction: np.ndarray
) -> tuple[float, float]:
    """Return how much longer the way out is two cells farther along x and along y, m."""
    h = cell_m
    half = 0.5 * (way.shape[1] - 1)
    column, row = x / h + half, y / h + half
    j, i = math.floor(column), math.floor(row)
    if min(i, j) < 1 or max(i, j) > way.shape[1] - 3:
        along_x = _way_from(way, h, x + h, y, direction) - _way_from(way, h, x - h, y, direction)
        return along_x, _way_from(way, h, x, y + h, direction) - _way_from(way, h, x, y - h, direction)
    s, t = column - j, row - i
    low_x = (1.0 - s) * (way[0, i, j + 1] - way[0, i, j - 1]) + s * (way[0, i, j + 2] - way[0, i, j])
    high_x = (1.0 - s) * (way[0, i + 1, j + 1] - way[0, i + 1, j - 1]) + s * (
        way[0, i + 1, j + 2] - way[0, i + 1, j]
    )
    low_y = (1.0 - t) * (way[0, i + 1, j] - way[0, i - 1, j]) + t * (way[0, i + 2, j] - way[0, i, j])
    high_y = (1.0 - t) * (way[0, i + 1, j + 1] - way[0, i - 1, j + 1]) + t * (
        way[0, i + 2, j + 1] - way[0, i, j + 1]
    )
    return (1.0 - t) * low_x + t * high_x, (1.0 - s) * low_y + s * high_y


@njit(cache=True)
def _judge(
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
    """Fly u for the whole horizon; fill ``result`` (5,): see ``judge``."""
    distance, cell_m, layer_m, far, _, _, _, movers, way, way_cell_m, way_x, way_y, slowing = around
    inner, outer = cushions.inner, cushions.outer
    least = min(cushions.least, _clearance(distance, cell_m, layer_m, far, state) - DEEPER_M)
    least_of_movers = min(cushions.least, _clearance_of_movers(movers, state, 0.0) - DEEPER_M)
    discomfort = 0.0
    result[2] = result[4] = 0.0
    speed = math.sqrt(ux * ux + uy * uy)
    for k in range(horizon.cost):
        before = state
        if k >= horizon.hold and way.size and not movers.size:  # the way does not know what moves
            gx, gy = _way_slope(way, way_cell_m, state[0][0] + way_x, state[1][0] + way_y, direction)
            size = math.sqrt(gx * gx + gy * gy)
            if 0.2 * way_cell_m < size < 20.0 * way_cell_m:
                ux, uy = -speed * gx / size, -speed * gy / size
            if slowing < math.inf:
                left = _way_from(way, way_cell_m, state[0][0] + way_x, state[1][0] + way_y, direction)
                share = min(1.0, slowing * left / max(math.sqrt(ux * ux + uy * uy), 1e-9))
                ux, uy = share * ux, share * uy
        state = _advance(state, law, ux, uy, uz)
        d = _clearance(distance, cell_m, layer_m, far, state)
        d_of_movers = _clearance_of_movers(movers, state, (k + 1) * law[-1])
        if d < least or d_of_movers < least_of_movers:
            state = before[0], before[1], state[2]
            result[2 if d < least else 4] = 1.0 - k / horizon.cost
            discomfort += horizon.cost - k
            break
        d = min(d, d_of_movers)
        if d < outer:
            discomfort += ((outer - d) / (outer - inner)) ** 2
    x, y = state[0][0], state[1][0]
    if way.size:
        here = _way_from(way, way_cell_m, way_x, way_y, direction)
        result[0] = here - _way_from(way, way_cell_m, x + way_x, y + way_y, direction)
    else:
        result[0] = x * direction[0] + y * direction[1]
    result[1] = discomfort / horizon.cost
    result[3] = state[2][0]


@njit(cache=True)
def judge(
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

    least, most, nearest: what ``braking`` gives. direction: unit vector of the reference. results: progress
    in m, discomfort, share of the horizon that is lost to a contact with what stands, height at the end in m,
    share that is lost to a contact with what moves.
    """
    world = _law(response), around, horizon, cushions
    state, path = _of_array(start), np.empty((2, horizon.commit + horizon.brake))
    for n in range(commands.shape[0]):
        ux, uy, uz = commands[n]
        admissible[n] = _is_admissible(state, *world, least, most, nearest, ux, uy, uz, path)
        if admissible[n]:
            _judge(state, *world, ux, uy, uz, direction, results[n])


@njit(cache=True)
def is_clear(
    start: np.ndarray,
    command: np.ndarray,
    response: np.ndarray,
    commit: int,
    brake: int,
    cost: int,
    points: np.ndarray,
    ranges: np.ndarray,
    seen: np.ndarray,
    angle_0: float,
    increment: float,
    farthest: float,
    distance: float,
    radius: float,
    stride: int,
) -> bool:
    """Whether nothing is within ``distance`` of flying ``command`` (3,) on, nor of braking after the commit.

    All of both paths must lie in sight of the scan. Every ``stride``-th step is looked at. commit, brake,
    cost: see Horizon. points (n, 2): the ends of the beams, m. ranges, seen (N,): a full turn of beams.
    angle_0: direction of beam 0, rad. increment: rad. farthest: beyond it nothing counts as seen, m. radius:
    of the body.
    """
    law = _law(response)
    path, count = np.empty((cost + commit + brake, 2)), 0
    for brakes in range(2):
        state = _of_array(start)
        ux, uy, uz = command
        for k in range(commit + brake if brakes else cost):
            if brakes and k == commit:
                ux = uy = uz = 0.0
            state = _advance(state, law, ux, uy, uz)
            if k % stride == 0:
                path[count, 0], path[count, 1] = state[0][0], state[1][0]
                count += 1
    scan = ranges, seen, angle_0, increment, farthest
    if not _is_wide_open(path[:count], scan, radius):
        for k in range(count):
            if not _is_in_sight(path[k, 0], path[k, 1], scan, radius):
                return False
    return not _is_near(path[:count], points, distance)


@njit(cache=True)
def _is_near(path: np.ndarray, points: np.ndarray, distance: float) -> bool:
    """Whether any of ``points`` (n, 2) is within ``distance`` of any place of ``path`` (m, 2)."""
    low_x, high_x = path[:, 0].min() - distance, path[:, 0].max() + distance
    low_y, high_y = path[:, 1].min() - distance, path[:, 1].max() + distance
    for j in range(points.shape[0]):
        x, y = points[j, 0], points[j, 1]
        if low_x <= x <= high_x and low_y <= y <= high_y:
            for k in range(path.shape[0]):
                if (x - path[k, 0]) ** 2 + (y - path[k, 1]) ** 2 < distance * distance:
                    return True
    return False


@njit(cache=True)
def _is_wide_open(
    path: np.ndarray, scan: tuple[np.ndarray, np.ndarray, float, float, float], radius: float
) -> bool:
    """Whether all beams around ``path`` (n, 2), m, see farther than its farthest place.

    Then `_is_in_sight` holds for each place. This test takes a fraction of the time, because it looks at each
    beam once. It does not find all paths that are in sight.
    """
    ranges, seen, angle_0, increment, farthest = scan
    error = ANGLE_ERROR_RAD / increment + 3.0  # in beams; 3 for the rounding
    middle, low, high, r_max = math.inf, 0.0, 0.0, 0.0
    for k in range(path.shape[0]):
        x, y = path[k, 0], path[k, 1]
        r = math.sqrt(x * x + y * y)
        r_max = max(r, r_max)
        if r < radius:
            continue
        angle = _angle(x, y)
        if middle == math.inf:
            middle = angle
        offset = angle - middle
        offset -= 2.0 * math.pi * math.floor(offset / (2.0 * math.pi) + 0.5)
        width = (0.5 * math.pi * radius / r) / increment + error  # asin(q) is at most q pi / 2
        low, high = min(low, offset / increment - width), max(high, offset / increment + width)
    if middle == math.inf:
        return True
    if r_max > farthest or high - low > ranges.size - 2:
        return False
    first = math.floor((middle - angle_0) / increment + low) % ranges.size
    end, hidden = first + int(high - low) + 2, False
    for beam in range(first, min(end, ranges.size)):  # without a branch, so that several beams go at once
        hidden |= (not seen[beam]) | (ranges[beam] < r_max)
    for beam in range(end - ranges.size):
        hidden |= (not seen[beam]) | (ranges[beam] < r_max)
    return not hidden


@njit(cache=True)
def _is_in_sight(
    x: float, y: float, scan: tuple[np.ndarray, np.ndarray, float, float, float], radius: float
) -> bool:
    """Whether a disc of ``radius`` m at (x, y) is in front of all that the scan's beams show.

    scan: ranges, seen, angle_0, increment, farthest of ``is_clear``.
    """
    ranges, seen, angle_0, increment, farthest = scan
    r = math.sqrt(x * x + y * y)
    if r < radius:
        return True
    if r > farthest:
        return False
    width = int(math.asin(radius / r) / increment) + 1
    middle = math.floor((math.atan2(y, x) - angle_0) / increment + 0.5)
    first = (middle - width) % ranges.size
    end, hidden = first + 2 * width + 1, False
    for beam in range(first, min(end, ranges.size)):  # without a branch, so that several beams go at once
        hidden |= (not seen[beam]) | (ranges[beam] < r)
    for beam in range(end - ranges.size):
        hidden |= (not seen[beam]) | (ranges[beam] < r)
    return not hidden
