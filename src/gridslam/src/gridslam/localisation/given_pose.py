"""Checks a pose that somebody gives, as with `initialpose`."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam.errors import PoseError
from gridslam.occupancy_grid import OccupancyGrid


def check_given_pose(pose: Sequence[float], covariance: np.ndarray, grid: OccupancyGrid | None) -> None:
    """Refuse a pose (3,) and its covariance (3, 3) that make no sense, or lie outside the map.

    Args:
        pose: x, y in m and yaw in rad of the base in the map.
        covariance: of the pose, m2, m rad and rad2.
        grid: the map; None: there is none yet.

    Raises:
        PoseError: it says why.
    """
    checked, spread = np.array(pose, float), np.array(covariance, float)
    if checked.shape != (3,) or not np.isfinite(checked).all():
        raise PoseError(f"A pose must be finite x, y and yaw, not {checked.tolist()}.")
    if spread.shape != (3, 3) or not np.isfinite(spread).all():
        raise PoseError("The pose's covariance must be finite numbers for x, y and yaw.")
    tolerance = 1e-9 * max(1.0, float(np.abs(spread).max()))
    if not np.allclose(spread, spread.T, atol=tolerance) or np.linalg.eigvalsh(spread)[0] < -tolerance:
        raise PoseError("The pose's covariance must be symmetric, without a negative variance.")
    if grid is None:
        raise PoseError("There is no map yet on which a pose could be.")
    low = np.array(grid.origin_xy_m)
    high = low + grid.size_m
    if not ((low <= checked[:2]) & (checked[:2] <= high)).all():
        raise PoseError(
            f"The pose x {checked[0]:.2f} m, y {checked[1]:.2f} m is outside the map, which reaches from "
            f"x {low[0]:.2f} to {high[0]:.2f} m and from y {low[1]:.2f} to {high[1]:.2f} m."
        )
