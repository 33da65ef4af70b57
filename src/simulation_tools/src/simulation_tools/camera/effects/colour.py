"""What lies on the coating and changes its colour: older paint, scale, dirt, runs of rust, water."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.camera.effects.amounts import EFFECTS
from simulation_tools.camera.effects.layout import STEEP
from simulation_tools.camera.effects.relief import (
    BEAD_HALF_M,
    HEIGHT_M,
    LENGTH_M,
    PITTING,
    SCALE,
    WELDS,
    flake,
    off_seam,
    pit,
    unit,
)
from simulation_tools.camera.kernels import sample

DIRT, PATCHES, RUNS, COATINGS, WET = (
    EFFECTS.index(name) for name in ("dirt", "patches", "runs", "coatings", "wet")
)
TOE, TOE_M = 0.35, 0.0008
"""The toe of a bead, where dirt stays, is so much darker, and about so wide."""
PATCH_CELL_M = 1.6
"""At most one patch of older paint lies in a cell of this size."""
PAINTS = np.array(((0.70, 0.72, 0.74), (1.20, 1.18, 1.14), (0.45, 0.13, 0.09), (0.62, 0.74, 0.66)))
"""Of older paint, as multiples of the coating's light: dark grey, fresh, red oxide primer, green."""
LOW, HIGH, DECK = np.array((0.62, 0.60, 0.50)), np.array((1.05, 0.98, 0.82)), np.array((0.70, 0.80, 0.76))
"""Of other coatings: below and above the bands, and on what is level."""
RUST = np.array((0.80, 0.40, 0.20))
"""What a run of rust lets pass."""
FLAKES, HOLES, DUST, TOES = (
    np.array(each) for each in ((0.42, 0.43, 0.47), (0.45, 0.40, 0.36), (0.30, 0.27, 0.23), (0.0, 0.0, 0.0))
)
"""Of mill scale, pits, dirt and the toes of beads, as multiples of the coating's light."""
RUN_CELL_M, LONGEST_RUN_M = 0.1, 1.2
"""At most one run hangs in each cell of an edge."""
WET_LIGHT = 0.65
"""Of the light, that a wet coating gives back (Lekner and Dorf 1988 give 0.5 to 0.8 for rough grey ones)."""


@njit(cache=True, fastmath=True)
def tinted(rgb: np.ndarray, share: float, paint: np.ndarray) -> None:
    """Multiply rgb (3,) by a paint (3,), as far as it covers."""
    for c in range(3):
        rgb[c] *= 1.0 + share * (paint[c] - 1.0)


@njit(cache=True, fastmath=True)
def run(u: float, drop: float, edge: int, amount: float, seed: int) -> float:
    """Return how dense a run of rust is, 0..1, so far below an edge of this number. u: along the edge, m."""
    if drop < 0.0 or drop > LONGEST_RUN_M:
        return 0.0
    cell = math.floor(u / RUN_CELL_M)
    if unit(cell, edge, seed + 21) > 0.45 * amount:
        return 0.0
    length = 0.15 + (LONGEST_RUN_M - 0.15) * unit(cell, edge, seed + 22) ** 2
    if drop >= length:
        return 0.0
    left = 1.0 - drop / length
    sway = unit(cell, edge, seed + 23)
    middle = (cell + 0.3 + 0.4 * sway) * RUN_CELL_M + 0.004 * math.sin(9.0 * drop + 20.0 * sway)
    half = (0.006 + 0.02 * unit(cell, edge, seed + 24)) * (0.5 + 0.5 * left)
    off = (u - middle) / half
    return 0.9 * math.sqrt(left) * max(0.0, 1.0 - off * off)


@njit(cache=True, fastmath=True)
def runs_at(
    u: float, v: float, amount: float, seed: int, seams: np.ndarray, first: int, last: int, edges: np.ndarray
) -> float:
    """Return how dense the densest run is at a place. first, last: of the face's edges."""
    above = seams[1] + HEIGHT_M * math.ceil((v - seams[1]) / HEIGHT_M)
    most = run(u, above - v, math.floor(above * 10.0), amount, seed)
    for k in range(first, last):
        if edges[k, 0] <= u <= edges[k, 1]:
            most = max(most, run(u, edges[k, 2] - v, math.floor(edges[k, 2] * 1000.0), amount, seed + 7))
    return most


