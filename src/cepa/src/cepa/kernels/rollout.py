"""Rolls commands through the UAV's response and judges the paths: admissible, progress, discomfort.

Axes are those of the odometry's frame, with the UAV at the origin. A state (3, 4) holds for x and y position,
velocity, acceleration and integral, and for z position and velocity only.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cepa.kernels.surroundings import Cushions, Horizon, Response, Scan, Surroundings

AT_REST_M_S, AT_REST_M_S2 = 0.05, 0.2
FULL_ERROR_M_S, LEAST_ERROR_SHARE = 2.0, 0.33
"""From this speed on the response may have its whole stated error; a slower flight has less of it."""
ANGLE_ERROR_RAD = 3e-4
DEEPER_M = 0.02
"""What stands nearer than the least distance may come so much nearer, or noise would hold the UAV there."""


@njit(cache=True, inline="always")
def _advance(state: np.ndarray, response: Response, ux: float, uy: float, uz: float) -> None:
    f, g, step = response.f, response.g, response.step_s
    vx, ax, ix = state[0, 1], state[0, 2], state[0, 3]
    vy, ay, iy = state[1, 1], state[1, 2], state[1, 3]
    new_x = f[2, 1] * vx + f[2, 2] * ax + f[2, 3] * ix + g[2] * ux
    new_y = f[2, 1] * vy + f[2, 2] * ay + f[2, 3] * iy + g[2] * uy
    change2 = (new_x - ax) ** 2 + (new_y - ay) ** 2
    most_change = response.jerk_max * step
    if change2 <= most_change**2 and new_x**2 + new_y**2 <= response.acceleration_max**2:
        state[0, 0] += f[0, 1] * vx + f[0, 2] * ax + f[0, 3] * ix + g[0] * ux
        state[1, 0] += f[0, 1] * vy + f[0, 2] * ay + f[0, 3] * iy + g[0] * uy
        state[0, 1] = f[1, 1] * vx + f[1, 2] * ax + f[1, 3] * ix + g[1] * ux
        state[1, 1] = f[1, 1] * vy + f[1, 2] * ay + f[1, 3] * iy + g[1] * uy
    else:
        share = min(1.0, most_change / max(math.sqrt(change2), 1e-9))
        new_x, new_y = ax + share * (new_x - ax), ay + share * (new_y - ay)
        share = min(1.0, response.acceleration_max / max(math.sqrt(new_x**2 + new_y**2), 1e-9))
        new_x, new_y = share * new_x, share * new_y
        state[0, 0] += step * (vx + step * (2.0 * ax + new_x) / 6.0)
        state[1, 0] += step * (vy + step * (2.0 * ay + new_y) / 6.0)
        state[0, 1] = vx + 0.5 * step * (ax + new_x)
        state[1, 1] = vy + 0.5 * step * (ay + new_y)
    state[0, 2], state[1, 2] = new_x, new_y
    state[0, 3] = f[3, 1] * vx + f[3, 2] * ax + f[3, 3] * ix + g[3] * ux
    state[1, 3] = f[3, 1] * vy + f[3, 2] * ay + f[3, 3] * iy + g[3] * uy
    state[2, 0] += step * state[2, 1]
    state[2, 1] += response.climb_gain * (uz - state[2, 1])


@njit(cache=True)
def fly(
    state: np.ndarray,
    commands: np.ndarray,
    first: int,
    last: int,
    from_s: float,
    to_s: float,
    response: Response,
) -> None:
    """Advance ``state`` (3, 4) from one time to another under the commands that were given.

    commands (n, 5): ring of when each begins and is braked, s, and its velocity, m/s; ``first`` to ``last``
    count, modulo n. Each holds until the next one begins, or it is braked.
    """
    n = commands.shape[0]
    k = first
    for step in range(math.floor((to_s - from_s) / response.step_s + 0.5)):
        t = from_s + (step + 0.5) * response.step_s
        while k + 1 < last and commands[(k + 1) % n, 0] <= t:
            k += 1
        now = k % n
        holds = 1.0 if k < last and commands[now, 0] <= t < commands[now, 1] else 0.0
        ux, uy, uz = commands[now, 2], commands[now, 3], commands[now, 4]
        _advance(state, response, holds * ux, holds * uy, holds * uz)


@njit(cache=True)
def roll(start: np.ndarray, command: np.ndarray, response: Response, flown: int, path: np.ndarray) -> int:
    """Fly ``command`` (3,) for ``flown`` steps, then brake; fill ``path`` (n, 3), m; return its length."""
    state = start.copy()
    ux, uy, uz = command
    for k in range(path.shape[0]):
        if k == flown:
            ux = uy = uz = 0.0
        _advance(state, response, ux, uy, uz)
        if k >= flown and _is_at_rest(state):
            return k
        path[k] = state[:, 0]
    return path.shape[0]


@njit(cache=True, inline="always")
def _is_at_rest(state: np.ndarray) -> bool:
    speed2 = state[0, 1] ** 2 + state[1, 1] ** 2 + state[2, 1] ** 2
    return speed2 < AT_REST_M_S**2 and state[0, 2] ** 2 + state[1, 2] ** 2 < AT_REST_M_S2**2


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
def _clearance(distance: np.ndarray, cell_m: float, layer_m: float, far: float, state: np.ndarray) -> float:
    """Return the distance to the nearest of what stands, m."""
    layer = _layer(distance.shape[0], layer_m, state[2, 0])
    return _bilinear(distance, layer, cell_m, state[0, 0], state[1, 0], far) if layer >= 0 else 0.0


@njit(cache=True, inline="always")
def _clearance_of_movers(movers: np.ndarray, state: np.ndarray, t: float) -> float:
    """Return the distance to the nearest of what moves, m, after t s."""
    x, y = state[0, 0], state[1, 0]
    d = math.inf
    for k in range(movers.shape[0]):
        dx, dy = x - movers[k, 0] - movers[k, 2] * t, y - movers[k, 1] - movers[k, 3] * t
        d = min(d, math.sqrt(dx * dx + dy * dy) - movers[k, 4] - movers[k, 5] * t)
    return d


@njit(cache=True, inline="always")
def _angle(x: float, y: float) -> float:
    """Return atan2(y, x) within ANGLE_ERROR_RAD, in a third of the time."""
    across, along = abs(y), abs(x)
    low, high = (across, along) if across < along else (along, across)
    if high == 0.0:
        return 0.0
    a = low / high
    a2 = a * a
    angle = a * (1.0 + a2 * (-0.327622764 + a2 * (0.15931422 - 0.0464964749 * a2)))
    if across > along:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return -angle if y < 0.0 else angle


@njit(cache=True, inline="always")
def _beyond_sight(
    sight: np.ndarray, unseen: np.ndarray, unseen_cell_m: float, layer_m: float, state: np.ndarray
) -> float:
    """Return how far the UAV is beyond what has been seen, m; with layers 1 or 0."""
    x, y = state[0, 0], state[1, 0]
    if unseen.shape[0]:
        layer = _layer(unseen.shape[0], layer_m, state[2, 0])
        half = unseen.shape[1] // 2
        i = math.floor(y / unseen_cell_m + 0.5) + half
        j = math.floor(x / unseen_cell_m + 0.5) + half
        outside = layer < 0 or min(i, j) < 0 or max(i, j) > 2 * half
        return 1.0 if outside or unseen[layer, i, j] else 0.0
    bins = sight.size
    b = math.floor(_angle(x, y) * bins / (2.0 * math.pi) + 0.5)
    return math.sqrt(x * x + y * y) - sight[b + bins if b < 0 else b]


@njit(cache=True)
def braking(
    start: np.ndarray,
    response: Response,
    around: Surroundings,
    horizon: Horizon,
    clearance: np.ndarray,
    beyond: np.ndarray,
) -> float:
    """Brake at once; return how near what moves comes, m.

    Fill (n,) ``clearance`` of what stands, and ``beyond``, how far out of sight, m; n = commit + brake.
    """
    distance, cell_m, layer_m, far, sight, unseen, unseen_cell_m, movers, _, _, _, _ = around
    state = start.copy()
    nearest = math.inf
    for k in range(horizon.commit + horizon.brake):
        _advance(state, response, 0.0, 0.0, 0.0)
        clearance[k] = _clearance(distance, cell_m, layer_m, far, state)
        nearest = min(nearest, _clearance_of_movers(movers, state, (k + 1) * response.step_s))
        beyond[k] = _beyond_sight(sight, unseen, unseen_cell_m, layer_m, state)
    return nearest


@njit(cache=True)
def error_share(state: np.ndarray, ux: float, uy: float) -> float:
    """Return the share of the stated error that the response may have in a flight that begins so."""
    fastest2 = max(state[0, 1] ** 2 + state[1, 1] ** 2, ux * ux + uy * uy)
    return max(LEAST_ERROR_SHARE, min(1.0, math.sqrt(fastest2) / FULL_ERROR_M_S))


@njit(cache=True)
def _is_admissible(
    state: np.ndarray,
    response: Response,
    around: Surroundings,
    horizon: Horizon,
    cushions: Cushions,
    least: np.ndarray,
    most: np.ndarray,
    nearest: float,
    ux: float,
    uy: float,
    uz: float,
) -> bool:
    """Whether flying u for the commit time and then braking keeps its distance and stays within sight.

    A path that is nowhere worse than braking at once (``least``, ``most``) is admissible, too, and what moves
    may come as near as it comes to a UAV that brakes at once (``nearest``).
    """
    distance, cell_m, layer_m, far, sight, unseen, unseen_cell_m, movers, _, _, _, _ = around
    tube, share = cushions.tube, error_share(state, ux, uy)
    for k in range(horizon.commit + horizon.brake):
        if k == horizon.commit:
            ux = uy = uz = 0.0
        _advance(state, response, ux, uy, uz)
        if k >= horizon.commit and _is_at_rest(state):
            break
        keep = max(cushions.least, cushions.hull + share * tube[k])
        if _clearance(distance, cell_m, layer_m, far, state) < min(keep, least[k]):
            return False
        if _clearance_of_movers(movers, state, (k + 1) * response.step_s) < min(keep, nearest):
            return False
        if _beyond_sight(sight, unseen, unseen_cell_m, layer_m, state) > max(0.0, most[k]):
            return False
    return True


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
    state: np.ndarray,
    response: Response,
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
    distance, cell_m, layer_m, far, _, _, _, movers, way, way_cell_m, way_x, way_y = around
    inner, outer = cushions.inner, cushions.outer
    least = min(cushions.least, _clearance(distance, cell_m, layer_m, far, state) - DEEPER_M)
    least_of_movers = min(cushions.least, _clearance_of_movers(movers, state, 0.0) - DEEPER_M)
    discomfort = 0.0
    result[2] = result[4] = 0.0
    speed = math.sqrt(ux * ux + uy * uy)
    for k in range(horizon.cost):
        x, y = state[0, 0], state[1, 0]
        if k >= horizon.hold and way.size and not movers.size:  # the way does not know what moves
            gx, gy = _way_slope(way, way_cell_m, x + way_x, y + way_y, direction)
            size = math.sqrt(gx * gx + gy * gy)
            if 0.2 * way_cell_m < size < 20.0 * way_cell_m:
                ux, uy = -speed * gx / size, -speed * gy / size
        _advance(state, response, ux, uy, uz)
        d = _clearance(distance, cell_m, layer_m, far, state)
        d_of_movers = _clearance_of_movers(movers, state, (k + 1) * response.step_s)
        if d < least or d_of_movers < least_of_movers:
            state[0, 0], state[1, 0] = x, y
            result[2 if d < least else 4] = 1.0 - k / horizon.cost
            discomfort += horizon.cost - k
            break
        d = min(d, d_of_movers)
        if d < outer:
            discomfort += ((outer - d) / (outer - inner)) ** 2
    x, y = state[0, 0], state[1, 0]
    if way.size:
        here = _way_from(way, way_cell_m, way_x, way_y, direction)
        result[0] = here - _way_from(way, way_cell_m, x + way_x, y + way_y, direction)
    else:
        result[0] = x * direction[0] + y * direction[1]
    result[1] = discomfort / horizon.cost
    result[3] = state[2, 0]


@njit(cache=True)
def judge(
    start: np.ndarray,
    commands: np.ndarray,
    response: Response,
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
    world = response, around, horizon, cushions
    state = start.copy()
    for n in range(commands.shape[0]):
        ux, uy, uz = commands[n]
        state[:] = start
        admissible[n] = _is_admissible(state, *world, least, most, nearest, ux, uy, uz)
        if admissible[n]:
            state[:] = start
            _judge(state, *world, ux, uy, uz, direction, results[n])


@njit(cache=True)
def _is_free(x: float, y: float, scan: Scan, distance: float, radius: float) -> bool:
    for j in range(scan.points.shape[0]):
        dx, dy = scan.points[j, 0] - x, scan.points[j, 1] - y
        if dx * dx + dy * dy < distance * distance:
            return False
    r = math.sqrt(x * x + y * y)
    if r < radius:
        return True
    if r > scan.farthest:
        return False
    width = int(math.asin(radius / r) / scan.increment) + 1
    middle = math.floor((math.atan2(y, x) - scan.angle_0) / scan.increment + 0.5)
    ranges, seen = scan.ranges, scan.seen
    beam = (middle - width) % ranges.size
    for _ in range(2 * width + 1):
        if not seen[beam] or ranges[beam] < r:
            return False
        beam = beam + 1 if beam + 1 < ranges.size else 0
    return True


@njit(cache=True)
def is_clear(
    start: np.ndarray,
    command: np.ndarray,
    response: Response,
    horizon: Horizon,
    scan: Scan,
    distance: float,
    radius: float,
    stride: int,
) -> bool:
    """Whether nothing is within ``distance`` of flying ``command`` (3,) on, nor of braking after the commit.

    All of both paths must lie in sight of the scan. Every ``stride``-th step is looked at.
    radius: of the body.
    """
    for brakes in range(2):
        state = start.copy()
        ux, uy, uz = command
        for k in range(horizon.commit + horizon.brake if brakes else horizon.cost):
            if brakes and k == horizon.commit:
                ux = uy = uz = 0.0
            _advance(state, response, ux, uy, uz)
            if k % stride == 0 and not _is_free(state[0, 0], state[1, 0], scan, distance, radius):
                return False
    return True
