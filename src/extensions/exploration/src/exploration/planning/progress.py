"""How far a UAV has come on a path."""

from __future__ import annotations

import numpy as np


def rest_of(points_m: np.ndarray, here_m: np.ndarray) -> tuple[np.ndarray, float]:
    """Return what is left of a path, from here on, and how far the UAV is off it.

    Args:
        points_m: (n, 3) x, y, z, n at least 2.
        here_m: (3,) where the UAV is.

    Returns:
        (k, 3) here, and the points after the leg that is nearest; of equally near legs the last one. And the
        distance to that leg, m.
    """
    here_m = np.asarray(here_m, float)
    begins, legs = points_m[:-1], np.diff(points_m, axis=0)
    squares = np.maximum((legs**2).sum(axis=1), 1e-12)
    shares = np.clip(((here_m - begins) * legs).sum(axis=1) / squares, 0.0, 1.0)
    away_m = np.linalg.norm(begins + shares[:, None] * legs - here_m, axis=1)
    leg = len(legs) - 1 - int(np.argmin(away_m[::-1]))
    return np.concatenate((here_m[None], points_m[leg + 1 :])), float(away_m[leg])


def place_ahead(points_m: np.ndarray, way_m: float) -> np.ndarray:
    """Return the place (3,) on a path (n, 3) this far from its begin, or its end."""
    for begin, end in zip(points_m, points_m[1:]):
        length_m = float(np.linalg.norm(end - begin))
        if way_m < length_m:
            return begin + way_m / length_m * (end - begin)
        way_m -= length_m
    return points_m[-1]
