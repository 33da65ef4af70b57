"""Cracks on rough surfaces, where single pixels are as dark as a crack: long ridges tell them apart."""

from __future__ import annotations

import math

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


def cracks_on_rough(
    light: np.ndarray, smooth_px: float, is_rough: np.ndarray, parameters: FindingParameters
) -> list[np.ndarray]:
    """Return the places (n, 2), x, y, of each crack.

    light: (height, width), float32, smoothed by smooth_px. is_rough: (height, width) bool, where cracks are
    looked for by this.
    """
    if not is_rough.any():
        return []
    ridges = strong_ridges(ridges_above_usual(light, smooth_px)) & is_rough
    megapixels = light.size / 1e6
    least_px = parameters.line_length + LONGER_PX * math.log(max(megapixels, 1.0))
    joined = pieces_joined(_pieces(ridges))
    bent = max(parameters.line_bent, STRAIGHT)
    return [group for group in joined if _is_crack(group, least_px, bent)]


def _pieces(ridges: np.ndarray) -> list[np.ndarray]:
    """Return the places (n, 2) of each ridge that is not too short to be a part of a crack."""
    numbers, _ = ndimage.label(ridges, ALSO_CORNERS)
    pieces = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(numbers), 1):
        if math.hypot(rows.stop - rows.start, columns.stop - columns.start) >= LEAST_PIECE_PX:
            y, x = np.nonzero(numbers[rows, columns] == number)
            pieces.append(np.column_stack((x + columns.start, y + rows.start)))
    return pieces


def _is_crack(group: np.ndarray, least_px: float, least_bent: float) -> bool:
    """Return whether a ridge, places (n, 2), is long and not straight. It may have branches."""
    off = group - group.mean(axis=0)
    _, _, axes = np.linalg.svd(off, full_matrices=False)
    along, across = off @ axes[0], off @ axes[1]
    length = float(np.ptp(along))
    if length < least_px:
        return False
    parts = ((along - along.min()) // BIN_PX).astype(int)
    counts = np.bincount(parts)
    course = np.bincount(parts, across)[counts > 0] / counts[counts > 0]
    return float(np.std(course)) > least_bent * length + STRAIGHT_PX
