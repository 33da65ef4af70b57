"""The true walls of a simulated world, to compare a map with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable

import numpy as np
from scipy.spatial import cKDTree

from gridslam.errors import EvaluationError
from gridslam.files.number_rows import read_rows

SAME_LINE_M = 0.02  # segments on one line within this belong to one wall ...
SAME_LINE_RAD = math.radians(0.5)  # ... when their directions agree this well, too, ...
SAME_WALL_GAP_M = 3.0  # ... and when no gap between them is longer: beams and doors, not a whole room


@dataclass(frozen=True)
class Walls:
    """Wall segments in the frame of the map.

    ends_m: (n, 4) float64, x1, y1, x2, y2 of each segment; metres. Curved walls come as short segments;
    segments of length 0 are left out.

    Raises EvaluationError for any other input.
    """

    ends_m: np.ndarray

    def __post_init__(self) -> None:
        ends = np.asarray(self.ends_m, dtype=float)
        if ends.ndim != 2 or ends.shape[1] != 4 or not len(ends) or not np.isfinite(ends).all():
            raise EvaluationError("Walls need one or more segments of four finite numbers: x1, y1, x2, y2.")
        ends = ends[(ends[:, :2] != ends[:, 2:]).any(axis=1)]
        if not len(ends):
            raise EvaluationError("Every wall segment has length 0: its ends are the same point.")
        object.__setattr__(self, "ends_m", ends)

    @classmethod
    def from_polygons(cls, polygons: Iterable[np.ndarray]) -> Walls:
        """Return the sides of closed polygons, each (k, 2) corners in metres, in order."""
        corners = [np.asarray(polygon, dtype=float) for polygon in polygons]
        return cls(np.concatenate([np.hstack([each, np.roll(each, -1, axis=0)]) for each in corners]))

    @property
    def lengths_m(self) -> np.ndarray:
        """(n,) length of each segment."""
        return np.hypot(self.ends_m[:, 2] - self.ends_m[:, 0], self.ends_m[:, 3] - self.ends_m[:, 1])

    def distances(self, points_xy_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return each point's distance to the nearest segment, and that segment's index: (p,) and (p,)."""
        start, along = self.ends_m[:, :2], self.ends_m[:, 2:] - self.ends_m[:, :2]
        squared = np.maximum((along**2).sum(axis=1), 1e-18)
        best = np.full(len(points_xy_m), np.inf)
        nearest = np.zeros(len(points_xy_m), dtype=np.int64)
        for i in range(len(start)):
            offset = points_xy_m - start[i]
            foot = np.clip(offset @ along[i] / squared[i], 0.0, 1.0)
            distance = np.hypot(*(offset - foot[:, None] * along[i]).T)
            nearer = distance < best
            best[nearer], nearest[nearer] = distance[nearer], i
        return best, nearest

    def samples(self, spacing_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return points along the walls, (p, 2), and the length of wall that each stands for, (p,)."""
        points, weights = [], []
        for (x1, y1, x2, y2), length in zip(self.ends_m, self.lengths_m):
            pieces = max(1, math.ceil(length / spacing_m))
            part = (np.arange(pieces) + 0.5)[:, None] / pieces
            points.append(np.array([[x1, y1]]) + part * np.array([[x2 - x1, y2 - y1]]))
            weights.append(np.full(pieces, length / pieces))
        return np.concatenate(points), np.concatenate(weights)

    def straight_walls(self) -> list[np.ndarray]:
        """Return the indices of the segments of each straight wall.

        Segments on one line with short gaps are one wall. So a wall broken by beams is measured over its
        whole length.
        """
        return [wall for line in self._same_lines() for wall in self._split_at_gaps(line)]

    def _split_at_gaps(self, segments: list[int]) -> list[np.ndarray]:
        ends = self.ends_m[segments].reshape(-1, 2, 2)
        along = (ends[0, 1] - ends[0, 0]) / np.hypot(*(ends[0, 1] - ends[0, 0]))
        spans = np.sort(ends @ along, axis=1)
        order = np.argsort(spans[:, 0])
        reached = np.maximum.accumulate(spans[order, 1])
        gaps = np.flatnonzero(spans[order[1:], 0] - reached[:-1] > SAME_WALL_GAP_M)
        return np.split(np.array(segments)[order], gaps + 1)

    def _same_lines(self) -> list[list[int]]:
        lines = [self._line(ends) for ends in self.ends_m]
        groups: list[list[int]] = []
        for i, ends in enumerate(self.ends_m):
            for group in groups:
                angle, x, y = lines[group[0]]
                if abs(math.remainder(lines[i][0] - angle, math.pi)) > SAME_LINE_RAD:
                    continue
                normal = np.array([-math.sin(angle), math.cos(angle)])
                if np.abs((ends.reshape(2, 2) - (x, y)) @ normal).max() < SAME_LINE_M:
                    group.append(i)
                    break
            else:
                groups.append([i])
        return groups

    @staticmethod
    def _line(ends: np.ndarray) -> tuple[float, float, float]:
        x1, y1, x2, y2 = ends
        return math.atan2(y2 - y1, x2 - x1), x1, y1


@dataclass(frozen=True)
class WallPoints:
    """Walls known by points on them only, (n, 2) metres in the map's frame, `spacing_m` apart."""

    points_xy_m: np.ndarray
    spacing_m: float

    def distances(self, points_xy_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return each point's distance to the nearest wall point, and that one's index: (p,) and (p,)."""
        return cKDTree(self.points_xy_m).query(points_xy_m)

    def samples(self, spacing_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the points themselves, (n, 2), and the length of wall that each stands for, (n,)."""
        del spacing_m
        return self.points_xy_m, np.full(len(self.points_xy_m), self.spacing_m)


def read_walls(path: Path) -> Walls | WallPoints:
    """Read walls from a text file: four numbers a line are a segment, two a point on a wall.

    Raises:
        EvaluationError: the file cannot be read, or holds something else.
    """
    rows = read_rows(path, "4 finite numbers (x1 y1 x2 y2) or 2 (x y)", columns=(4, 2))
    if rows.shape[1] == 4:
        try:
            return Walls(rows)
        except EvaluationError as error:
            raise EvaluationError(f"{path}: {error}") from None
    rows = np.unique(rows, axis=0)
    gaps = cKDTree(rows).query(rows, k=2)[0][:, 1] if len(rows) > 1 else np.ones(1)
    return WallPoints(rows, float(np.median(gaps)))
