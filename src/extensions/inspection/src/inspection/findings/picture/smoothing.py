"""Gaussian smoothing, rows at a time, so that a large picture needs no copy of itself beside its result."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit


def smoothed(values: np.ndarray, deviation_px: float, truncate: float) -> np.ndarray:
    """Return (height, width), float32: values, float32, as `scipy.ndimage.gaussian_filter` smooths them.

    truncate: the kernel ends after so many standard deviations. Borders are reflected.
    """
    return smoothed_rows(values, gaussian_weights(deviation_px, truncate), 0, values.shape[0])


def gaussian_weights(deviation_px: float, truncate: float) -> np.ndarray:
    """Return (n + 1,) weights of the places 0 to n px from the middle; those of both sides add up to 1."""
    reach = int(truncate * deviation_px + 0.5)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation_px) ** 2)
    one_side: np.ndarray = (weights / weights.sum())[reach:]
    return one_side


@njit(cache=True)
def smoothed_rows(values: np.ndarray, weights: np.ndarray, first: int, end: int) -> np.ndarray:
    """Return (end - first, width), float32: some rows of values, float32, smoothed in both directions.

    The sums have the order of scipy's, in float64, so that the last bit is the same.
    """
    height, width = values.shape
    reach = len(weights) - 1
    out = np.empty((end - first, width), np.float32)
    sums = np.empty(width, np.float64)
    padded = np.empty(width + 2 * reach, np.float64)
    for row in range(first, end):
        for x in range(width):
            sums[x] = values[row, x] * weights[0]
        for off in range(reach, 0, -1):
            above, below, weight = _reflected(row - off, height), _reflected(row + off, height), weights[off]
            for x in range(width):
                sums[x] += (np.float64(values[above, x]) + np.float64(values[below, x])) * weight
        for x in range(width):
            padded[reach + x] = np.float32(sums[x])
        for off in range(1, reach + 1):
            padded[reach - off] = padded[reach + _reflected(-off, width)]
            padded[reach + width - 1 + off] = padded[reach + _reflected(width - 1 + off, width)]
        for x in range(width):
            sums[x] = padded[reach + x] * weights[0]
        for off in range(reach, 0, -1):
            weight = weights[off]
            for x in range(width):
                sums[x] += (padded[reach + x - off] + padded[reach + x + off]) * weight
        for x in range(width):
            out[row - first, x] = sums[x]
    return out


@njit(cache=True)
def _reflected(place: int, size: int) -> int:
    """Return the place in an array that a place beyond its borders mirrors, the border's included."""
    place %= 2 * size
    return place if place < size else 2 * size - 1 - place
