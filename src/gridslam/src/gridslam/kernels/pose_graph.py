"""Optimises a pose graph by steps of Levenberg and Marquardt, with a sparse Cholesky factorisation.

Nodes are eliminated in the order of minimum degree: W. F. Tinney and J. W. Walker, "Direct solutions of
sparse network equations by optimally ordered triangular factorization" (1967). The nodes that are near a node
when it is eliminated are the rows of its column of the factor.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gridslam.kernels.least_squares import factor, inverse, solve_upper
from kernel_cache.compiler import njit

WORD_BITS = 64
ONE, ZERO = np.uint64(1), np.uint64(0)
DAMPING_FIRST, DAMPING_MAX, DAMPING_FACTOR = 1e-5, 1e5, 10.0
ROUNDS_MAX = 100
COST_MIN = 1e-5
"""A step that lowers the cost by less ends the search."""
ANCHOR_INFORMATION = 1e12
"""1/m2 and 1/rad2: holds the first node."""


class Edges(NamedTuple):
    """Measured relative poses."""

    older: np.ndarray
    """(m,) node."""
    newer: np.ndarray
    """(m,) node."""
    measured: np.ndarray
    """(m, 3) pose of the newer node in the older."""
    information: np.ndarray
    """(m, 3, 3) of the newer node's pose, in its own frame."""


class Pattern(NamedTuple):
    """Where the factor is not zero. Nodes are numbered in the order of their elimination."""

    positions: np.ndarray
    """(n,) number of each node of the graph."""
    starts: np.ndarray
    """(n + 1,) where each column's rows begin."""
    rows: np.ndarray
    """Ascending within each column, below the diagonal."""


class Matrix(NamedTuple):
    """A symmetric matrix of blocks of 3 x 3, or its lower factor."""

    diagonal: np.ndarray
    """(n, 3, 3)"""
    blocks: np.ndarray
    """(entries of the pattern, 3, 3)"""


@njit(cache=True, nogil=True)
def _members(words: np.ndarray, nodes: np.ndarray) -> int:
    """Write the members of a set of bits into ``nodes``, ascending; return their number."""
    count = 0
    for word in range(words.size):
        left, node = words[word], word * WORD_BITS
        while left != ZERO:
            if left & ONE:
                nodes[count] = node
                count += 1
            left >>= ONE
            node += 1
    return count


