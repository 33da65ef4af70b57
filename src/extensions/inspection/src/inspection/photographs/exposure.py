"""Where a photograph shows anything: neither blown out nor black."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from inspection.photographs.listing import opened

BLOCK = 8
"""Side of the blocks, px, that are looked at; a JPEG's decoder gives their means fast."""
WHITE, BLACK = 250, 4
"""sRGB values of a block from which, and up to which, nothing is told from its surroundings."""


def exposed(path: Path) -> np.ndarray:
    """Return (rows, columns), blocks of 8 px: whether they are neither white nor black.

    A block counts by its brightest channel: a red wall that is well lit has hardly any blue.

    Raises:
        OSError: it is no picture; see `listing.check_picture`.
    """
    with opened(path) as image:
        size = _size(image)
        image.draft("RGB", size)
        light = np.array(image.convert("RGB").resize(size, Image.Resampling.BOX))
    return _is_exposed(light)


def exposed_blocks(picture: np.ndarray) -> np.ndarray:
    """Return the same of a picture, uint8 (height, width, 3), RGB."""
    return _is_exposed(blocks_of(picture))


def _is_exposed(light: np.ndarray) -> np.ndarray:
    darkest, brightest = light.min(axis=2), light.max(axis=2)
    told: np.ndarray = (darkest < WHITE) & (brightest > BLACK)
    return told


def blocks_of(picture: np.ndarray) -> np.ndarray:
    """Return (rows, columns, 3), uint8: the means of a picture's blocks of 8 px. picture: uint8, RGB."""
    image = Image.fromarray(picture)
    return np.array(image.resize(_size(image), Image.Resampling.BOX))


def _size(image: Image.Image) -> tuple[int, int]:
    """Return how many blocks an image has in a row, and in a column."""
    return -(-image.width // BLOCK), -(-image.height // BLOCK)


def at(blocks: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Return the values (n,) of blocks (rows, columns) at pixels (n, 2)."""
    column, row = np.clip(pixels // BLOCK, 0, np.array(blocks.shape[::-1]) - 1).astype(int).T
    values: np.ndarray = blocks[row, column]
    return values
