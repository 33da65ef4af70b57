"""Cracks on rough surfaces, where single pixels are as dark as a crack: long ridges tell them apart.

A ridge must stand out in its picture, too. Joints, edges of stones and plants are long ridges, and a picture
that is full of them shows none that is a crack more than the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.lines import BIN_PX, pieces_joined
from inspection.findings.picture.ridges import ALSO_CORNERS, ridges_above_usual, strong_ridges

LONGER_PX = 7.0
"""Ridges of noise that are so much longer are e times rarer, so a larger picture asks for longer ones."""
STRAIGHT, STRAIGHT_PX = 0.004, 0.3
"""Joints, welds and cables deviate less from a straight line, as a share of the length and px."""
LEAST_PIECE_PX = 12
"""Extent of the shortest ridge that is joined to others."""
BESIDE_PX, TWO_SIDED = 8, 0.5
"""So far to both sides of a crack the surface is brighter. The darker side gains at least such a share of
what the brighter one gains. At the edge of a stone or of a wide joint one side is as dark as the edge.
"""
STANDS_OUT = 0.15
"""A crack's salience is at least such a share of the greatest in the picture, whatever has that."""


AS_STRONG = 0.3
"""Lines whose salience is such a share of the greatest are as strong as it."""


class Ridge(NamedTuple):
    """Course of a ridge. off_px: its deviation from a straight line. salience: as `ridge_of` has it."""

    length_px: float
    off_px: float
    salience: float


def cracks_on_rough(
    light: np.ndarray, smooth_px: float, is_rough: np.ndarray, parameters: FindingParameters
) -> tuple[list[np.ndarray], int]:
    """Return the places (n, 2), x, y, of each crack, and how many strong lines there are, cracks or not.

    light: (height, width), float32, smoothed by smooth_px. is_rough: (height, width) bool, where cracks are
    looked for by this.
    """
    if not is_rough.any():
        return [], 1
    above = ridges_above_usual(light, smooth_px)
    groups = pieces_joined(_pieces(strong_ridges(above) & is_rough))
    ridges = [ridge_of(group, above) for group in groups]
    megapixels = light.size / 1e6
    least_px = parameters.line_length + LONGER_PX * math.log(max(megapixels, 1.0))
    bent = max(parameters.line_bent, STRAIGHT)
    greatest = max((each.salience for each in ridges), default=0.0)
    least = STANDS_OUT * greatest
    cracks = [
        group
        for group, ridge in zip(groups, ridges)
        if ridge.length_px >= least_px
        and ridge.off_px > bent * ridge.length_px + STRAIGHT_PX
        and ridge.salience >= least
        and two_sided(group, light) >= TWO_SIDED
    ]
    return cracks, sum(each.salience >= AS_STRONG * greatest for each in ridges)


def _pieces(ridges: np.ndarray) -> list[np.ndarray]:
    """Return the places (n, 2) of each ridge that is not too short to be a part of a crack."""
    numbers, _ = ndimage.label(ridges, ALSO_CORNERS)
    pieces = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(numbers), 1):
        if math.hypot(rows.stop - rows.start, columns.stop - columns.start) >= LEAST_PIECE_PX:
            y, x = np.nonzero(numbers[rows, columns] == number)
            pieces.append(np.column_stack((x + columns.start, y + rows.start)))
    return pieces


def ridge_of(group: np.ndarray, above: np.ndarray) -> Ridge:
    """Return the course of a ridge, places (n, 2), x, y. It may have branches.

    Its salience is its length times its mean strength: in each part of the length the strongest place counts.

    above: (height, width) multiples of the usual strength.
    """
    off = group - group.mean(axis=0)
    _, _, axes = np.linalg.svd(off, full_matrices=False)
    along, across = off @ axes[0], off @ axes[1]
    length = float(np.ptp(along))
    parts = ((along - along.min()) // BIN_PX).astype(int)
    counts = np.bincount(parts)
    known = counts > 0
    course = np.bincount(parts, across)[known] / counts[known]
    strongest = np.zeros(len(counts))
    np.maximum.at(strongest, parts, above[group[:, 1], group[:, 0]])
    return Ridge(length, float(np.std(course)), length * float(strongest[known].mean()))


def two_sided(group: np.ndarray, light: np.ndarray) -> float:
    """Return how alike both sides of a ridge, places (n, 2), x, y, are: 1 a line on one surface, 0 a step.

    At each place two sides are compared, in four directions: how much brighter the darker one is, where this
    is most; and how much brighter any is. Their sums are divided. light: (height, width).
    """
    height, width = light.shape
    x, y = group.T
    middle = light[y, x]
    both, one = np.zeros(len(x)), np.zeros(len(x))
    slant = round(0.7071 * BESIDE_PX)
    for dx, dy in ((BESIDE_PX, 0), (0, BESIDE_PX), (slant, slant), (slant, -slant)):
        first, second = (
            light[np.clip(y + way * dy, 0, height - 1), np.clip(x + way * dx, 0, width - 1)] - middle
            for way in (-1, 1)
        )
        both = np.maximum(both, np.minimum(first, second))
        one = np.maximum(one, np.maximum(first, second))
    return float(both.sum() / max(float(one.sum()), 1e-9))