@njit(cache=True, nogil=True)
def _flip(words: np.ndarray, node: int) -> None:
    words[node // WORD_BITS] ^= ONE << np.uint64(node % WORD_BITS)


@njit(cache=True, nogil=True)
def pattern_of(count: int, older: np.ndarray, newer: np.ndarray) -> Pattern:
    """Return the pattern of the factor for a graph of ``count`` nodes."""
    near = np.zeros((count, (count - 1) // WORD_BITS + 1), np.uint64)
    for i in range(older.size):
        near[older[i], newer[i] // WORD_BITS] |= ONE << np.uint64(newer[i] % WORD_BITS)
        near[newer[i], older[i] // WORD_BITS] |= ONE << np.uint64(older[i] % WORD_BITS)
    nodes, others = np.empty(count, np.int64), np.empty(count, np.int64)
    degrees = np.array([_members(near[node], nodes) for node in range(count)])
    positions, starts, rows = (
        np.empty(count, np.int64),
        np.zeros(count + 1, np.int64),
        np.empty(8 * count, np.int64),
    )
    for position in range(count):
        node = int(np.argmin(degrees))
        found = _members(near[node], nodes)
        for other in nodes[:found]:
            near[other] |= near[node]
            _flip(near[other], other)
            _flip(near[other], node)
            degrees[other] = _members(near[other], others)
        positions[node], degrees[node] = position, count
        first = starts[position]
        starts[position + 1] = first + found
        if first + found > rows.size:
            rows = np.append(rows, np.empty(rows.size + found, np.int64))
        rows[first : first + found] = nodes[:found]
    for position in range(count):
        rows[starts[position] : starts[position + 1]] = np.sort(
            positions[rows[starts[position] : starts[position + 1]]]
        )
    return Pattern(positions, starts, rows[: starts[count]].copy())


@njit(cache=True, nogil=True)
def _error(edges: Edges, i: int, poses: np.ndarray, error: np.ndarray) -> tuple[float, float, float]:
    """Write the error (3,) of an edge, seen from its measured newer node.

    Returns the newer node's true pose in the older one's.
    """
    a, b, measured = poses[edges.older[i]], poses[edges.newer[i]], edges.measured[i]
    cos, sin = math.cos(a[2]), math.sin(a[2])
    x, y = cos * (b[0] - a[0]) + sin * (b[1] - a[1]), -sin * (b[0] - a[0]) + cos * (b[1] - a[1])
    yaw = b[2] - a[2]
    cos, sin = math.cos(measured[2]), math.sin(measured[2])
    dx, dy, turn = x - measured[0], y - measured[1], yaw - measured[2]
    error[0], error[1] = cos * dx + sin * dy, -sin * dx + cos * dy
    error[2] = math.atan2(math.sin(turn), math.cos(turn))
    return x, y, yaw


@njit(cache=True, nogil=True)
def _square(information: np.ndarray, error: np.ndarray) -> float:
    square = 0.0
    for k in range(3):
        for m in range(3):
            square += error[k] * information[k, m] * error[m]
    return square


@njit(cache=True, nogil=True)
def cost_of(edges: Edges, poses: np.ndarray, robust_scale: float) -> float:
    """Return the sum of the edges' robust costs (Cauchy)."""
    error, cost, square = np.empty(3), 0.0, robust_scale * robust_scale
    for i in range(edges.older.size):
        _error(edges, i, poses, error)
        cost += 0.5 * square * math.log1p(_square(edges.information[i], error) / square)
    return cost


@njit(cache=True, nogil=True)
def linearise_graph(
    edges: Edges,
    poses: np.ndarray,
    robust_scale: float,
    pattern: Pattern,
    matrix: Matrix,
    gradient: np.ndarray,
) -> None:
    """Write the normal equations of small steps of all nodes, each in its own frame: gradient (n, 3)."""
    matrix.diagonal[:], matrix.blocks[:], gradient[:] = 0.0, 0.0, 0.0
    error, of_older, of_newer = np.empty(3), np.empty((3, 3)), np.zeros((3, 3))
    for i in range(edges.older.size):
        a, b = pattern.positions[edges.older[i]], pattern.positions[edges.newer[i]]
        x, y, yaw = _error(edges, i, poses, error)
        weight = 1.0 / (1.0 + _square(edges.information[i], error) / (robust_scale * robust_scale))
        information = weight * edges.information[i]
        # the derivatives of the error by a step of the newer node, and of the older one
        of_newer[0, 0], of_newer[0, 1], of_newer[2, 2] = math.cos(error[2]), -math.sin(error[2]), 1.0
        of_newer[1, 0], of_newer[1, 1] = math.sin(error[2]), math.cos(error[2])
        cos, sin = math.cos(error[2] - yaw), math.sin(error[2] - yaw)
        of_older[0, 0], of_older[0, 1], of_older[0, 2] = -cos, sin, cos * y + sin * x
        of_older[1, 0], of_older[1, 1], of_older[1, 2] = -sin, -cos, sin * y - cos * x
        of_older[2, 0], of_older[2, 1], of_older[2, 2] = 0.0, 0.0, -1.0
        column, row = (a, b) if a < b else (b, a)
        first, end = pattern.starts[column], pattern.starts[column + 1]
        block = matrix.blocks[first + np.searchsorted(pattern.rows[first:end], row)]
        of_row, of_column = (of_newer, of_older) if a < b else (of_older, of_newer)
        for k in range(3):
            for m in range(3):
                for p in range(3):
                    for q in range(3):
                        value = information[p, q]
                        matrix.diagonal[a, k, m] += of_older[p, k] * value * of_older[q, m]
                        matrix.diagonal[b, k, m] += of_newer[p, k] * value * of_newer[q, m]
                        block[k, m] += of_row[p, k] * value * of_column[q, m]
                for p in range(3):
                    pull = information[m, p] * error[p]
                    gradient[a, k] -= of_older[m, k] * pull
                    gradient[b, k] -= of_newer[m, k] * pull
    for k in range(3):
        matrix.diagonal[pattern.positions[0], k, k] += ANCHOR_INFORMATION


@njit(cache=True, nogil=True)
def factorise(pattern: Pattern, matrix: Matrix, damping: float) -> None:
    """Overwrite a matrix, with a damped diagonal, by its lower factor, column after column."""
    starts, rows, diagonal, blocks = pattern.starts, pattern.rows, matrix.diagonal, matrix.blocks
    count, lower = diagonal.shape[0], np.zeros((3, 3))
    used = starts[:-1].copy()
    # the columns whose next row is this one, as a list: its first, and the one after each
    first, after, place = np.full(count, -1), np.full(count, -1), np.empty(count, np.int64)
    for column in range(count):
        for s in range(starts[column], starts[column + 1]):
            place[rows[s]] = s
        earlier = first[column]
        while earlier >= 0:
            following, at = after[earlier], used[earlier]
            for s in range(at, starts[earlier + 1]):
                target = diagonal[column] if s == at else blocks[place[rows[s]]]
                for k in range(3):
                    for m in range(3):
                        target[k, m] -= (
                            blocks[s, k, 0] * blocks[at, m, 0]
                            + blocks[s, k, 1] * blocks[at, m, 1]
                            + blocks[s, k, 2] * blocks[at, m, 2]
                        )
            used[earlier] = at + 1
            if at + 1 < starts[earlier + 1]:
                row = rows[at + 1]
                first[row], after[earlier] = earlier, first[row]
            earlier = following
        for k in range(3):
            diagonal[column, k, k] += damping
        factor(diagonal[column], lower)
        diagonal[column] = lower
        for s in range(starts[column], starts[column + 1]):
            for k in range(3):
                for m in range(3):
                    for p in range(m):
                        blocks[s, k, m] -= lower[m, p] * blocks[s, k, p]
                    blocks[s, k, m] /= lower[m, m]
        if starts[column] < starts[column + 1]:
            row = rows[starts[column]]
            first[row], after[column] = column, first[row]


@njit(cache=True, nogil=True)
def solve_factored(pattern: Pattern, matrix: Matrix, steps: np.ndarray) -> None:
    """Overwrite the right side (n, 3) with the solution, by a matrix's lower factor."""
    starts, rows = pattern.starts, pattern.rows
    for column in range(steps.shape[0]):
        for k in range(3):
            for m in range(k):
                steps[column, k] -= matrix.diagonal[column, k, m] * steps[column, m]
            steps[column, k] /= matrix.diagonal[column, k, k]
        for s in range(starts[column], starts[column + 1]):
            for k in range(3):
                for m in range(3):
                    steps[rows[s], k] -= matrix.blocks[s, k, m] * steps[column, m]
    for column in range(steps.shape[0] - 1, -1, -1):
        for s in range(starts[column], starts[column + 1]):
            for k in range(3):
                for m in range(3):
                    steps[column, m] -= matrix.blocks[s, k, m] * steps[rows[s], k]
        solve_upper(matrix.diagonal[column], steps[column])


@njit(cache=True, nogil=True)
def _search(poses: np.ndarray, edges: Edges, pattern: Pattern, robust_scale: float, tolerance: float) -> None:
    """Move poses (n, 3) by steps of Levenberg and Marquardt: see `optimise_graph`."""
    count = len(poses)
    equations = Matrix(np.empty((count, 3, 3)), np.empty((pattern.rows.size, 3, 3)))
    factors, gradient = (
        Matrix(np.empty((count, 3, 3)), np.empty((pattern.rows.size, 3, 3))),
        np.empty((count, 3)),
    )
    moved, cost, damping, is_new = (
        np.empty_like(poses),
        cost_of(edges, poses, robust_scale),
        DAMPING_FIRST,
        True,
    )
    for _ in range(ROUNDS_MAX):
        if is_new:
            linearise_graph(edges, poses, robust_scale, pattern, equations, gradient)
        factors.diagonal[:], factors.blocks[:] = equations.diagonal, equations.blocks
        factorise(pattern, factors, damping)
        steps = gradient.copy()
        solve_factored(pattern, factors, steps)
        for node in range(count):
            step, cos, sin = (
                steps[pattern.positions[node]],
                math.cos(poses[node, 2]),
                math.sin(poses[node, 2]),
            )
            moved[node, 0] = poses[node, 0] + cos * step[0] - sin * step[1]
            moved[node, 1] = poses[node, 1] + sin * step[0] + cos * step[1]
            moved[node, 2] = poses[node, 2] + step[2]
        lowered = cost - cost_of(edges, moved, robust_scale)
        is_new = lowered > 0.0
        if is_new:
            poses[:] = moved
        if (is_new or damping >= DAMPING_MAX) and lowered <= max(COST_MIN, tolerance * cost):
            break
        cost -= max(0.0, lowered)
        damping = damping / DAMPING_FACTOR if is_new else damping * DAMPING_FACTOR


@njit(cache=True, nogil=True)
def optimise_graph(
    poses: np.ndarray,
    older: np.ndarray,
    newer: np.ndarray,
    measured: np.ndarray,
    covariances: np.ndarray,
    searches: np.ndarray,
) -> None:
    """Move poses (n, 3) to where they fit the edges best: see `Edges`. The first node stays.

    ``searches`` (s, 2): each search has a scale of the robust kernel. It ends when a step lowers the robust
    cost by less than a share, its tolerance.
    """
    information = np.empty_like(covariances)
    for i in range(older.size):
        information[i] = inverse(covariances[i])
    edges, pattern = Edges(older, newer, measured, information), pattern_of(len(poses), older, newer)
    for i in range(searches.shape[0]):
        _search(poses, edges, pattern, searches[i, 0], searches[i, 1])


@njit(cache=True, nogil=True)
def covariance_of(
    poses: np.ndarray,
    older: np.ndarray,
    newer: np.ndarray,
    measured: np.ndarray,
    covariances: np.ndarray,
    node: int,
) -> np.ndarray:
    """Return the covariance (3, 3) of a node's pose, in its own frame, if the first node is known.

    The graph must join all nodes. Edges that contradict the poses (n, 3) count less, as in `cost_of`.
    """
    count, information = len(poses), np.empty_like(covariances)
    for i in range(older.size):
        information[i] = inverse(covariances[i])
    pattern, gradient = pattern_of(count, older, newer), np.empty((count, 3))
    matrix = Matrix(np.empty((count, 3, 3)), np.empty((pattern.rows.size, 3, 3)))
    edges = Edges(older, newer, measured, information)
    linearise_graph(edges, poses, 1.0, pattern, matrix, gradient)
    factorise(pattern, matrix, 0.0)
    found, position = np.empty((3, 3)), pattern.positions[node]
    for k in range(3):
        gradient[:] = 0.0
        gradient[position, k] = 1.0
        solve_factored(pattern, matrix, gradient)
        found[:, k] = gradient[position]
    return found


@njit(cache=True, nogil=True)
def shortest_ways(
    count: int, older: np.ndarray, newer: np.ndarray, lengths: np.ndarray, node: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return of the shortest way from each of ``count`` nodes to one: length, next node, and edge to it.

    Edges (m,) may be used in both directions. All but a few join neighbours, in ascending order. So one sweep
    over them, up and down, is enough for each of the others that is on a way.
    """
    found, before, edges = np.full(count, np.inf), np.arange(count), np.full(count, -1)
    found[node], is_new = 0.0, True
    while is_new:
        is_new = False
        for sweep in range(2 * older.size):
            i = sweep if sweep < older.size else 2 * older.size - 1 - sweep
            for start, end in ((older[i], newer[i]), (newer[i], older[i])):
                if found[start] + lengths[i] < found[end]:
                    found[end], before[end], edges[end], is_new = found[start] + lengths[i], start, i, True
    return found, before, edges
