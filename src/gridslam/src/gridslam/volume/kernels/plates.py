"""Fits planes to the points of each cell and of those around it, the plane with most points first."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

Triple = tuple[float, float, float]

PLANES = 4
"""Of a cell, at most."""
LEAST_OWN, LEAST_ALL = 1, 6
"""A plane has at least so many points in its cell, and so many with those around it."""
REFITS = (1.0, 1.0, 0.6)
"""Points so near to the plane, in tolerances, count when it is fitted again."""
GRAZING = 0.03
"""A point counts to a plane's front if the sine of its ray's angle with the plane is greater."""
NARROW = 0.1
"""Points that spread less across their longest line, as a part of the cell, are a strip, which faces the
sensor."""
ALIKE, APART = 0.8, 0.6
"""A plane that faces as another one of its cell (cosine), and is nearer to it than this part of the cell, is
noise of the other one."""
FIELDS = 14
"""Of a row: number of the cell; normal; a place on the plane; lowest and highest corner of its points; how
many of them are the cell's own."""


@njit(cache=True, nogil=True)
def principal_axes(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> np.ndarray:
    """Return (7,): the unit axes of least and most spread, and the middle eigenvalue of a covariance."""
    matrix = np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    values, vectors = np.linalg.eigh(matrix)
    axes = np.empty(7)
    axes[:3], axes[3:6], axes[6] = vectors[:, 0], vectors[:, 2], values[1]
    return axes


@njit(cache=True, nogil=True)
def around(
    cells: np.ndarray, begins: np.ndarray, cell: np.ndarray, low: np.ndarray, high: np.ndarray,
    points: np.ndarray, found: np.ndarray,
) -> int:  # fmt: skip
    """Write the numbers of the points in a box around a cell (3,) into found; return how many there are.

    cells: (m, 3) sorted, x first. begins: (m + 1,) of the points of each.
    """
    count = 0
    for dx in range(-1, 2):
        for dy in range(-1, 2):
            x, y, z = cell[0] + dx, cell[1] + dy, cell[2] - 1
            first, last = 0, len(cells)
            while first < last:
                middle = (first + last) // 2
                other = cells[middle]
                if (
                    other[0] < x
                    or (other[0] == x and other[1] < y)
                    or (other[0] == x and other[1] == y and other[2] < z)
                ):
                    first = middle + 1
                else:
                    last = middle
            while first < len(cells) and cells[first, 0] == x and cells[first, 1] == y:
                if cells[first, 2] > z + 2:
                    break
                for k in range(begins[first], begins[first + 1]):
                    p = points[k]
                    if (
                        low[0] <= p[0] <= high[0]
                        and low[1] <= p[1] <= high[1]
                        and low[2] <= p[2] <= high[2]
                        and count < len(found)
                    ):
                        found[count] = k
                        count += 1
                first += 1
    return count


@njit(cache=True, nogil=True)
def triple(values: np.ndarray) -> Triple:
    """Return (3,) values as numbers, with which loops are faster than with arrays."""
    return values[0], values[1], values[2]


@njit(cache=True, nogil=True)
def across(begin: Triple, first: Triple, second: Triple) -> Triple:
    """Return the product of the ways from one point to two others: across both, twice their triangle long."""
    ax, ay, az = first[0] - begin[0], first[1] - begin[1], first[2] - begin[2]
    bx, by, bz = second[0] - begin[0], second[1] - begin[1], second[2] - begin[2]
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True, nogil=True)
def is_on(point: Triple, way: Triple, normal: Triple, place: Triple, off: float) -> bool:
    """Return whether a point is so near to a plane, and was seen from its front. way: to the sensor."""
    if way[0] * normal[0] + way[1] * normal[1] + way[2] * normal[2] <= GRAZING:
        return False
    away = (
        (point[0] - place[0]) * normal[0]
        + (point[1] - place[1]) * normal[1]
        + (point[2] - place[2]) * normal[2]
    )
    return abs(away) <= off


@njit(cache=True, nogil=True)
def refit(
    near: np.ndarray, taken: np.ndarray, points: np.ndarray, ways: np.ndarray, weights: np.ndarray,
    normal: np.ndarray, place: np.ndarray, off: float, narrow: float,
) -> None:  # fmt: skip
    """Move normal and place (3,) to the plane of the points on them; narrow: spread of a strip, m."""
    sums = np.zeros(13)
    first, front, here = points[near[0]], triple(normal), triple(place)
    for k in range(len(near)):
        if taken[k]:
            continue
        n = near[k]
        if is_on(triple(points[n]), triple(ways[n]), front, here, off):
            w = weights[n]
            x, y, z = points[n, 0] - first[0], points[n, 1] - first[1], points[n, 2] - first[2]
            sums[0] += w
            sums[1] += w * x
            sums[2] += w * y
            sums[3] += w * z
            sums[4] += w * x * x
            sums[5] += w * y * y
            sums[6] += w * z * z
            sums[7] += w * x * y
            sums[8] += w * x * z
            sums[9] += w * y * z
            for axis in range(3):
                sums[10 + axis] += w * ways[n, axis]
    if sums[0] <= 0.0:
        return
    x, y, z = sums[1] / sums[0], sums[2] / sums[0], sums[3] / sums[0]
    axes = principal_axes(
        sums[4] / sums[0] - x * x, sums[5] / sums[0] - y * y, sums[6] / sums[0] - z * z,
        sums[7] / sums[0] - x * y, sums[8] / sums[0] - x * z, sums[9] / sums[0] - y * z,
    )  # fmt: skip
    if axes[6] < narrow * narrow:
        way = sums[10:] - (sums[10:] * axes[3:6]).sum() * axes[3:6]
        normal[:] = way / max(math.sqrt((way * way).sum()), 1e-12)
    else:
        sign = 1.0 if (axes[:3] * normal).sum() > 0.0 else -1.0
        normal[:] = sign * axes[:3]
    place[0], place[1], place[2] = first[0] + x, first[1] + y, first[2] + z


