"""Branch and bound over the positions and headings of a set of points on a map (Hess et al. 2016).

Everything is in cells from the map's corner and radians. A block is a square of positions, 4^level cells
wide, at one heading. Its upper bound is the sum over the points of the greatest fit in a square of cells.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from kernel_cache.compiler import njit

FULL = 255
"""The greatest fit."""


@njit(cache=True, nogil=True)
def _sum_of_fits(
    level: np.ndarray, margin: int, outside: int, cells: np.ndarray, x: int, y: int, least: float
) -> int:
    """Sum a level's values at points (n, 2) moved by x, y; beyond the level it is ``outside``.

    The sum ends, and is at most ``least``, once the points that are left cannot make it greater.
    """
    height, width = level.shape
    possible = FULL * cells.shape[0]
    for i in range(cells.shape[0]):
        column, row = cells[i, 0] + x + margin, cells[i, 1] + y + margin
        fit = outside
        if 0 <= column < width and 0 <= row < height:
            fit = int(level[row, column])
        possible += fit - FULL
        if possible <= least:
            break
    return possible


@njit(cache=True, nogil=True)
def _is_covered(
    angles: np.ndarray, a: int, x: int, y: int, width: int, places: np.ndarray, count: int, apart: np.ndarray
) -> bool:
    """Return whether every position of a block is the same place as one that was found."""
    for i in range(count):
        turn = abs(angles[a] - angles[places[i, 0]]) % (2.0 * math.pi)
        if min(turn, 2.0 * math.pi - turn) >= apart[1]:
            continue
        far_x = max(abs(x - places[i, 1]), abs(x + width - 1 - places[i, 1]))
        far_y = max(abs(y - places[i, 2]), abs(y + width - 1 - places[i, 2]))
        if math.hypot(far_x, far_y) < apart[0]:
            return True
    return False


@njit(cache=True, nogil=True)
def best_places(
    levels: np.ndarray,
    outside: int,
    cells: np.ndarray,
    angles: np.ndarray,
    box: np.ndarray,
    apart: np.ndarray,
    least: float,
    share: float,
    most: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k, 3: heading's index, x, y) and their scores (k,), best first.

    Args:
        levels: (levels, h + m, w + m) uint8, see `PlaceSearch`; m is 4 to the power of the last level.
        outside: value of cells beyond the map.
        cells: (angles, n, 2) the points at each heading, in cells from the position.
        angles: (angles,) rad.
        box: (4,) the least x and y, and the greatest, of the positions to search.
        apart: (2,) two poses nearer than this (cells) and turned by less than this (rad) are one place.
        least: the lowest score of a place.
        share: the lowest score of a rival, as a share of the best one's.
        most: the search ends after this many places.
    """
    top = levels.shape[0] - 1
    margin = 4**top
    places, scores = np.zeros((most, 3), np.int64), np.zeros(most)
    blocks = [(-1, 0, 0, 0, 0)]
    blocks.pop()
    for a in range(cells.shape[0]):
        for y in range(box[1], box[3] + 1, margin):
            for x in range(box[0], box[2] + 1, margin):
                bound = _sum_of_fits(levels[top], margin, outside, cells[a], x, y, least)
                if bound > least:
                    blocks.append((-bound, top, a, x, y))
    heapq.heapify(blocks)
    count = 0
    while count < most and len(blocks) > 0:
        bound, level, a, x, y = heapq.heappop(blocks)
        if -bound <= least:
            break
        if _is_covered(angles, a, x, y, 4**level, places, count, apart):
            continue
        if level == 0:
            places[count, 0], places[count, 1], places[count, 2], scores[count] = a, x, y, -bound
            count += 1
            least = max(least, share * scores[0])
            continue
        width = 4 ** (level - 1)
        for part in range(16):
            px, py = x + part % 4 * width, y + part // 4 * width
            if px > box[2] or py > box[3]:
                continue
            below = _sum_of_fits(levels[level - 1], margin, outside, cells[a], px, py, least)
            if below > least:
                heapq.heappush(blocks, (-below, level - 1, a, px, py))
    return places[:count], scores[:count]


