"""Rust told from paint, brick and grass by its hue and its texture, where the surface is not known.

Rust is brown to orange, mottled at a fine scale, and its edges run in all directions. Paint is even, often a
purer red, and what is made by people has level and upright edges. A logistic regression on 77 pictures, a
half of the set `download` of CorrosionDetector, has weighed the three (`doc/findings.md`).
"""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from inspection.findings.picture.kernels import block_light, block_texture, mean_colour
from inspection.findings.picture.rust_cells import learnt_weights, likely_cells, red_cells

SIDE_PX = 4
"""Of the blocks, in the copy that is judged."""
COPY_PIXELS = 2e6
"""The copy has about so many at most; a large picture shows sharp things several pixels wide."""
HUES = (-1.0, 1.5)
"""Where a block's hue is cut off, (G - B) / (R - B) in light: 0 is red, 1 yellow."""
RUST_HUES = (0.2, 0.35)
"""Rust is between them."""
REDDER, YELLOWER, MOTTLED, LEVEL = -12.73, -2.4, 0.99, -3.55
"""Weights of how far the hue is off, of the logarithm of the texture, and of level and upright edges."""
LEAST = -2.5
"""Of their weighted sum where a block looks like rust."""
AROUND_BLOCKS = 7
"""Blocks along the sides of the square in which red blocks are judged together."""
LEAST_TOGETHER, LEAST_SHARE = 60, 0.1
"""A group of red blocks is rust if so many that touch, and such a share of it, look like rust."""
LEAST_LIKELY, CELLS = 0.7, 12
"""And if a network that has learnt holds so many of its cells that touch for rust, by such a probability."""
SPOT, SPOT_SHARE = -3.6, 0.5
"""Or if such a share of it looks like rust by such a sum, and it lies on an even surface."""
MOST_UNEVEN, BESIDE_BLOCKS = 0.3, 8
"""An even surface: the logarithm of the light has so great a standard deviation at most, so near."""
DARK = 0.01
"""Light that is added before logarithms are taken, of white."""
ALSO_CORNERS = np.ones((3, 3), bool)


