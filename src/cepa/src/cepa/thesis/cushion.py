"""The safety cushions SC_r(psi, v), as the thesis writes them, and the edge of the emergency.

psi is an angle relative to the direction of travel, wrapped to (-pi, pi]. A cushion's edge is given by its
distance from the UAV. The compiled code has faster forms of the same equations. The tests compare both.
"""

from __future__ import annotations

import math

import numpy as np


def original_cushion(psi: float | np.ndarray, speed: float, radius: float, time_horizon: float) -> np.ndarray:
    """Return the edge of the original cushion in m (equation 6.2: a round end) for angles ``psi`` in rad."""
    distance = speed * time_horizon
    gamma = math.atan2(radius, distance)
    angle = np.abs(np.asarray(psi, dtype=float))
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        side = radius / np.sin(angle)
        end = distance * np.cos(angle) + np.sqrt(radius**2 - distance**2 * np.sin(angle) ** 2)
    return np.where(angle <= gamma, end, np.where(angle < math.pi / 2, side, radius))


def improved_cushion(psi: float | np.ndarray, speed: float, radius: float, time_horizon: float) -> np.ndarray:
    """Return the edge of the improved cushion in m (equation 6.7: an arc as its end) for ``psi`` in rad."""
    distance = speed * time_horizon + radius
    gamma = math.asin(radius / distance)
    angle = np.abs(np.asarray(psi, dtype=float))
    with np.errstate(divide="ignore", over="ignore"):
        side = radius / np.sin(angle)
    return np.where(angle <= gamma, distance, np.where(angle < math.pi / 2, side, radius))


def stopping_distance(speed: float, deceleration: float, latency: float) -> float:
    """Return the distance in m in which the UAV stops from ``speed`` (m/s): v^2 / 2a + v * latency."""
    return speed * speed / (2.0 * deceleration) + speed * latency


def emergency_edge(psi: float | np.ndarray, stopping_m: float, r_lb: float, body_radius: float) -> np.ndarray:
    """Return the range in m within which an obstacle at ``psi`` (rad, from the own velocity) is an emergency.

    It is r_lb in every direction. While the UAV brakes over ``stopping_m``, its body sweeps a corridor that
    reaches ``body_radius`` to each side. Inside this corridor the edge lies ``stopping_m`` farther away. It
    ends in an arc about the UAV, as in equation 6.7.
    """
    angle = np.abs(np.asarray(psi, dtype=float))
    with np.errstate(divide="ignore", over="ignore"):
        side = np.where(angle < math.pi / 2, body_radius / np.sin(angle), 0.0)
    return np.maximum(r_lb, np.minimum(r_lb + stopping_m, side))
