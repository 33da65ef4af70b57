"""Clouds of a level Puck in an empty hold, computed from its walls."""

from __future__ import annotations

import numpy as np

HOLD = (np.zeros(3), np.array((30.0, 20.0, 10.0)))
"""Two corners, m."""


def puck_directions(columns=1800):
    """Unit vectors (16 * columns, 3) of a Puck's beams in its own frame."""
    azimuth, elevation = np.meshgrid(
        np.arange(columns) * 2.0 * np.pi / columns, np.radians(np.arange(-15, 16, 2))
    )
    flat = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1) * np.cos(elevation)[..., None]
    return np.concatenate([flat, np.sin(elevation)[..., None]], axis=-1).reshape(-1, 3)


def ranges_in_hold(position, directions, noise_m=0.01, seed=0):
    """Ranges (n,) from a position to the hold's walls along directions (n, 3)."""
    low, high = HOLD
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ways = np.where(directions > 0.0, (high - position) / directions, (low - position) / directions)
    ways[directions == 0.0] = np.inf
    return ways.min(axis=1) + np.random.default_rng(seed).normal(0.0, noise_m, len(directions))


def puck_in_hold(position, seed=0, columns=1800):
    """A level Puck's position and points (n, 3), float32 in the map's frame."""
    directions = puck_directions(columns)
    points = (
        np.array(position) + directions * ranges_in_hold(np.array(position), directions, seed=seed)[:, None]
    )
    return np.array(position, np.float32), points.astype(np.float32)
