"""Dark ridges of a rough surface (concrete, asphalt, scale), judged against their own neighbourhood."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from inspection_tools.findings.picture.kernels import ridge_strength

SCALES_PX = (1.5, 2.0, 3.0)
"""Standard deviations of the smoothing: a ridge answers most at half its width."""
DARKEST = 0.003
"""Of white. It is added to the light before its logarithm, which would else tell noise in the dark."""
BLOCK_PX = 32
USUAL_SHARE, LEAST_USUAL = 75.0, 0.004
"""The usual strength around a place: this percentile of its block, and at least this on a plain surface."""
AROUND_BLOCKS = 5
"""Blocks along a side, of which the middle one counts: so a crack does not hide itself."""
WEAK, STRONG = 2.0, 4.0
"""Multiples of the usual strength: a ridge has a strong place, and goes on where it is weak (hysteresis)."""
ALSO_CORNERS = np.ones((3, 3), bool)


def ridges_above_usual(light: np.ndarray, smooth_px: float) -> np.ndarray:
    """Return (height, width), float32: the strength of dark ridges as a multiple of what is usual around.

    The largest eigenvalue of the Hessian of the light's logarithm, times the scale's square (Lindeberg 1998):
    the greatest over the scales.

    light: (height, width), float32, smoothed by smooth_px.
    """
    above = np.zeros(light.shape, np.float32)
    logarithm = np.log(light + np.float32(DARKEST))
    for scale_px in SCALES_PX:
        more_px = float(np.sqrt(scale_px**2 - smooth_px**2))
        strength = ridge_strength(ndimage.gaussian_filter(logarithm, more_px, truncate=3.0), scale_px**2)
        np.maximum(above, strength / _usual(strength), out=above)
    return above


def strong_ridges(above: np.ndarray) -> np.ndarray:
    """Return (height, width) bool: the ridges that are strong somewhere. above: multiples of the usual."""
    numbers, count = ndimage.label(above > WEAK, ALSO_CORNERS)
    is_strong = np.zeros(count + 1, bool)
    is_strong[np.unique(numbers[above > STRONG])] = True
    is_strong[0] = False
    found: np.ndarray = is_strong[numbers]
    return found


def _usual(strength: np.ndarray) -> np.ndarray:
    """Return (height, width), float32: the usual strength around each pixel."""
    height, width = strength.shape
    rows, columns = max(height // BLOCK_PX, 1), max(width // BLOCK_PX, 1)
    side_y, side_x = min(BLOCK_PX, height), min(BLOCK_PX, width)
    blocks = strength[: rows * side_y, : columns * side_x].reshape(rows, side_y, columns, side_x)[
        :, ::2, :, ::2
    ]
    usual = np.percentile(blocks.swapaxes(1, 2).reshape(rows, columns, -1), USUAL_SHARE, axis=2)
    usual = ndimage.median_filter(usual, AROUND_BLOCKS, mode="nearest")
    y = np.clip((np.arange(height) + 0.5) / side_y - 0.5, 0, rows - 1)
    x = np.clip((np.arange(width) + 0.5) / side_x - 0.5, 0, columns - 1)
    across = np.stack([np.interp(x, np.arange(columns), row) for row in usual])
    below = np.minimum(y.astype(int) + 1, rows - 1)
    part = (y - y.astype(int))[:, None]
    found = (1.0 - part) * across[y.astype(int)] + part * across[below]
    return np.maximum(found, LEAST_USUAL).astype(np.float32)