@njit(cache=True, fastmath=True)
def older_paint(u: float, v: float, amount: float, seed: int, shift: np.ndarray, clouds: np.ndarray) -> tuple:
    """Return the number of the paint of a patch, and its share, 0..1."""
    i, j = math.floor(u / PATCH_CELL_M), math.floor(v / PATCH_CELL_M)
    own = seed + int(shift[0])
    if unit(i, j, own + 31) > 0.6 * amount:
        return 0, 0.0
    half_u = (0.06 + 0.25 * unit(i, j, own + 32)) * PATCH_CELL_M
    half_v = (0.06 + 0.25 * unit(i, j, own + 33)) * PATCH_CELL_M
    x = (i + 0.4 + 0.2 * unit(i, j, own + 34)) * PATCH_CELL_M
    y = (j + 0.4 + 0.2 * unit(i, j, own + 35)) * PATCH_CELL_M
    inside = min(half_u - abs(u - x), half_v - abs(v - y))
    inside += 0.006 * sample(clouds, u / 0.015 + shift[0], v / 0.015 + shift[1])
    return int(4.0 * unit(i, j, own + 36)) & 3, min(max(inside / 0.004, 0.0), 1.0)


@njit(cache=True, fastmath=True)
def dirt_at(u: float, v: float, steep: bool, shift: np.ndarray, clouds: np.ndarray) -> float:
    """Return how dense dirt is, 0..1: dust in clouds, and streaks where water has run down."""
    dust = sample(clouds, u / 0.04 + shift[1] + 97.0, v / 0.04 + shift[0])
    dense = 0.25 + 0.22 * dust
    if steep:
        dense += 0.12 * sample(clouds, u / 0.008 + shift[0], v / 0.25 + shift[1] + 211.0)
    return min(max(dense, 0.0), 0.9)


@njit(cache=True, fastmath=True)
def film(u: float, v: float, amount: float, shift: np.ndarray, clouds: np.ndarray) -> float:
    """Return how much of a film of water lies at a place, 0..1; with the amount 1 it is everywhere."""
    if amount >= 1.0:
        return 1.0
    noise = sample(clouds, u / 0.06 + shift[0] + 305.0, v / 0.06 + shift[1] + 17.0)
    return min(max((noise + 5.0 * amount - 2.5) * 4.0, 0.0), 1.0)


@njit(cache=True, fastmath=True)
def coat(u: float, v: float, face: int, footprint: float, layout: tuple, rgb: np.ndarray) -> None:
    """Multiply rgb (3,) by what lies on a place of a face. layout: a `Layout`."""
    amounts, seed, seams, bands, shifts, axes, offsets, first, edges, clouds = layout
    shift, steep = shifts[face], abs(axes[face, 0, 2]) < STEEP
    if amounts[COATINGS] > 0.0:
        z = u * axes[face, 1, 2] + v * axes[face, 2, 2] + offsets[face] * axes[face, 0, 2]
        if not steep:
            tinted(rgb, amounts[COATINGS], DECK)
        else:
            tinted(rgb, amounts[COATINGS] * min(max((bands[0] - z) / footprint + 0.5, 0.0), 1.0), LOW)
            tinted(rgb, amounts[COATINGS] * min(max((z - bands[1]) / footprint + 0.5, 0.0), 1.0), HIGH)
    if amounts[PATCHES] > 0.0:
        paint, share = older_paint(u, v, amounts[PATCHES], seed, shift, clouds)
        tinted(rgb, share, PAINTS[paint])
    if amounts[SCALE] > 0.0:
        tinted(rgb, flake(u, v, amounts[SCALE], shift, clouds), FLAKES)
    if amounts[PITTING] > 0.0:
        far, _ = pit(u, v, amounts[PITTING], seed, shift, clouds)
        tinted(rgb, 1.0 - far**4, HOLES)
    if amounts[WELDS] > 0.0:
        across = abs(off_seam(v, seams[1], HEIGHT_M))
        off = (min(across, abs(off_seam(u, seams[0], LENGTH_M))) - BEAD_HALF_M) / max(TOE_M, 0.5 * footprint)
        dark = TOE * min(1.0, 2.0 * TOE_M / footprint) * math.exp(-off * off)
        tinted(rgb, amounts[WELDS] * dark, TOES)
    if amounts[RUNS] > 0.0 and steep:
        dense = runs_at(u, v, amounts[RUNS], seed, seams, first[face], first[face + 1], edges)
        tinted(rgb, dense, RUST)
    if amounts[DIRT] > 0.0:
        tinted(rgb, amounts[DIRT] * dirt_at(u, v, steep, shift, clouds), DUST)
    if amounts[WET] > 0.0:
        share = film(u, v, amounts[WET], shift, clouds)
        for c in range(3):
            rgb[c] *= 1.0 + share * (WET_LIGHT - 1.0)
