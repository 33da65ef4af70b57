"""Dark ridges of a rough surface (concrete, asphalt, scale), judged against their own neighbourhood."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from inspection.findings.picture.kernels import raise_to_multiples, ridge_strength
from inspection.findings.picture.smoothing import gaussian_weights, smoothed_rows

SCALES_PX = (1.5, 2.0, 3.0)
"""Standard deviations of the smoothing: a ridge answers most at half its width."""
DARKEST = 0.003
"""Of white. It is added to the light before its logarithm, which would else tell noise in the dark."""
TRUNCATE = 3.0
"""The smoothing's kernel ends after so many standard deviations."""
BLOCK_PX, STRIP_PX = 32, 64
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
    above, strength = np.zeros(light.shape, np.float32), np.zeros(light.shape, np.float32)
    for scale_px in SCALES_PX:
        weights = gaussian_weights(float(np.sqrt(scale_px**2 - smooth_px**2)), TRUNCATE)
        _write_strength(strength, light, weights, scale_px**2)
        raise_to_multiples(above, strength, *_usual(strength), LEAST_USUAL)
    return above


def strong_ridges(above: np.ndarray) -> np.ndarray:
    """Return (height, width) bool: the ridges that are strong somewhere. above: multiples of the usual."""
    numbers, count = ndimage.label(above > WEAK, ALSO_CORNERS)
    is_strong = np.zeros(count + 1, bool)
    is_strong[numbers[above > STRONG]] = True
    is_strong[0] = False
    found: np.ndarray = is_strong[numbers]
    return found


def _write_strength(strength: np.ndarray, light: np.ndarray, weights: np.ndarray, factor: float) -> None:
    """Write the strength of the smoothed ridges, (height, width), float32, some rows at a time.

    So a picture of 12 megapixels needs no third and fourth array of its size. The border has no strength.
    """
    height, reach = len(light), len(weights) - 1
    for first in range(1, height - 1, STRIP_PX):
        end = min(first + STRIP_PX, height - 1)
        low, high = max(first - 1 - reach, 0), min(end + 1 + reach, height)
        logarithm = np.log(light[low:high] + np.float32(DARKEST))
        rows = smoothed_rows(logarithm, weights, first - 1 - low, end + 1 - low)
        strength[first:end] = ridge_strength(rows, factor)[1:-1]


def _usual(strength: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (rows, columns) the usual strength around blocks; y and x: each pixel's place among them."""
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
    return usual.astype(np.float64), y, x
