"""A decision as plain numbers, for drawing it in RViz or matplotlib."""

from __future__ import annotations

import math

import numpy as np

from cepa.decision import Vector2
from cepa.parameters import CepaParameters
from cepa.scan import Beams, Grid
from cepa.thesis.cushion import emergency_edge, improved_cushion, original_cushion, stopping_distance
from cepa.thesis.emergency import edges
from cepa.thesis.kernels.emergency import k_filter
from cepa.thesis.kernels.valid_directions import valid_directions

OUTLINE_POINTS = 181
STRIP_M = 0.04


def circle(radius: float) -> np.ndarray:
    """Return a closed circle about the UAV, (n, 2) m."""
    return _polar(np.linspace(-math.pi, math.pi, OUTLINE_POINTS), radius)


def cushion_outline(algorithm: str, velocity: Vector2, radius: float, time_horizon: float) -> np.ndarray:
    """Return the closed outline of the cushion along ``velocity``, (n, 2) m: 6.2 for "original", else 6.7."""
    cushion = original_cushion if algorithm == "original" else improved_cushion
    psi = np.linspace(-math.pi, math.pi, 4 * OUTLINE_POINTS)
    speed = math.hypot(*velocity)
    return _polar(psi + math.atan2(velocity[1], velocity[0]), cushion(psi, speed, radius, time_horizon))


def path_edge(path_m: np.ndarray, radius: float) -> np.ndarray:
    """Return the edge of all that is within ``radius`` of a path's points (n, 2), as lines (m, 2, 2), m."""
    psi = np.linspace(-math.pi, math.pi, OUTLINE_POINTS)
    circles = path_m[:, None, :] + _polar(psi, radius)
    lines = np.stack([circles[:, :-1], circles[:, 1:]], axis=2)
    apart = lines.mean(axis=2)[:, :, None, :] - path_m  # from each line's middle to all points of the path
    nearest = np.hypot(apart[..., 0], apart[..., 1]).min(axis=2, initial=math.inf)
    return lines[nearest > (1.0 - 2e-4) * radius]


def path_strips(path_m: np.ndarray, radius: float, width_m: float = STRIP_M) -> np.ndarray:
    """Return the middle lines (m, 2, 2) of strips, ``width_m`` wide, that fill what `path_edge` encloses."""
    if len(path_m) == 0:
        return np.empty((0, 2, 2))
    x, y = path_m.T
    rows = np.arange(y.min() - radius + 0.5 * width_m, y.max() + radius, width_m)
    strips = []
    for row in rows.tolist():
        near = np.abs(row - y) < radius
        half = np.sqrt(radius**2 - (row - y[near]) ** 2)
        order = np.argsort(x[near] - half)
        first, last = (x[near] - half)[order], np.maximum.accumulate((x[near] + half)[order])
        gaps = np.flatnonzero(first[1:] > last[:-1])
        for begin, end in zip(first[[0, *(gaps + 1)]], last[[*gaps, -1]]):
            strips.append([(begin, row), (end, row)])
    return np.array(strips).reshape(-1, 2, 2)


def rejected_directions(beams: Beams, parameters: CepaParameters, reference_speed: float) -> np.ndarray:
    """Return the share of the speed fractions that is rejected per beam, (N,): 0 none, 1 all, nan: unseen."""
    fractions = np.array(parameters.speed_fractions)
    length = fractions * reference_speed * parameters.time_horizon + parameters.r_lb
    grid = Grid(beams.ranges.size, beams.increment)
    everywhere = np.ones_like(beams.seen)
    valid = valid_directions(
        beams.ranges, everywhere, grid.reach, grid.is_even, float(parameters.r_lb), length
    )
    rejected = 1.0 - valid.mean(axis=0)
    return np.where(beams.seen | parameters.unseen_is_free, rejected, np.nan)


def intrusions(beams: Beams, parameters: CepaParameters, v_uav: Vector2 = (0.0, 0.0)) -> np.ndarray:
    """Return what is too near after the K filter, (n, 2 ends, 2) m (figure 6.3); ``v_uav`` in m/s."""
    filtered = k_filter(beams.ranges, float(parameters.k_filter), beams.increment)
    edge = edges(beams, Grid(beams.ranges.size, beams.increment), parameters, v_uav)
    inside = filtered < edge
    direction = beams.angles[inside]
    return np.stack([_polar(direction, edge[inside]), _polar(direction, filtered[inside])], axis=1)


def emergency_outline(parameters: CepaParameters, v_uav: Vector2) -> np.ndarray:
    """Return the closed outline of what is an emergency at the own velocity ``v_uav`` (m/s), (n, 2) m."""
    speed = math.hypot(*v_uav) if parameters.velocity_aware_emergency else 0.0
    stopping = stopping_distance(speed, parameters.braking_deceleration, parameters.braking_latency)
    psi = np.linspace(-math.pi, math.pi, 4 * OUTLINE_POINTS)
    edge = emergency_edge(psi, stopping, parameters.r_lb, parameters.body_radius)
    return _polar(psi + math.atan2(v_uav[1], v_uav[0]), edge)


def _polar(angle: np.ndarray, radius: float | np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angle) * radius, np.sin(angle) * radius], axis=-1)