def rust_among(red: np.ndarray, picture: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """Return those groups of red blocks, bool (rows, columns), that have hue and texture of rust.

    red: blocks of SIDE_PX of the picture, uint8 (height, width, 3), sRGB. linear: (256,) light of its values.
    """
    if not red.any():
        return red
    times = max(1, round(math.sqrt(picture.shape[0] * picture.shape[1] / COPY_PIXELS)))
    copied = _in_copy(red, times)
    colours = block_light(picture, linear, SIDE_PX * times)
    light = np.log(mean_colour(block_light(picture, linear, times)) + np.float32(DARK))
    sums = likeness(colours, light, copied)
    is_rust = _mottled(copied & (sums > LEAST), copied)
    if is_rust.any():
        is_rust = _touched(is_rust, _in_copy(_likely(picture, red, linear), times))
    is_rust |= _spots(copied & (sums > SPOT), copied, np.log(colours.mean(axis=2) + DARK))
    kept = np.kron(is_rust, np.ones((times, times), bool))
    rows, columns = (min(a, b) for a, b in zip(kept.shape, red.shape))
    rust = np.zeros_like(red)
    rust[:rows, :columns] = red[:rows, :columns] & kept[:rows, :columns]
    return rust


def _likely(picture: np.ndarray, red: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """Return (rows, columns) bool of the blocks: where enough cells that touch are likely rust."""
    cells = red_cells(picture, red, SIDE_PX, linear)
    numbers, _ = ndimage.label(likely_cells(cells, learnt_weights(), LEAST_LIKELY), ALSO_CORNERS)
    enough = np.bincount(numbers.ravel()) >= CELLS
    enough[0] = False
    wide = cells.side_px // SIDE_PX
    likely, of_cells = np.zeros_like(red), np.kron(enough[numbers], np.ones((wide, wide), bool))
    rows, columns = (min(a, b) for a, b in zip(likely.shape, of_cells.shape))
    likely[:rows, :columns] = of_cells[:rows, :columns]
    return likely


def _touched(marked: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Return the groups of marked blocks of which one is marked by the other, too."""
    touched: np.ndarray = ndimage.binary_propagation(marked & by, ALSO_CORNERS, marked)
    return touched


def likeness(colours: np.ndarray, light: np.ndarray, red: np.ndarray) -> np.ndarray:
    """Return (rows, columns) how much like rust the red blocks, bool (rows, columns), look.

    colours: (rows, columns, 3) light of the blocks. light: (height, width) logarithms, all float32.
    """
    texture, edges, along = block_texture(light, SIDE_PX)
    r, g, b = np.moveaxis(colours, 2, 0)
    hue = _around(np.clip((g - b) / np.maximum(r - b, 1e-3), *HUES), red)
    redder, yellower = np.maximum(RUST_HUES[0] - hue, 0.0), np.maximum(hue - RUST_HUES[1], 0.0)
    mottled = _around(np.log(texture + DARK), red)
    level = np.maximum(_around(along, red) / (_around(edges, red) + 1e-5), 0.0)
    sums: np.ndarray = REDDER * redder + YELLOWER * yellower + MOTTLED * mottled + LEVEL * level
    return sums


def _in_copy(red: np.ndarray, times: int) -> np.ndarray:
    """Return the blocks of a copy that is so many times smaller: red where one of the picture's is."""
    rows, columns = red.shape[0] // times, red.shape[1] // times
    cut = red[: rows * times, : columns * times]
    smaller: np.ndarray = cut.reshape(rows, times, columns, times).any(axis=(1, 3))
    return smaller


def _mottled(looks: np.ndarray, red: np.ndarray) -> np.ndarray:
    """Return the groups of red blocks in which enough of those that look like rust touch each other."""
    of_red, groups = ndimage.label(red, ALSO_CORNERS)
    of_looks, _ = ndimage.label(looks, ALSO_CORNERS)
    together = np.bincount(of_looks.ravel())
    together[0] = 0
    numbers = np.arange(groups + 1)
    most = ndimage.maximum(together[of_looks], of_red, numbers)
    share = np.bincount(of_red.ravel(), looks.ravel()) / np.maximum(np.bincount(of_red.ravel()), 1)
    is_rust = (most >= LEAST_TOGETHER) & (share >= LEAST_SHARE)
    is_rust[0] = False
    kept: np.ndarray = is_rust[of_red]
    return kept


def _spots(looks: np.ndarray, red: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Return the groups of red blocks that are rust on an even surface. light: (rows, columns) logarithms."""
    of_red, _ = ndimage.label(red, ALSO_CORNERS)
    spots = np.zeros_like(red)
    for number, (rows, columns) in enumerate(ndimage.find_objects(of_red), 1):
        part = tuple(
            slice(max(each.start - BESIDE_BLOCKS, 0), each.stop + BESIDE_BLOCKS) for each in (rows, columns)
        )
        spot = of_red[part] == number
        if looks[part][spot].mean() >= SPOT_SHARE and _is_even(light[part], spot, red[part]):
            spots[part] |= spot
    return spots


def _is_even(light: np.ndarray, spot: np.ndarray, red: np.ndarray) -> bool:
    """Return whether the surface around a spot is even and not red."""
    off = min(BESIDE_BLOCKS, math.ceil(math.sqrt(spot.sum())))
    rim, near = (ndimage.binary_dilation(spot, ALSO_CORNERS, iterations=each) for each in (1, off))
    around = light[near & ~rim & ~red]
    return bool(around.size > 0.5 * np.count_nonzero(near & ~rim) and around.std() <= MOST_UNEVEN)


def _around(values: np.ndarray, red: np.ndarray) -> np.ndarray:
    """Return the means of values over the red blocks around each block."""
    sums, share = (
        ndimage.uniform_filter(each, AROUND_BLOCKS)
        for each in (np.where(red, values, np.float32(0.0)), red.astype(np.float32))
    )
    return sums / np.maximum(share, 1e-4)
