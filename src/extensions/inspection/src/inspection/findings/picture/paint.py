"""Paint that is as red as rust: what is told by colour there, and what is not."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from scipy import ndimage

RED = "red"
"""Kind of a candidate that is rust, or a coating of its colour: one photograph does not tell which."""
MOST = 0.95
"""Share of what is lit in a photograph that is red where its coating may be."""
LEAST_APART, NOISES = 0.04, 5.0
"""Two colours differ if their shares of red and blue do by so much, and by so many times the noise."""

SMOOTH_BLOCKS, BESIDE_BLOCKS = 3, 7
"""Blocks along the sides of what is smoothed, and in which the clearest colour counts."""


def shares_of(light: np.ndarray) -> np.ndarray:
    """Return (..., 2): the shares of red and blue in light (..., 3)."""
    shares: np.ndarray = light[..., (0, 2)] / np.maximum(light.sum(axis=-1), 1e-6)[..., None]
    return shares


def is_all_red(red: np.ndarray, lit: np.ndarray) -> bool:
    """Return whether nearly all blocks (h, w) of a photograph that are lit have the colour of rust."""
    return bool(lit.any() and red[lit].mean() >= MOST)


def unlike_the_most(light: np.ndarray, red: np.ndarray) -> np.ndarray:
    """Return which red blocks (h, w) have another colour than most of them. light: (h, w, 3)."""
    off = _off(light, np.median(shares_of(light)[red], axis=0), red)
    noise = 1.48 * float(np.median(off[red]))
    return _unlike(off, max(LEAST_APART, NOISES * noise))


def unlike_coatings(light: np.ndarray, red: np.ndarray, coatings: Sequence[np.ndarray]) -> np.ndarray:
    """Return which red blocks (h, w) have the colour of none of the coatings, each (3,) light."""
    shares, unlike = shares_of(light), red
    for coating in coatings:
        unlike = unlike & (np.linalg.norm(shares - shares_of(coating), axis=2) > LEAST_APART)
    opened: np.ndarray = ndimage.binary_opening(unlike, np.ones((2, 2), bool))  # no rims of a coating
    return opened


def _off(light: np.ndarray, shares: np.ndarray, red: np.ndarray) -> np.ndarray:
    """Return (h, w) how far the shares of red and blue are from those of a coating; 0: it is not red."""
    smooth = ndimage.uniform_filter(light, (SMOOTH_BLOCKS, SMOOTH_BLOCKS, 0))
    off: np.ndarray = np.where(red, np.linalg.norm(shares_of(smooth) - shares, axis=2), 0.0)
    return off


def _unlike(off: np.ndarray, least: float) -> np.ndarray:
    """Return where a colour is off, up to where it is so by half as much as beside: there it covers half."""
    beside = ndimage.maximum_filter(off, BESIDE_BLOCKS)
    unlike: np.ndarray = (off > 0.5 * beside) & (beside > least) & (off > 0.5 * least)
    return unlike


def told_of_paint(red: int, searched: int) -> str:
    """Return what is told where so many of all photographs show little but the colour of rust."""
    return (
        f"{red} of {searched} photographs show little but the colour of rust, so it counts as the coating's. "
        "Rust of another colour is found, rust of this colour cannot be told from the coating. Give the "
        "coating's colour, if you know it: findings --coating R,G,B."
    )
