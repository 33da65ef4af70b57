"""Rust told from leaves, leather, wood and fur by a small network that has learnt pictures of both.

It judges cells of a reduced copy by colour and texture, and by how both vary among the red cells around.
`benchmarks.findings_rows.learn_cells` trains it; `doc/findings.md` says with which pictures.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection.findings.picture.kernels import block_light, block_texture, mean_colour

CELL_PX, COPY_PIXELS = 8, 5e5
"""Side of a cell in the copy; pixels of the copy at most."""
DARK = 0.01
"""Light that is added before logarithms are taken, of white."""
RED_SHARE = 0.2
"""A cell counts as red if such a share of it is."""
AROUND_CELLS = 7
"""Cells along the sides of the square in which red cells are judged together."""
OWN, VARYING = 7, 4
"""Features of a cell alone; those of them, the first ones, whose deviation around it counts, too."""
FEATURES = 2 * OWN + VARYING + 1
LIGHT = (3, OWN + 3)
"""The features that are the logarithm of the light: it says more of the exposure than of the thing."""
WEIGHTS = Path(__file__).with_name("rust_cells.npz")


class RedCells(NamedTuple):
    """features: (n, FEATURES) of the red cells, row by row. red: (rows, columns). side_px: of a cell."""

    features: np.ndarray
    red: np.ndarray
    side_px: int


class Weights(NamedTuple):
    """Of the network. mean, deviation: (FEATURES,) of the features. hidden: (FEATURES + 1, n). out: (n + 1,).

    The last row of hidden and the last value of out are added.
    """

    mean: np.ndarray
    deviation: np.ndarray
    hidden: np.ndarray
    out: np.ndarray

    def probabilities(self, features: np.ndarray) -> np.ndarray:
        """Return (n,): how probably a cell is rust. features: (n, FEATURES)."""
        inner = np.tanh((features - self.mean) / self.deviation @ self.hidden[:-1] + self.hidden[-1])
        sums: np.ndarray = inner @ self.out[:-1] + self.out[-1]
        return 1.0 / (1.0 + np.exp(-np.clip(sums, -50.0, 50.0)))


def learnt_weights() -> Weights:
    """Return the weights that come with the package."""
    with np.load(WEIGHTS) as stored:
        return Weights(**{name: stored[name].astype(float) for name in Weights._fields})


def likely_cells(cells: RedCells, weights: Weights, least: float) -> np.ndarray:
    """Return (rows, columns) bool: the red cells that are rust by such a probability or a greater one."""
    likely = np.zeros(cells.red.shape, bool)
    likely[cells.red] = weights.probabilities(cells.features) >= least
    return likely


def red_cells(picture: np.ndarray, red: np.ndarray, block_px: int, linear: np.ndarray) -> RedCells:
    """Return the red cells of a picture, uint8 (height, width, 3), sRGB.

    red: (rows, columns) of its blocks of block_px px. linear: (256,) light of its values.
    """
    times = max(1, round(math.sqrt(picture.shape[0] * picture.shape[1] / COPY_PIXELS)))
    side_px = CELL_PX * times
    light = np.log(mean_colour(block_light(picture, linear, times)) + np.float32(DARK))
    texture, edges, along = block_texture(light, CELL_PX)
    rows, columns = texture.shape
    colours = block_light(picture, linear, side_px)[:rows, :columns]
    r, g, b = np.moveaxis(colours, 2, 0)
    total = r + g + b + np.float32(DARK)
    hue = np.clip((g - b) / np.maximum(r - b, 1e-2), -2.0, 3.0)
    own = (
        r / total,
        b / total,
        hue,
        np.log(total),
        np.log(texture + DARK),
        np.log(edges + DARK**2),
        along / (edges + 1e-5),
    )
    features = np.stack(own, axis=2)
    is_red = _shares(red, side_px // block_px, (rows, columns)) > RED_SHARE
    return RedCells(_with_surroundings(features, is_red)[is_red], is_red, side_px)


def _shares(red: np.ndarray, blocks: int, shape: tuple[int, int]) -> np.ndarray:
    """Return (rows, columns) of this shape: the share of red blocks in cells of so many along each side."""
    whole = np.zeros((shape[0] * blocks, shape[1] * blocks), np.float32)
    rows, columns = (min(a, b) for a, b in zip(whole.shape, red.shape))
    whole[:rows, :columns] = red[:rows, :columns]
    shares: np.ndarray = whole.reshape(shape[0], blocks, shape[1], blocks).mean(axis=(1, 3))
    return shares


def _with_surroundings(own: np.ndarray, red: np.ndarray) -> np.ndarray:
    """Return (rows, columns, FEATURES): own, and of the red cells around each: means, deviations, share.

    own: (rows, columns, OWN). red: (rows, columns).
    """
    weight = red.astype(np.float32)
    share = ndimage.uniform_filter(weight, AROUND_CELLS)

    def around(values: np.ndarray) -> np.ndarray:
        sums = ndimage.uniform_filter(values * weight[..., None], (AROUND_CELLS, AROUND_CELLS, 0))
        means: np.ndarray = sums / np.maximum(share, 1e-3)[..., None]
        return means

    means = around(own)
    squares = around(own[..., :VARYING] ** 2) - means[..., :VARYING] ** 2
    parts = (own, means, np.sqrt(np.maximum(squares, 0.0)), share[..., None])
    return np.concatenate(parts, axis=2)
