"""What the kernels compute, written for the reader: slow, on plain tables of cells, without tiles.

The tests hold every kernel to these. Positions are in cells from the table's corner, as in the kernels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

FULLNESS = 0.1
"""A cell that more than this share of its beams hit is occupied to the scan matcher."""


@dataclass(eq=False)
class PlainMap:
    """One particle's map as plain tables."""

    hits: np.ndarray
    """(h, w) beams that ended in a cell."""
    visits: np.ndarray
    """(h, w) beams that met a cell."""
    means: np.ndarray
    """(h, w, 2) mean x, y of a cell's hits, from the cell's corner."""

    @classmethod
    def empty(cls, height: int, width: int) -> PlainMap:
        """Return a map in which nothing was seen."""
        table = np.zeros((height, width), int)
        return cls(table, table.copy(), np.zeros((height, width, 2)))

    def copy(self) -> PlainMap:
        """Return a map of its own."""
        return PlainMap(self.hits.copy(), self.visits.copy(), self.means.copy())

    @property
    def occupied(self) -> np.ndarray:
        """(h, w) bool"""
        return (self.hits > 0) & (self.hits > FULLNESS * self.visits)


ROW = 2.0**32
"""Rows are followed in this fraction of a cell, along a beam."""


def crossed(lidar, end) -> list[tuple[int, int]]:
    """Return the cells (x, y) between the lidar's and the end's, one for each column of the major axis."""
    lidar, end = np.asarray(lidar, float), np.asarray(end, float)
    major = 0 if abs(end[0] - lidar[0]) >= abs(end[1] - lidar[1]) else 1
    minor = 1 - major
    start, stop = int(lidar[major]), int(end[major])
    if start == stop:
        return []
    slope = (end[minor] - lidar[minor]) / (end[major] - lidar[major])
    at_first = lidar[minor] + (start + 0.5 - lidar[major]) * slope
    rows = {start: int(np.clip(at_first, *sorted((lidar[minor], end[minor]))))}
    columns = range(start + 1, stop) if stop > start else range(stop + 1, start)
    for column in columns:
        at_first = int((lidar[minor] + (columns[0] + 0.5 - lidar[major]) * slope) * ROW)
        rows[column] = (at_first + (column - columns[0]) * int(slope * ROW)) // int(ROW)
    return [(column, row) if major == 0 else (row, column) for column, row in rows.items()]


def insert(plain: PlainMap, lidar, ends, hits) -> None:
    """Enter beams into a map."""
    for end, hit in zip(ends, hits):
        for x, y in crossed(lidar, end):
            plain.visits[y, x] += 1
        if hit:
            x, y = int(end[0]), int(end[1])
            plain.visits[y, x] += 1
            plain.hits[y, x] += 1
            plain.means[y, x] += (np.asarray(end) - (x, y) - plain.means[y, x]) / plain.hits[y, x]


def render(plain: PlainMap, threshold: float) -> np.ndarray:
    """Return (h, w) int8: -1 never met, 100 hit by a greater share of beams than the threshold, else 0."""
    share = plain.hits / np.maximum(plain.visits, 1)
    return np.where(plain.visits == 0, -1, np.where(share > threshold, 100, 0)).astype(np.int8)


