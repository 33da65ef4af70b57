"""How high the surface stands over its plane: beads of welds, dished plates, flakes of scale, pits."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.camera.effects.amounts import EFFECTS
from simulation_tools.camera.effects.layout import PLATE_M
from simulation_tools.camera.kernels import sample

WELDS, WAVINESS, SCALE, PITTING = (EFFECTS.index(name) for name in ("welds", "waviness", "scale", "pitting"))
LENGTH_M, HEIGHT_M = PLATE_M
BEAD_HALF_M, BEAD_HEIGHT_M = 0.006, 0.0025
"""Half width and height of a bead. ISO 5817 allows 1 mm and a tenth of the width over the plate."""
RIPPLE, RIPPLE_M = 0.2, 0.004
"""Of a bead's height, and how far apart its ripples are."""
DISH_M, DISH_HEIGHT_M = 0.75, 0.004
"""From one dish to the next, and its height. Shipyards allow 4 to 8 mm between frames (IACS Rec. 47)."""
FLAKE_M, FLAKE_HEIGHT_M, FLAKE_SOFT = 0.006, 0.001, 0.1
"""Size of a texel of the flakes, their thickness, and how soft their edge is, of the noise."""
PIT_CELL_M, PIT_DEPTH = 0.03, 0.4
"""At most one pit lies in a cell of this size. Its depth is such a share of its radius."""


@njit(cache=True, fastmath=True)
def unit(a: int, b: int, seed: int) -> float:
    """Return a number 0..1 that belongs to two whole numbers and a seed."""
    x = (a * 374761393 + b * 668265263 + seed * 2246822519) & 0xFFFFFFFF
    x = ((x ^ (x >> 13)) * 1274126177) & 0xFFFFFFFF
    return (x ^ (x >> 16)) / 4294967296.0


@njit(cache=True, fastmath=True)
def off_seam(place: float, first: float, apart: float) -> float:
    """Return how far a place is beyond the nearest seam; negative: before it."""
    return place - first - apart * math.floor((place - first) / apart + 0.5)


@njit(cache=True, fastmath=True)
def bead(off: float, along: float, footprint: float) -> float:
    """Return the height of a weld's bead, m. off: from its middle; along: its seam; all m."""
    far = off / BEAD_HALF_M
    if abs(far) >= 1.0:
        return 0.0
    fine = min(1.0, 0.25 * RIPPLE_M / footprint)
    ripple = 1.0 + RIPPLE * fine * math.cos(2.0 * math.pi * along / RIPPLE_M + 2.0 * far * far)
    return BEAD_HEIGHT_M * (1.0 - far * far) * ripple


@njit(cache=True, fastmath=True)
def flake(u: float, v: float, amount: float, shift: np.ndarray, clouds: np.ndarray) -> float:
    """Return how much of a flake of scale lies at a place, 0..1."""
    where = sample(clouds, u / 0.08 + shift[1], v / 0.08 + shift[0])
    edge = sample(clouds, u / FLAKE_M + shift[0], v / FLAKE_M + shift[1])
    share = (edge + 0.8 * where + 1.6 * amount - 2.2) / FLAKE_SOFT + 0.5
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


@njit(cache=True, fastmath=True)
def pit(u: float, v: float, amount: float, seed: int, shift: np.ndarray, clouds: np.ndarray) -> tuple:
    """Return the share of its radius at which a place lies in a pit, 1: in none, and the radius, m."""
    i, j = math.floor(u / PIT_CELL_M), math.floor(v / PIT_CELL_M)
    where = sample(clouds, u / 0.05 + shift[0] + 411.0, v / 0.05 + shift[1])
    if unit(i, j, seed + 11) > amount * (0.25 + 0.35 * where):
        return 1.0, 0.001
    radius = 0.0015 + 0.0045 * unit(i, j, seed + 12) ** 2
    x = (i + 0.25 + 0.5 * unit(i, j, seed + 13)) * PIT_CELL_M
    y = (j + 0.25 + 0.5 * unit(i, j, seed + 14)) * PIT_CELL_M
    return min(math.hypot(u - x, v - y) / radius, 1.0), radius


@njit(cache=True, fastmath=True)
def height(
    u: float,
    v: float,
    amounts: np.ndarray,
    seed: int,
    seams: np.ndarray,
    shift: np.ndarray,
    clouds: np.ndarray,
    footprint: float,
) -> float:
    """Return the height over the plane at a place of a face, m."""
    total = 0.0
    if amounts[WELDS] > 0.0:
        across, along = off_seam(v, seams[1], HEIGHT_M), off_seam(u, seams[0], LENGTH_M)
        total += amounts[WELDS] * max(bead(across, u, footprint), bead(along, v, footprint))
    if amounts[WAVINESS] > 0.0:
        wave = math.sin(2.0 * math.pi * u / DISH_M) * math.sin(2.0 * math.pi * v / DISH_M)
        total += amounts[WAVINESS] * DISH_HEIGHT_M * wave
    if amounts[SCALE] > 0.0:
        total += FLAKE_HEIGHT_M * flake(u, v, amounts[SCALE], shift, clouds)
    if amounts[PITTING] > 0.0:
        far, radius = pit(u, v, amounts[PITTING], seed, shift, clouds)
        total -= PIT_DEPTH * radius * (1.0 - far * far)
    return total
