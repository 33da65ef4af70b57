"""Procedural textures: tiles of noise that repeat without a seam."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

TILE = 1024
"""Texels along a tile's side."""


@lru_cache(maxsize=4)
def clouds(seed: int, slope: float) -> np.ndarray:
    """Return (TILE, TILE), float32, mean 0, standard deviation 1, spectrum as 1 / frequency ** slope."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(np.fft.fftfreq(TILE)[:, None], np.fft.rfftfreq(TILE)[None, :])
    frequency[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.standard_normal((TILE, TILE))) / frequency**slope
    tile = np.fft.irfft2(spectrum, (TILE, TILE))
    return np.ascontiguousarray(tile / tile.std(), np.float32)


@lru_cache(maxsize=4)
def grain(seed: int) -> np.ndarray:
    """Return (1 << 20,) float32 standard normal numbers: the noise of pixels, read from random places."""
    return np.random.default_rng(seed).standard_normal(1 << 20, np.float32)


def levels(tile: np.ndarray, number: int) -> np.ndarray:
    """Return (number, TILE, TILE): the tile as seen with texels 1, 2, 4, ... times as large."""
    stack = [tile]
    for step in range(number - 1):
        last, shift = stack[-1], 1 << step
        wide = 0.5 * (last + np.roll(last, -shift, axis=1))
        stack.append(0.5 * (wide + np.roll(wide, -shift, axis=0)))
    return np.stack(stack).astype(np.float32)
