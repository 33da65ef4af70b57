"""Candidates in one photograph: rust by its colour, cracks as thin dark ridges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection_tools.findings.kernels import block_light, dark_ridges
from inspection_tools.findings.parameters import FindingParameters

BLOCK_PX = 4
"""Colour is judged in blocks: single pixels are noisy, and JPEG halves the colour's resolution."""
LEAST_LIGHT = 0.002
"""Of white; darker blocks have no colour that one could judge."""
SMOOTH_PX, REACH_PX, LEAST_PX, THICK_PX = 1.0, 5, 24, 7.0
MOST_PIXELS = 400
"""Of one candidate, drawn evenly."""


class Candidate(NamedTuple):
    """kind: rust or crack. pixels: (n, 2) some of its places, x, y, px. size_px: number of all its pixels."""

    kind: str
    pixels: np.ndarray
    size_px: int


def candidates_in(picture: np.ndarray, parameters: FindingParameters) -> list[Candidate]:
    """Return the candidates in a picture, uint8 (height, width, 3), sRGB."""
    rust = _rust_blocks(picture, parameters)
    found = [
        Candidate("rust", _some(places) * BLOCK_PX + 0.5 * (BLOCK_PX - 1), len(places) * BLOCK_PX**2)
        for places in _groups(rust)
        if len(places) >= 4
    ]
    ridges = dark_ridges(_light(picture), REACH_PX, parameters.crack_contrast)
    near = ndimage.binary_dilation(rust, iterations=3)
    near = np.repeat(np.repeat(near, BLOCK_PX, axis=0), BLOCK_PX, axis=1)
    ridges[: near.shape[0], : near.shape[1]] &= ~near  # rust has dark pits and borders
    for places in _groups(ridges):
        length_px = float(np.hypot(*np.ptp(places, axis=0)))
        if length_px >= LEAST_PX and len(places) <= THICK_PX * length_px:
            found.append(Candidate("crack", _some(places).astype(float), len(places)))
    return found


def _rust_blocks(picture: np.ndarray, parameters: FindingParameters) -> np.ndarray:
    light = block_light(picture, _linear(), BLOCK_PX)
    total = light.sum(axis=2)
    red, green, blue = np.moveaxis(light, 2, 0)
    brown = (red - blue > parameters.rust_colour * total) & (red > parameters.rust_red * green)
    return brown & (total > 3.0 * LEAST_LIGHT)


def _light(picture: np.ndarray) -> np.ndarray:
    """Return (height, width), float32: the light of green, which has the least noise, smoothed a little."""
    return ndimage.gaussian_filter(_linear()[picture[..., 1]], SMOOTH_PX, truncate=2.5)


def _linear() -> np.ndarray:
    """Return (256,), float32: the light of sRGB values (IEC 61966-2-1)."""
    value = np.arange(256) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)


def _groups(marked: np.ndarray) -> list[np.ndarray]:
    """Return the places (n, 2), x, y, of each group of marked pixels that touch, corners included."""
    numbers, count = ndimage.label(marked, np.ones((3, 3)))
    y, x = np.nonzero(numbers)
    of = numbers[y, x]
    order = np.argsort(of, kind="stable")
    places = np.column_stack((x, y))[order]
    return np.split(places, np.searchsorted(of[order], np.arange(2, count + 1))) if count else []


def _some(places: np.ndarray) -> np.ndarray:
    return places[:: max(1, len(places) // MOST_PIXELS)]
