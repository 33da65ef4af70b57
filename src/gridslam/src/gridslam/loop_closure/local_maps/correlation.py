"""Finds the pose of one local map on another: correlative scan matching (Olson, ICRA 2009).

It scores every pose of a window, however far from the prediction. So it notices a second pose that fits as
well. Upper bounds of whole blocks of poses save most of the work and change no result.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gridslam import se2
from gridslam.kernels.correlation import (
    BLOCK,
    CLASHES,
    FITS,
    FULL,
    LEVELS,
    Blocks,
    Query,
    Reference,
    best_shift,
    block_sums,
    leave_out,
    pool,
)
from gridslam.loop_closure.local_maps.local_map import LocalMap

POINTS_MAX = 400
NOTHING_LEFT_OUT = np.zeros(3)


@dataclass(frozen=True)
class Window:
    """The window of a search.

    predicted: (x m, y m, yaw rad), its middle. reach_m, reach_rad: the distance to every side of it.
    information: (3, 3) of the prediction, in its own frame. Only poses e with e' information e <= 1 are
    searched; zeros: the whole window.
    """

    predicted: np.ndarray
    reach_m: float
    reach_rad: float
    information: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True)
class Optimum:
    """The best pose of a window.

    query_in_reference: pose (3,) of the query's anchor in the reference's. score: share of the comparisons
    that agree, 0..1.
    """

    query_in_reference: np.ndarray
    score: float


class Correlation:
    """One search of a window for the pose at which two local maps agree best."""

    def __init__(self, reference: LocalMap, query: LocalMap, window: Window):
        self._window, self._resolution_m = window, reference.resolution_m
        cell = reference.resolution_m
        points = _spread(query.surface.points_xy_m, POINTS_MAX)
        self._turns_rad = _angles(points, window.reach_rad, 2.0 * cell)
        self.angles_rad = window.predicted[2] + self._turns_rad
        cos, sin = np.cos(self.angles_rad), np.sin(self.angles_rad)
        turns = np.stack([np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)], axis=1)
        moved = np.vstack([points, query.origin_xy_m]) @ turns + (
            window.predicted[:2] - reference.origin_xy_m
        )
        cells = np.floor(moved[:, :-1] / cell).astype(np.int64)
        self._query = Query(query.table, self.angles_rad, cells, moved[:, -1] / cell)
        share = len(points) / max(1, len(query.surface.points_xy_m))  # both maps' points have equal weight
        back = _spread(reference.points_in_cells, round(share * len(reference.surface.points_xy_m)))
        levels, phases = _pooled(reference.table)
        self._reference, self._points = Reference(levels, back), len(points)
        self._half = int(np.ceil(window.reach_m / cell))
        count = (2 * self._half + BLOCK) // BLOCK
        self._sums = np.zeros((len(turns), count, 2 * count), np.int32)
        block_sums(phases, cells, self._half, self._sums)
        self._factor = _factor(window, cell)
        leave_out(self._turns_rad, self._factor, self._half, self._sums)

    def _best_shift(
        self, overlap_min: float, circle: np.ndarray, score_min: float, is_any: bool
    ) -> tuple[float, int, int, int]:
        """Search the blocks that may hold a higher score than `score_min`, with the highest bound first."""
        least = max(1.0, overlap_min * self._points)
        fits, clashes = self._sums[:, :, FITS::2] / FULL, self._sums[:, :, CLASHES::2] / FULL
        bounds = (fits / np.maximum(fits + clashes, least)).astype(np.float32)
        order = np.flatnonzero(bounds > score_min)
        order = order[np.argsort(-bounds.reshape(-1)[order], kind="stable")]
        blocks = Blocks(self._half, least, bounds, order, self._turns_rad, self._factor)
        return best_shift(blocks, self._reference, self._query, circle, score_min, is_any)

    def best(self, score_min: float, overlap_min: float) -> Optimum | None:
        """Return the best pose; None if no pose scores more than `score_min`.

        overlap_min: share of the query's points that should be comparable. With fewer the score falls.
        """
        score, angle, dx, dy = self._best_shift(overlap_min, NOTHING_LEFT_OUT, score_min, False)
        if score <= score_min:
            return None
        shift = np.array([dx, dy]) * self._resolution_m
        pose = np.array([*(self._window.predicted[:2] + shift), se2.wrap(self.angles_rad[angle])])
        return Optimum(pose, float(score))

    def has_rival(self, optimum: Optimum, distance_m: float, score_min: float, overlap_min: float) -> bool:
        """Return whether a pose `distance_m` or farther from an optimum scores more than `score_min`."""
        middle = optimum.query_in_reference[:2] - self._window.predicted[:2]
        circle = np.array([*middle, distance_m]) / self._resolution_m
        return bool(self._best_shift(overlap_min, circle, score_min, True)[0] > score_min)


def _factor(window: Window, cell_m: float) -> np.ndarray:
    """Return a window's `Blocks.factor`. Shifts are in the reference's frame, the information is not."""
    values, vectors = np.linalg.eigh(window.information)
    cos, sin = np.cos(window.predicted[2]), np.sin(window.predicted[2])
    turn = np.array([(cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0)])
    return np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T @ turn * (cell_m, cell_m, 1.0)


def _pooled(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a table's `Reference.levels`, and the input of `block_sums`, which is the next level."""
    rows, columns = (-(-side // BLOCK) + 2 for side in table.shape[:2])
    levels = np.empty((LEVELS, rows * BLOCK, 2 * columns * BLOCK), np.uint8)
    phases = np.empty((BLOCK, BLOCK, rows, 2 * columns), np.uint8)
    pool(table, levels, phases)
    return levels, phases


def _spread(points: np.ndarray, most: int) -> np.ndarray:
    """Return at most this many points, at even steps."""
    if len(points) <= most:
        return points
    return points[np.linspace(0, len(points) - 1, most).astype(int)]


def _angles(points: np.ndarray, reach_rad: float, step_m: float) -> np.ndarray:
    """Angles around zero, so fine that most points move by at most step_m from one to the next."""
    radius = max(1.0, float(np.percentile(np.hypot(*points.T), 80.0))) if len(points) else 1.0
    count = int(np.ceil(reach_rad * radius / step_m))
    return np.linspace(-reach_rad, reach_rad, 2 * count + 1)
