"""Candidates in one photograph: rust by its colour, cracks as thin dark lines."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection.findings.kinds import CRACK, RUST
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.cracks import Marked, cracks_in, groups_of, unlike_marked
from inspection.findings.picture.kernels import block_light
from inspection.findings.picture.paint import RED, is_all_red, unlike_coatings, unlike_the_most
from inspection.findings.picture.rust_texture import rust_among
from inspection.findings.picture.stamps import without_writing, writing_in

BLOCK_PX = 4
"""Colour is judged in blocks: single pixels are noisy, and JPEG halves the colour's resolution."""
LEAST_BLOCKS = 4
"""Fewer that hang together are noise."""
NEAR_BLOCKS, RIM_BLOCKS = 5, 3
"""Blocks along the sides of what is smoothed: where rust is sure, and at its rim."""
LEAST_LIGHT = 0.01
"""Of white; darker blocks have no colour that one could judge."""
COARSE_MM = 1.0
"""Of a pixel, at which the widest cracks are looked for."""
WIDE_PIXELS = 4e5
"""Pixels of the copy in which wide cracks are looked for, if nobody knows what a pixel covers."""
SAME_PX = 5
"""A line in a copy that runs so near to another, in its pixels, is the same line."""
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
    marked: list[Marked] = []
    for times in sorted(_copies(picture.shape, parameters, detail_mm)):
        lines = cracks_in(picture, times, linear_light(), near, parameters, looked_at)
        marked += unlike_marked(lines, marked, SAME_PX * times) if parameters.crack_wide else lines
    found += [Candidate(CRACK.name, _some(each.places), each.size_px) for each in marked]
    return found


def _copies(shape: tuple[int, ...], parameters: FindingParameters, detail_mm: float) -> set[int]:
    """Return by how much the copies are smaller in which cracks are looked for; 1 is the picture itself."""
    copies = {1, max(1, round(COARSE_MM / max(detail_mm, 0.1)))}
    if parameters.crack_wide:
        copies.add(max(1, round(math.sqrt(shape[0] * shape[1] / WIDE_PIXELS))))
    return copies


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
        for places in groups_of(marked)
    ]


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


def _spread(places: np.ndarray, most_apart: int) -> np.ndarray:
    """Return the first place (n, 2) in each square of a board; squares are at most `most_apart` wide."""
    side = min(max(1, int(np.sqrt(len(places) / MOST_PIXELS))), most_apart)
    _, first = np.unique(places // side, axis=0, return_index=True)
    return places[np.sort(first)]


def _some(places: np.ndarray) -> np.ndarray:
    return places[:: max(1, len(places) // MOST_PIXELS)]
