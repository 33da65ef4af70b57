"""Candidates in one photograph: rust by its colour, cracks as thin dark lines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection_tools.findings.kernels import block_light, dark_ridges
from inspection_tools.findings.lines import Line, line_through, pieces_joined
from inspection_tools.findings.parameters import FindingParameters

BLOCK_PX = 4
"""Colour is judged in blocks: single pixels are noisy, and JPEG halves the colour's resolution."""
NEAR_BLOCKS = 5
LEAST_LIGHT = 0.01
"""Of white; darker blocks have no colour that one could judge."""
SMOOTH_PX, REACH_PX = 1.0, 5
NOISE_PX = 32
"""Noise is measured in blocks: the sensor's in the dark, and that of a rough surface."""
NOISES = 3.0
"""A ridge is so many times deeper than the noise."""
MOST_PIXELS = 400
"""Of one candidate, drawn evenly."""


class Candidate(NamedTuple):
    """kind: rust or crack. pixels: (n, 2) some of its places, x, y, px. size_px: number of all its pixels."""

    kind: str
    pixels: np.ndarray
    size_px: int


def candidates_in(
    picture: np.ndarray, parameters: FindingParameters, looked_at: np.ndarray | None = None
) -> list[Candidate]:
    """Return the candidates in a picture, uint8 (height, width, 3), sRGB.

    looked_at: (rows, columns) where cracks are looked for, in cells that fill the picture; None: everywhere.
    """
    rust = _rust_blocks(picture, parameters)
    found = [
        Candidate("rust", _some(places) * BLOCK_PX + 0.5 * (BLOCK_PX - 1), len(places) * BLOCK_PX**2)
        for places in _groups(rust)
        if len(places) >= 4
    ]
    light = _light(picture)
    contrasts = _contrasts(light, parameters.crack_contrast, looked_at)
    ridges = dark_ridges(light, REACH_PX, contrasts, NOISE_PX)
    near = ndimage.binary_dilation(rust, iterations=3)
    near = np.repeat(np.repeat(near, BLOCK_PX, axis=0), BLOCK_PX, axis=1)
    ridges[: near.shape[0], : near.shape[1]] &= ~near  # rust has dark pits and borders
    for group in pieces_joined(_groups(ridges)):
        line = line_through(group, light)
        if is_thin(line, parameters):
            found.append(Candidate("crack", _some(line.pixels), len(group)))
    return found


def is_thin(line: Line, parameters: FindingParameters) -> bool:
    """Return whether a line may be a crack: long, thin, dark all along, and alike on both its sides."""
    p = parameters
    return bool(
        line.length_px >= p.line_length
        and line.depth >= 0.7 * p.crack_contrast
        and line.width_px <= p.line_width
        and line.unlike <= p.line_unlike
        and line.filled >= p.line_filled
        and line.rough_px <= p.line_rough
    )


def _contrasts(light: np.ndarray, least: float, looked_at: np.ndarray | None) -> np.ndarray:
    """Return the least contrast of a ridge, in blocks of NOISE_PX px; 1 where nothing is looked for."""
    rows, columns = light.shape[0] // NOISE_PX, light.shape[1] // NOISE_PX
    part = light[: rows * NOISE_PX, : columns * NOISE_PX]
    off = np.abs(part[::2, REACH_PX::2] - part[::2, :-REACH_PX:2])
    off = np.pad(off, ((0, 0), (0, part.shape[1] // 2 - off.shape[1])), mode="edge")
    half = NOISE_PX // 2
    blocks = [
        each.reshape(rows, half, columns, half).swapaxes(1, 2).reshape(rows, columns, -1)
        for each in (off, part[::2, ::2])
    ]
    noise = 1.48 * np.median(blocks[0], axis=2) / np.maximum(np.median(blocks[1], axis=2), 1e-6)
    noise = ndimage.maximum_filter(noise, 3)
    contrasts = np.clip(NOISES * noise, least, 1.0)
    if looked_at is not None:
        y = np.minimum((np.arange(rows) + 0.5) / rows * looked_at.shape[0], looked_at.shape[0] - 1).astype(
            int
        )
        x = np.minimum((np.arange(columns) + 0.5) / columns * looked_at.shape[1], looked_at.shape[1] - 1)
        contrasts[~looked_at[np.ix_(y, x.astype(int))]] = 1.0
    return contrasts.astype(np.float32)


def _rust_blocks(picture: np.ndarray, parameters: FindingParameters) -> np.ndarray:
    """Return which blocks are rust. Red is compared with green in all coloured blocks nearby, for noise."""
    light = block_light(picture, _linear(), BLOCK_PX)
    total = light.sum(axis=2)
    red, green, blue = np.moveaxis(light, 2, 0)
    coloured = (red - blue > parameters.rust_colour * total) & (total > 3.0 * LEAST_LIGHT)
    red, green = (ndimage.uniform_filter(np.where(coloured, each, 0.0), NEAR_BLOCKS) for each in (red, green))
    return coloured & (red > parameters.rust_red * green)


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
