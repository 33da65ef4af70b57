"""Figures of merit of a flight, from its time series and the world it was flown in."""

from __future__ import annotations

from typing import Callable

import numpy as np

from simulation_tools.geometry import Pose


def path_length_m(positions_xyz: np.ndarray) -> float:
    """Return the length in metres of the polyline through positions (n, 3)."""
    if len(positions_xyz) < 2:
        return 0.0
    return float(np.linalg.norm(np.diff(positions_xyz, axis=0), axis=1).sum())


def summary(values: np.ndarray) -> dict | None:
    """Return mean, median, 99th percentile, maximum and count of values (n,), or None without any."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    return {
        "mean": float(values.mean()),
        "median": float(np.median(values)),
        "p99": float(np.percentile(values, 99)),
        "max": float(values.max()),
        "count": len(values),
    }


def thinned(poses: np.ndarray, spacing_m: float) -> np.ndarray:
    """Thin out poses (n, 8: t, position, quaternion) to a spacing of `spacing_m`, both ends included.

    Between two poses kept the UAV moves less than `spacing_m`, and so does any distance from it change.
    """
    if len(poses) < 2:
        return poses
    kept, last = [0], poses[0, 1:4]
    for index in range(1, len(poses) - 1):
        position = poses[index, 1:4]
        if np.linalg.norm(position - last) >= spacing_m:
            kept.append(index)
            last = position
    return poses[[*kept, len(poses) - 1]]


def clearances_m(
    clearance: Callable[[Pose], float],
    poses: np.ndarray,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> np.ndarray:
    """Return the distance to the nearest obstacle at each of the poses (n, 8), in metres.

    clearance: distance from the UAV's collision shapes at a pose to the nearest other shape but the ground
    (`PhysicsWorld.clearance`). progress: told now and then how many poses of how many are done.
    """
    distances = np.empty(len(poses))
    for index, (_, x, y, z, *quaternion) in enumerate(poses.tolist()):
        distances[index] = clearance(Pose((x, y, z), tuple(quaternion)))
        if index % 200 == 0:
            progress(index, len(poses))
    return distances
