"""Condensation: drops and fog on the lens. They stay where they are on it, in all photographs."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from kernel_cache.compiler import njit

COPY_PX = 640
"""The light that drops scatter is that of a copy about so wide."""
DROPS, RADIUS = 60, (0.004, 0.02)
"""Number of drops, and their radius, of the picture's width."""
FOG, VEIL, BLUR = 0.4, 0.25, 0.012
"""Of fog: the most that it covers; share of the picture's mean that it scatters; its blur, of the width."""


def through_condensation(raw: np.ndarray, amount: float, seed: int) -> None:
    """Change a linear picture (height, width, 3), uint16, to what a lens with drops and fog shows."""
    step = max(1, raw.shape[1] // COPY_PX)
    small = raw[::step, ::step].astype(np.float32)
    sigma = BLUR * small.shape[1]
    blurred = ndimage.gaussian_filter(small, (sigma, sigma, 0))
    blurred = (1.0 - VEIL) * blurred + VEIL * small.mean(axis=(0, 1))
    covered = np.ascontiguousarray(drops_and_fog(small.shape[:2], amount, seed), np.float32)
    mix(raw, np.ascontiguousarray(blurred, np.float32), covered, step)


def drops_and_fog(shape: tuple[int, ...], amount: float, seed: int) -> np.ndarray:
    """Return (height, width) how much of each pixel condensation covers, 0..1."""
    rng, (height, width) = np.random.default_rng((seed, 51)), shape
    grid = rng.standard_normal((6, 8))
    rows, columns = np.meshgrid(np.linspace(0, 5, height), np.linspace(0, 7, width), indexing="ij")
    noise = ndimage.map_coordinates(grid, (rows, columns), order=3, mode="nearest")
    covered = amount * FOG * np.clip(0.5 + 0.5 * noise, 0.0, 1.0)
    y, x = np.indices(shape)
    for _ in range(round(DROPS * amount)):
        across, down, size = rng.random(3)
        radius = width * (RADIUS[0] + (RADIUS[1] - RADIUS[0]) * size**2)
        off = np.hypot(x - across * width, y - down * height)
        covered = np.maximum(covered, np.clip(0.9 * (radius - off) + 0.5, 0.0, 0.9))
    return covered


@njit(cache=True, fastmath=True)
def mix(raw: np.ndarray, blurred: np.ndarray, covered: np.ndarray, step: int) -> None:
    """Put a blurred copy, each step-th pixel, over a picture, as far as it is covered."""
    last_y, last_x = covered.shape[0] - 1, covered.shape[1] - 1
    for y in range(raw.shape[0]):
        j = min(y // step, last_y)
        b, m = min(y / step - j, 1.0), min(j + 1, last_y)
        for x in range(raw.shape[1]):
            i = min(x // step, last_x)
            a, k = min(x / step - i, 1.0), min(i + 1, last_x)
            p, q, r, s = (1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b
            much = p * covered[j, i] + q * covered[j, k] + r * covered[m, i] + s * covered[m, k]
            for c in range(3):
                far = (
                    p * blurred[j, i, c] + q * blurred[j, k, c] + r * blurred[m, i, c] + s * blurred[m, k, c]
                )
                raw[y, x, c] = np.uint16(raw[y, x, c] * (1.0 - much) + much * far)