@njit(cache=True, nogil=True)
def mean_squares(table: np.ndarray, unit: float, poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return for each pose (p, 3) the mean squared distance of points (n, 2) from the map's surfaces.

    ``table`` (h, w) uint8 holds 255 exp(-d^2 / (2 unit)); a point that fits by less than exp(-4.5), or lies
    beyond the table, counts as if it fitted by that. Between cells the distance is interpolated.
    """
    height, width = table.shape
    farthest = 9.0 * unit
    squares = np.empty(256)
    for value in range(256):
        squares[value] = min(farthest, -2.0 * unit * math.log(max(value, 1) / 255.0))
    means = np.zeros(poses.shape[0])
    for p in range(poses.shape[0]):
        cos, sin = math.cos(poses[p, 2]), math.sin(poses[p, 2])
        total = 0.0
        for i in range(points.shape[0]):
            x = poses[p, 0] + cos * points[i, 0] - sin * points[i, 1] - 0.5
            y = poses[p, 1] + sin * points[i, 0] + cos * points[i, 1] - 0.5
            column, row = int(np.floor(x)), int(np.floor(y))
            if not (0 <= column < width - 1 and 0 <= row < height - 1):
                total += farthest
                continue
            u, v = x - column, y - row
            low = (1.0 - u) * squares[table[row, column]] + u * squares[table[row, column + 1]]
            high = (1.0 - u) * squares[table[row + 1, column]] + u * squares[table[row + 1, column + 1]]
            total += (1.0 - v) * low + v * high
        means[p] = total / points.shape[0]
    return means


@njit(cache=True, nogil=True)
def _squares_along(occupied: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (spans, which, squares) of the rows: squared distances to the nearest occupied cell of a row.

    ``spans`` (h, 2): the columns, from the first on, that are within ``reach`` of such a cell; none: 0, 0.
    ``which`` (h,): a row's index in ``squares`` (rows with such a cell, w).
    """
    height, width = occupied.shape
    spans, which, count = np.zeros((height, 2), np.int64), np.zeros(height, np.int64), 0
    for row in range(height):
        hits = np.flatnonzero(occupied[row])
        if hits.size:
            spans[row] = max(0, hits[0] - reach), min(width, hits[-1] + reach + 1)
            which[row] = count
            count += 1
    squares = np.full((count, width), (reach + 1) ** 2, np.int32)
    for row in range(height):
        left, right = spans[row]
        for columns in (range(left, right), range(right - 1, left - 1, -1)):
            last = reach + 1
            for column in columns:
                last = 0 if occupied[row, column] else min(last + 1, reach + 1)
                squares[which[row], column] = min(squares[which[row], column], last**2)
    return spans, which, squares


@njit(cache=True, nogil=True)
def squared_distances(occupied: np.ndarray, reach: int, pooled: int) -> np.ndarray:
    """Return each cell's squared distance to the nearest occupied one, in cells, summed over blocks.

    A block is ``pooled`` x ``pooled`` cells; ``occupied`` (h, w) is whole blocks. Distances are right up to
    ``reach``; beyond it they are between reach and reach + 1. Most cells of a large map are so far away. So
    only the columns near an occupied cell are looked at.
    """
    height, width = occupied.shape
    spans, which, squares = _squares_along(occupied, reach)
    farthest = (reach + 1) ** 2
    sums = np.full((height // pooled, width // pooled), pooled**2 * farthest, np.int32)
    found = np.empty(width, np.int32)
    for row in range(height):
        others = range(max(0, row - reach), min(height, row + reach + 1))
        first, end = width, 0
        for other in others:
            if spans[other, 1] > 0:
                first, end = min(first, spans[other, 0]), max(end, spans[other, 1])
        found[first:end] = farthest
        for other in others:
            across, along = (other - row) ** 2, squares[which[other]]
            for column in range(spans[other, 0], spans[other, 1]):
                found[column] = min(found[column], across + along[column])
        for column in range(first, end):
            sums[row // pooled, column // pooled] += found[column] - farthest
    return sums
