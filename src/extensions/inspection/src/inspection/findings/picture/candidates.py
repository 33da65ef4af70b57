"""Candidates in one photograph: rust by its colour, cracks as thin dark lines."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection.findings.kinds import CRACK, RUST
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.kernels import block_light, dark_ridges, light_of
from inspection.findings.picture.lines import Line, line_through, pieces_joined
from inspection.findings.picture.paint import RED, is_all_red, unlike_coatings, unlike_the_most
from inspection.findings.picture.rough_cracks import STRAIGHT, STRAIGHT_PX, cracks_on_rough
from inspection.findings.picture.rust_texture import rust_among
from inspection.findings.picture.smoothing import smoothed
from inspection.findings.picture.stamps import without_writing, writing_in

BLOCK_PX = 4
"""Colour is judged in blocks: single pixels are noisy, and JPEG halves the colour's resolution."""
LEAST_BLOCKS = 4
"""Fewer that hang together are noise."""
NEAR_BLOCKS, RIM_BLOCKS = 5, 3
"""Blocks along the sides of what is smoothed: where rust is sure, and at its rim."""
LEAST_LIGHT = 0.01
"""Of white; darker blocks have no colour that one could judge."""
SMOOTH_PX, SMOOTH_REACH, REACH_PX = 1.0, 2.5, 5
NOISE_PX = 32
"""Noise is measured in blocks: the sensor's in the dark, and that of a rough surface."""
NOISES = 3.0
"""A ridge is so many times deeper than the noise."""
MOST_CONTRAST = 0.99
"""Of a ridge that is looked for on the roughest surface."""
ROUGH = 1.5
"""A surface is rough where a ridge must be so many times deeper than on a plain one."""
COARSE_MM = 1.0
"""Of a pixel, at which the widest cracks are looked for."""
STRAIGHT_UNLIKE = 0.2
"""Greatest difference of the surfaces beside a straight line, as a multiple of its depth. The toe of a weld
is straight, and dark as a crack is. But the bead's face leans another way than the plate, so it has another
light. A crack runs through one surface.
"""
MOST_PIXELS = 400
"""Of one candidate, drawn evenly. Of rust it is more where they would be farther apart than RUST_APART_MM."""
RUST_APART_MM = 35.0
"""On the surface. An edge is rusted where a place of rust is near, so the places must lie close."""
RIM_MM = 40.0
"""On the surface: so far around what is surely rust it may fade into paint."""
ALSO_CORNERS = np.ones((3, 3), bool)


class Candidate(NamedTuple):
    """kind: rust, crack or RED. pixels: (n, 2) some of its places, x, y, px. size_px: of all of them."""

    kind: str
    pixels: np.ndarray
    size_px: int


def candidates_in(
    picture: np.ndarray,
    parameters: FindingParameters,
    looked_at: np.ndarray | None = None,
    detail_mm: float = COARSE_MM,
) -> list[Candidate]:
    """Return the candidates in a picture, uint8 (height, width, 3), sRGB.

    looked_at: (rows, columns) where cracks are looked for, in cells that fill the picture; None: everywhere.
    detail_mm: that a pixel covers. If it is fine, wide cracks are looked for in a smaller picture, too; how
        close the places of rust are told goes by it.
    """
    block_mm = _block_mm(detail_mm)
    least = _least_blocks(parameters, block_mm)
    blocks = block_light(picture, linear_light(), BLOCK_PX)
    writing = writing_in(picture)
    red = _rust_blocks(blocks, parameters, least, math.ceil(RIM_MM / block_mm))
    red = without_writing(red, writing, BLOCK_PX)
    rust = rust_among(red, picture, linear_light()) if parameters.rust_texture else red
    most_apart = max(1, int(RUST_APART_MM / block_mm))
    found = []
    if not parameters.coatings and is_all_red(red, blocks.sum(axis=2) > 3.0 * LEAST_LIGHT):
        found += _of_blocks(RED, rust, most_apart)
        red = _large(unlike_the_most(blocks, red), least)
        rust = rust_among(red, picture, linear_light()) if parameters.rust_texture else red
    found += _of_blocks(RUST.name, rust, most_apart)
    near = ndimage.binary_dilation(red, iterations=3)  # rust has dark pits and borders
    near = ~without_writing(~near, writing, BLOCK_PX)
    for times in sorted({1, max(1, round(COARSE_MM / max(detail_mm, 0.1)))}):
        light = _smaller(light_of(picture[..., 1], linear_light()), times)  # green has the least noise
        light = smoothed(light, SMOOTH_PX, SMOOTH_REACH)
        found += _cracks(light, times, near, parameters, looked_at)
    return found


