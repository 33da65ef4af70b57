"""Cracks told from joints, edges, stalks, stripes and hair in pictures of which one knows no surface.

A crack lies in one surface: it has one colour on both sides, and its light varies little around. A crack
turns often. And a picture shows few lines that are as strong. A logistic regression has weighed the four
(`doc/findings.md` says with which pictures).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from inspection.findings.picture.lines import BIN_PX

ASIDE_PX, SIDES_PX = 8, 12
"""The direction across a line is that in which the light rises most so far aside; then colours are compared
so far aside.
"""
SMOOTH_PX, AROUND_PX = 9, 30
"""The light's variation: means of squares of such a side, in the line's box and so far around."""
STRAIGHT_WITHIN_PX = 1.5
"""A part of a line is straight if its course keeps so near to its chord."""
COLOUR_DARK, DARK = 8.0, 0.01
"""Added to sRGB values before shares are taken, and to light before its logarithm, for noise in the dark."""
LEAST_COLOUR, LEAST_VARYING = 1e-3, 1e-3
"""Smaller differences of colour, and of the logarithm of the light, count as these."""
MOST_COLOUR = 0.12
"""Between two surfaces the colours differ by more."""
COLOUR, LINES, STRAIGHT_PART, VARYING, PLUS = -0.6, -1.7, -4.2, -2.9, -2.05
"""Weights, and what is added. The sum is 0 or more for what may be a crack."""


class Surroundings(NamedTuple):
    """Of a line.

    colour: mean difference between the shares of red, green and blue on both sides. straight: its longest
    straight part, as a share of its length. varying: standard deviation of the light's logarithm around.
    """

    colour: float
    straight: float
    varying: float


def may_be_crack(around: Surroundings, lines: int) -> bool:
    """Return whether a line may be a crack. lines: as strong ones that the picture shows, itself included."""
    total = (
        COLOUR * math.log(max(around.colour, LEAST_COLOUR))
        + LINES * math.log(max(lines, 1))
        + STRAIGHT_PART * around.straight
        + VARYING * math.log(max(around.varying, LEAST_VARYING))
        + PLUS
    )
    return total >= 0.0 and around.colour <= MOST_COLOUR


def surroundings(group: np.ndarray, light: np.ndarray, colours: np.ndarray) -> Surroundings:
    """Return the surroundings of a line, places (n, 2), x, y.

    light: (height, width). colours: (height, width, 3) sRGB values of the same places.
    """
    x, y = np.rint(group).astype(int).T.clip(0, np.array([light.shape[1], light.shape[0]])[:, None] - 1)
    first, second = _sides(x, y, light)
    shares = [_shares(colours[each]) for each in (first, second)]
    colour = float(np.abs(shares[0] - shares[1]).sum(axis=1).mean())
    box = tuple(slice(max(int(each.min()) - AROUND_PX, 0), int(each.max()) + AROUND_PX) for each in (y, x))
    even = ndimage.uniform_filter(light[box], SMOOTH_PX)
    return Surroundings(colour, straight_part(group), float(np.log(even + DARK).std()))


def _sides(x: np.ndarray, y: np.ndarray, light: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the places, y and x, on one side of a line and on the other."""
    slants = (1.0, 0.0), (0.0, 1.0), (math.sqrt(0.5), math.sqrt(0.5)), (math.sqrt(0.5), -math.sqrt(0.5))
    rises = [
        np.min([light[_at(x, y, dx, dy, way * ASIDE_PX, light.shape)] for way in (-1, 1)], axis=0)
        for dx, dy in slants
    ]
    dx, dy = np.array(slants)[np.argmax(rises, axis=0)].T
    return [_at(x, y, dx, dy, way * SIDES_PX, light.shape) for way in (-1, 1)]


def _at(
    x: np.ndarray,
    y: np.ndarray,
    dx: np.ndarray | float,
    dy: np.ndarray | float,
    far_px: int,
    shape: tuple[int, ...],
) -> tuple[np.ndarray, np.ndarray]:
    """Return y and x of the places so far in a direction, inside the picture."""
    places = (np.rint(each + far_px * way).astype(int) for each, way in ((y, dy), (x, dx)))
    down, across = (np.clip(each, 0, size - 1) for each, size in zip(places, shape))
    return down, across


def _shares(values: np.ndarray) -> np.ndarray:
    """Return the shares of red, green and blue, (n, 3), of sRGB values."""
    lit = values + COLOUR_DARK
    shares: np.ndarray = lit / lit.sum(axis=1, keepdims=True)
    return shares


def straight_part(group: np.ndarray) -> float:
    """Return the longest straight part of a line, places (n, 2), as a share of its length.

    Its course is split where it is farthest from its chord, until all parts are straight (Ramer 1972).
    """
    off = group - group.mean(axis=0)
    _, _, axes = np.linalg.svd(off, full_matrices=False)
    along, across = off @ axes[0], off @ axes[1]
    parts = ((along - along.min()) // BIN_PX).astype(int)
    counts = np.bincount(parts)
    at = np.flatnonzero(counts)
    course = np.bincount(parts, across)[at] / counts[at]
    unsplit, longest = [(0, len(at) - 1)], 0
    while unsplit:
        first, last = unsplit.pop()
        chord = np.interp(at[first : last + 1], at[[first, last]], course[[first, last]])
        aside = np.abs(course[first : last + 1] - chord)
        if aside.max() <= STRAIGHT_WITHIN_PX:
            longest = max(longest, int(at[last] - at[first]))
        else:
            middle = first + int(aside.argmax())
            unsplit += [(first, middle), (middle, last)]
    return longest / max(int(at[-1]), 1)
