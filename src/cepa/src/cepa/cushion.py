"""The safety cushions SC_r(psi, v), as the thesis writes them.

psi is an angle relative to the direction of travel, wrapped to (-pi, pi]; the edge is its distance from the
UAV. The compiled code has faster forms of the same; the tests compare.
"""

from __future__ import annotations

import math

import numpy as np


def original_cushion(psi, speed: float, radius: float, time_horizon: float) -> np.ndarray:
    """Return the edge of the original cushion in m (equation 6.2: a round end) for angles ``psi`` in rad."""
    distance = speed * time_horizon
    gamma = math.atan2(radius, distance)
    angle = np.abs(np.asarray(psi, dtype=float))
    with np.errstate(divide="ignore", invalid="ignore"):
        side = radius / np.sin(angle)
        end = distance * np.cos(angle) + np.sqrt(radius**2 - distance**2 * np.sin(angle) ** 2)
    return np.where(angle <= gamma, end, np.where(angle < math.pi / 2, side, radius))


def improved_cushion(psi, speed: float, radius: float, time_horizon: float) -> np.ndarray:
    """Return the edge of the improved cushion in m (equation 6.7: an arc as its end) for ``psi`` in rad."""
    distance = speed * time_horizon + radius
    gamma = math.asin(radius / distance)
    angle = np.abs(np.asarray(psi, dtype=float))
    with np.errstate(divide="ignore"):
        side = radius / np.sin(angle)
    return np.where(angle <= gamma, distance, np.where(angle < math.pi / 2, side, radius))