def red_blocks(picture: np.ndarray, parameters: FindingParameters) -> np.ndarray:
    """Return (rows, columns) bool: the blocks that have the colour of rust, in a picture without a mesh."""
    blocks, block_mm = block_light(picture, linear_light(), BLOCK_PX), _block_mm(COARSE_MM)
    least = _least_blocks(parameters, block_mm)
    return _rust_blocks(blocks, parameters, least, math.ceil(RIM_MM / block_mm))


def _block_mm(detail_mm: float) -> float:
    return BLOCK_PX * float(np.clip(detail_mm, 0.1, 2.0 * COARSE_MM))


def _least_blocks(parameters: FindingParameters, block_mm: float) -> float:
    return max(LEAST_BLOCKS, (1e3 * parameters.rust_size / block_mm) ** 2)


def _of_blocks(kind: str, marked: np.ndarray, most_apart: int) -> list[Candidate]:
    """Return a candidate for each group of marked blocks."""
    return [
        Candidate(
            kind, _spread(places, most_apart) * BLOCK_PX + 0.5 * (BLOCK_PX - 1), len(places) * BLOCK_PX**2
        )
        for places in _groups(marked)
    ]


def _cracks(
    light: np.ndarray,
    times: int,
    rust: np.ndarray,
    parameters: FindingParameters,
    looked_at: np.ndarray | None,
) -> list[Candidate]:
    """Return the cracks in a picture that is so many times smaller.

    light: smoothed by SMOOTH_PX. rust: blocks of the whole picture.
    """
    contrasts = _contrasts(light, parameters.crack_contrast, looked_at)
    rows, columns = (
        np.minimum(np.arange(size) * times // BLOCK_PX, blocks - 1)
        for size, blocks in zip(light.shape, rust.shape)
    )
    free = ~rust[np.ix_(rows, columns)]
    ridges = dark_ridges(light, REACH_PX, contrasts, NOISE_PX) & free
    found = []
    for group in pieces_joined(_groups(ridges)):
        line = line_through(group, light)
        if is_thin(line, parameters):
            pixels = _some(line.pixels) * times + 0.5 * (times - 1)
            found.append(Candidate(CRACK.name, pixels, len(group) * times**2))
            x, y = group.T
            free[y, x] = False
    if parameters.crack_rough:
        is_rough = _rough_places(contrasts, parameters.crack_contrast, light.shape) & free
        for group in cracks_on_rough(light, SMOOTH_PX, is_rough, parameters):
            pixels = _some(group) * times + 0.5 * (times - 1)
            found.append(Candidate(CRACK.name, pixels, len(group) * times**2))
    return found


def _rough_places(contrasts: np.ndarray, least: float, shape: tuple[int, ...]) -> np.ndarray:
    """Return (height, width) bool: where the surface's own contrasts are as great as that of a crack."""
    rows, columns = (
        np.minimum(np.arange(size) // NOISE_PX, blocks - 1) for size, blocks in zip(shape, contrasts.shape)
    )
    is_rough = (contrasts > ROUGH * least) & (contrasts < 1.0)
    places: np.ndarray = is_rough[np.ix_(rows, columns)]
    return places


def _smaller(light: np.ndarray, times: int) -> np.ndarray:
    """Return the means of blocks of so many pixels along each side."""
    rows, columns = light.shape[0] // times, light.shape[1] // times
    cut = light[: rows * times, : columns * times]
    return cut.reshape(rows, times, columns, times).mean(axis=(1, 3)) if times > 1 else light


def is_thin(line: Line, parameters: FindingParameters) -> bool:
    """Return whether a line may be a crack: long, thin, dark all along, alike on both sides, not straight."""
    p = parameters
    is_straight = line.bent * line.length_px <= STRAIGHT * line.length_px + STRAIGHT_PX
    unlike = min(p.line_unlike, STRAIGHT_UNLIKE) if is_straight else p.line_unlike
    return bool(
        line.length_px >= p.line_length
        and line.depth >= 0.7 * p.crack_contrast
        and line.width_px <= p.line_width
        and line.unlike <= unlike
        and line.filled >= p.line_filled
        and line.rough_px <= p.line_rough
        and line.bent >= p.line_bent
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
    contrasts = np.clip(NOISES * noise, least, MOST_CONTRAST)
    if looked_at is not None:
        y = np.minimum((np.arange(rows) + 0.5) / rows * looked_at.shape[0], looked_at.shape[0] - 1).astype(
            int
        )
        x = np.minimum((np.arange(columns) + 0.5) / columns * looked_at.shape[1], looked_at.shape[1] - 1)
        contrasts[~looked_at[np.ix_(y, x.astype(int))]] = 1.0
    return contrasts.astype(np.float32)


def _rust_blocks(light: np.ndarray, parameters: FindingParameters, least: float, rim: int) -> np.ndarray:
    """Return which blocks have the colour of rust, and of none of the coatings that are given.

    Red is compared with green in all coloured blocks nearby, for noise.

    light: (rows, columns, 3) of the blocks. least: so many blocks that are surely rust must hang together.
    rim: blocks around them that are compared with the paint.
    """
    total = light.sum(axis=2)
    red, green, blue = np.moveaxis(light, 2, 0)
    coloured = (red - blue > parameters.rust_colour * total) & (total > 3.0 * LEAST_LIGHT)
    is_coating = np.zeros(total.shape, bool)
    if parameters.coatings:
        coatings = [linear_light()[np.array(each)] for each in parameters.coatings]
        unlike = unlike_coatings(light, coloured, coatings)
        is_coating, coloured = coloured & ~unlike, unlike
    red_near, green_near = (
        ndimage.uniform_filter(np.where(coloured, each, 0.0), NEAR_BLOCKS) for each in (red, green)
    )
    sure = _large(coloured & (red_near > parameters.rust_red * green_near), least)
    return ~is_coating & _half_covered(red - blue, total, sure, rim) if sure.any() else sure


def _large(marked: np.ndarray, least: float) -> np.ndarray:
    """Return the marked blocks of which at least so many hang together."""
    numbers, _ = ndimage.label(marked, ALSO_CORNERS)
    is_large = np.bincount(numbers.ravel()) >= least
    is_large[0] = False
    large: np.ndarray = is_large[numbers]
    return large


def _half_covered(colour: np.ndarray, total: np.ndarray, sure: np.ndarray, rim: int) -> np.ndarray:
    """Return what is surely rust, and what hangs together with it that rust covers by more than half.

    There the light is nearer to that of the rust than to that of the paint beside it. colour: red less blue.
    total: of all three.
    """
    near = ndimage.maximum_filter(sure, 2 * rim + 1)
    window = 4 * rim + 1
    rust, paint = (_means_around(which, (colour, total), window) for which in (sure, ~near))
    middle = (rust[0] + paint[0]) / np.maximum(rust[1] + paint[1], 1e-6)
    colour, total = (ndimage.uniform_filter(each, RIM_BLOCKS) for each in (colour, total))
    covered = sure | (near & (paint[1] > 0.0) & (colour > middle * total))
    joined: np.ndarray = ndimage.binary_propagation(sure, ALSO_CORNERS, covered)
    return joined


def _means_around(which: np.ndarray, values: tuple[np.ndarray, ...], window: int) -> tuple[np.ndarray, ...]:
    """Return the means of values over the blocks of a window that are meant; 0: there are none."""
    share = ndimage.uniform_filter(which.astype(np.float32), window)
    sums = [ndimage.uniform_filter(np.where(which, each, np.float32(0.0)), window) for each in values]
    return tuple(np.where(share > 1e-4, each / np.maximum(share, 1e-4), 0.0) for each in sums)


def linear_light() -> np.ndarray:
    """Return (256,), float32: the light of sRGB values (IEC 61966-2-1)."""
    value = np.arange(256) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)


def _groups(marked: np.ndarray) -> list[np.ndarray]:
    """Return the places (n, 2), x, y, of each group of marked pixels that touch, corners included."""
    numbers, count = ndimage.label(marked, ALSO_CORNERS)
    y, x = np.nonzero(numbers)
    of = numbers[y, x]
    order = np.argsort(of, kind="stable")
    places = np.column_stack((x, y))[order]
    return np.split(places, np.searchsorted(of[order], np.arange(2, count + 1))) if count else []


def _spread(places: np.ndarray, most_apart: int) -> np.ndarray:
    """Return the first place (n, 2) in each square of a board; squares are at most `most_apart` wide."""
    side = min(max(1, int(np.sqrt(len(places) / MOST_PIXELS))), most_apart)
    _, first = np.unique(places // side, axis=0, return_index=True)
    return places[np.sort(first)]


def _some(places: np.ndarray) -> np.ndarray:
    return places[:: max(1, len(places) // MOST_PIXELS)]