@njit(cache=True, nogil=True)
def best_plane(
    near: np.ndarray, taken: np.ndarray, own: np.ndarray, points: np.ndarray, ways: np.ndarray,
    draws: np.ndarray, off: float, normal: np.ndarray, place: np.ndarray,
) -> int:  # fmt: skip
    """Write the drawn plane through three points with most points on it (RANSAC); return how many.

    near: (n,) numbers of points, of which `taken` (n,) are of other planes. own: (k,) places in `near` of the
    cell's own. draws: (h, 3) in 0..1, one row a plane.
    """
    best = 0
    for h in range(len(draws)):
        i = near[own[int(draws[h, 0] * len(own))]]
        j, k = int(draws[h, 1] * len(near)), int(draws[h, 2] * len(near))
        if taken[j] or taken[k]:
            continue
        here = triple(points[i])
        x, y, z = across(here, triple(points[near[j]]), triple(points[near[k]]))
        length = math.sqrt(x * x + y * y + z * z)
        if length < 4.0 * off * off:
            continue
        x, y, z = x / length, y / length, z / length
        sign = -1.0 if x * ways[i, 0] + y * ways[i, 1] + z * ways[i, 2] < 0.0 else 1.0
        count, front = 0, (sign * x, sign * y, sign * z)
        for m in range(len(near)):
            if count + len(near) - m <= best:  # it cannot be better
                break
            other = near[m]
            if not taken[m] and is_on(triple(points[other]), triple(ways[other]), front, here, off):
                count += 1
        if count > best:
            best = count
            normal[0], normal[1], normal[2] = front
            place[:] = points[i]
    return best


@njit(cache=True, nogil=True)
def planes_of_cells(
    cells: np.ndarray, begins: np.ndarray, points: np.ndarray, ways: np.ndarray, weights: np.ndarray,
    draws: np.ndarray, side: float, reach: float, off: float,
) -> np.ndarray:  # fmt: skip
    """Return rows (k, FIELDS) of the planes of all cells.

    Args:
        cells: (m, 3) sorted, x first.
        begins: (m + 1,) of the points of each.
        points: (n, 3), m.
        ways: (n, 3) unit, to the sensor.
        weights: (n,) of the points.
        draws: (h, 3) in 0..1, for the planes that are tried.
        side: of a cell, m.
        reach: so far around the cell points count, m, at most side.
        off: so far from a plane its points are at most, m.
    """
    rows = np.empty((max(16, PLANES * len(cells)), FIELDS))
    total = 0
    found = np.empty(20000, np.int64)
    for c in range(len(cells)):
        low, high = cells[c] * side, (cells[c] + 1.0) * side
        count = around(cells, begins, cells[c], low - reach, high + reach, points, found)
        near = found[:count]
        taken = np.zeros(count, np.bool_)
        first = total
        for _ in range(PLANES):
            own = np.empty(count, np.int64)
            owns = 0
            for k in range(count):
                if not taken[k] and begins[c] <= near[k] < begins[c + 1]:
                    own[owns] = k
                    owns += 1
            if owns < LEAST_OWN:
                break
            normal, place = np.zeros(3), np.zeros(3)
            if best_plane(near, taken, own[:owns], points, ways, draws, off, normal, place) < LEAST_ALL:
                break
            for part in REFITS:
                refit(near, taken, points, ways, weights, normal, place, part * off, NARROW * side)
            rows[total, 7:10], rows[total, 10:13] = np.inf, -np.inf
            mine, whole, front, here = 0, 0, triple(normal), triple(place)
            for k in range(count):
                n = near[k]
                point, way = triple(points[n]), triple(ways[n])
                if taken[k] or not is_on(point, way, front, here, 1.5 * off):
                    continue
                taken[k] = True
                if not is_on(point, way, front, here, off):
                    continue
                whole += 1
                mine += begins[c] <= n < begins[c + 1]
                for axis in range(3):
                    rows[total, 7 + axis] = min(rows[total, 7 + axis], points[n, axis])
                    rows[total, 10 + axis] = max(rows[total, 10 + axis], points[n, axis])
            if mine == 0 and whole == 0:
                break
            is_new = mine >= LEAST_OWN and whole >= LEAST_ALL
            for other in range(first, total):
                away, cosine = 0.0, 0.0
                for axis in range(3):
                    away += (place[axis] - rows[other, 4 + axis]) * rows[other, 1 + axis]
                    cosine += normal[axis] * rows[other, 1 + axis]
                if cosine > ALIKE and abs(away) < APART * side:
                    is_new = False
            if is_new:
                rows[total, 0] = c
                rows[total, 1:4], rows[total, 4:7] = normal, place
                rows[total, 13] = mine
                total += 1
    return rows[:total].copy()