def turned(yaw_rad: float, vectors) -> np.ndarray:
    """Return vectors (..., 2) turned by an angle."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.asarray(vectors) @ np.array([[cos, sin], [-sin, cos]])


def offset(plain: PlainMap, occupied, point, step, normal, along: float, kernel: int) -> np.ndarray | None:
    """Return the offset (2,) of a beam's end from the map's point nearest to it, None if there is none.

    Points are means of occupied cells within ``kernel`` cells, whose neighbour towards the lidar is not
    occupied. Distance along the surface counts ``along`` times as much as across. occupied: that of the map.
    """
    cell, back = np.floor(point).astype(int), np.floor(point - step).astype(int)
    best, nearest = math.inf, None
    for y in range(cell[1] - kernel, cell[1] + kernel + 1):
        for x in range(cell[0] - kernel, cell[0] + kernel + 1):
            behind = occupied[y + back[1] - cell[1], x + back[0] - cell[0]]
            if occupied[y, x] and not behind:
                candidate = point - (x, y) - plain.means[y, x]
                if squared(candidate, normal, along) < best:
                    best, nearest = squared(candidate, normal, along), candidate
    return nearest


def squared(vector, normal, along: float) -> float:
    """Return the squared length of an offset whose part along the surface counts ``along`` times as much."""
    across = float(vector @ normal)
    return across**2 + along * (float(vector @ vector) - across**2)


def offsets(plain: PlainMap, pose, beams, kernel: int) -> list[tuple[np.ndarray, np.ndarray, int] | None]:
    """Return, for every beam, its (offset, normal, index) at a pose, or None."""
    height, width = plain.hits.shape
    least, occupied, found = kernel + 3, plain.occupied, []
    for index, beam in enumerate(beams):
        point = turned(pose[2], beam[0:2]) + pose[:2]
        inside = least <= point[0] < width - least and least <= point[1] < height - least
        step, normal = turned(pose[2], beam[2:4]), turned(pose[2], beam[4:6])
        vector = offset(plain, occupied, point, step, normal, beam[6], kernel) if inside else None
        found.append(None if vector is None else (vector, normal, index))
    return found


def score(plain: PlainMap, pose, beams, kernel: int, sigma: float) -> float:
    """Return the sum of exp(-d2 / sigma) over the beams that have a point of the map near."""
    found = [each for each in offsets(plain, pose, beams, kernel) if each is not None]
    return sum(math.exp(-squared(vector, normal, beams[i, 6]) / sigma) for vector, normal, i in found)


def log_likelihood(
    plain: PlainMap, pose, beams, kernel: int, sigma: float, missed: float, counts=None
) -> float:
    """Return the sum of -d2 / sigma, or ``missed`` for a beam that has no point of the map near.

    Only the beams that ``counts`` names count; None: all.
    """
    return sum(
        missed if each is None else -squared(each[0], each[1], beams[each[2], 6]) / sigma
        for i, each in enumerate(offsets(plain, pose, beams, kernel))
        if counts is None or counts[i]
    )


def linearise(plain: PlainMap, pose, beams, kernel: int, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (information (3, 3), gradient (3,)) of the weighted least squares problem at a pose."""
    information, gradient = np.zeros((3, 3)), np.zeros(3)
    for each in offsets(plain, pose, beams, kernel):
        if each is None:
            continue
        vector, normal, i = each
        end = turned(pose[2], beams[i, 0:2])
        jacobian = np.array([[1.0, 0.0, -end[1]], [0.0, 1.0, end[0]]])
        tangent = np.array([-normal[1], normal[0]])
        metric = np.outer(normal, normal) + beams[i, 6] * np.outer(tangent, tangent)
        weight = math.exp(-squared(vector, normal, beams[i, 6]) / sigma)
        information += weight * jacobian.T @ metric @ jacobian
        gradient -= weight * jacobian.T @ metric @ vector
    return information, gradient


def refine(plain: PlainMap, pose, prior_pose, prior, beams, kernel: int, sigma: float, steps: int):
    """Return the pose after that many Gauss-Newton steps towards the maximum of score and prior."""
    pose = np.array(pose, float)
    for _ in range(steps):
        information, gradient = linearise(plain, pose, beams, kernel, sigma)
        pose += np.linalg.solve(information + prior, gradient - prior @ (pose - prior_pose))
    return pose


def climb(plain: PlainMap, pose, beams, kernel: int, sigma: float, step, turn, halvings: int):
    """Return the (pose, score) that hill climbing ends at; steps are halved where none is better."""
    best, value = np.array(pose, float), score(plain, pose, beams, kernel, sigma)
    for halved in range(halvings + 1):
        moves = np.diag((step, step, turn)) / 2.0**halved
        while True:
            around = [best + sign * move for move in moves for sign in (1.0, -1.0)]
            values = [score(plain, to, beams, kernel, sigma) for to in around]
            if max(values) <= value:
                break
            best, value = around[int(np.argmax(values))], max(values)
    return best, value


def line_fit(points) -> tuple[np.ndarray, float]:
    """Return the (normal (2,), ratio of the variances across and along) of the line through points (n, 2)."""
    centred = np.asarray(points) - np.mean(points, axis=0)
    variances, axes = np.linalg.eigh(centred.T @ centred)
    return axes[:, 0], float(variances[0] / variances[1])
