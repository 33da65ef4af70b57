"""Lines of dark pixels: pieces of one line are put together, and what is no thin dark line is refused."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

PIECE_PX, GAP_PX, BEND = 10, 30.0, np.cos(np.radians(25.0))
"""Shortest piece; widest gap between two pieces of a line; cosine of the greatest bend between them."""
BIN_PX = 8
"""A line's course is known by the middles of so long parts."""
SIDE_PX, CORE_PX = 12, 1
"""A profile reaches so far to both sides; its core is so far to both sides of its darkest place."""
BESIDE = (6, 11)
"""Where the surface beside a line is looked at, px from its middle."""


class Line(NamedTuple):
    """A line in a picture.

    pixels: (n, 2), x, y, along its course. length_px: of it. depth: share of light that it lacks.
    width_px: of the dark core, at half its depth. unlike: difference beside it as a multiple of the depth.
    filled: share of its length that is dark. rough_px: deviation of the group's pixels from the course.
    bent: deviation of the course from a straight line, as a share of the length.
    """

    pixels: np.ndarray
    length_px: float
    depth: float
    width_px: float
    unlike: float
    filled: float
    rough_px: float
    bent: float


def pieces_joined(groups: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return groups of pixels (n, 2): those whose ends go on in each other are one."""
    pieces, ends, ways = [], [], []
    for group in groups:
        if len(group) < PIECE_PX or math.hypot(*np.ptp(group, axis=0)) < PIECE_PX:
            continue
        middle = group.mean(axis=0)
        _, _, axes = np.linalg.svd(group - middle, full_matrices=False)
        along = (group - middle) @ axes[0]
        if np.ptp(along) < PIECE_PX:
            continue
        pieces.append(group)
        ends += [middle + along.min() * axes[0], middle + along.max() * axes[0]]
        ways += [-axes[0], axes[0]]
    if not pieces:
        return []
    at, way = np.array(ends), np.array(ways)
    pairs = cKDTree(at).query_pairs(GAP_PX, output_type="ndarray")
    pairs = pairs[pairs[:, 0] // 2 != pairs[:, 1] // 2]
    gap = at[pairs[:, 1]] - at[pairs[:, 0]]
    gap /= np.maximum(np.linalg.norm(gap, axis=1), 1e-9)[:, None]
    first, second = way[pairs[:, 0]], way[pairs[:, 1]]
    goes_on = ((first * gap).sum(axis=1) > BEND) & (-(second * gap).sum(axis=1) > BEND)
    links = pairs[goes_on] // 2
    graph = coo_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), (len(pieces), len(pieces)))
    count, of = connected_components(graph, directed=False)
    order = np.argsort(of, kind="stable")
    starts = np.searchsorted(of[order], np.arange(1, count))
    return [np.concatenate([pieces[k] for k in members]) for members in np.split(order, starts)]


def line_through(group: np.ndarray, light: np.ndarray) -> Line:
    """Return the line through a group of pixels (n, 2), as the picture's light (height, width) shows it."""
    middle = group.mean(axis=0)
    _, _, axes = np.linalg.svd(group - middle, full_matrices=False)
    along, across = (group - middle) @ axes.T[:, 0], (group - middle) @ axes.T[:, 1]
    low, length = along.min(), float(np.ptp(along))
    bins = np.minimum((along - low) // BIN_PX, max(length // BIN_PX - 1, 0)).astype(int)
    counts = np.bincount(bins)
    known = counts > 0
    places = low + (np.arange(len(counts)) + 0.5) * BIN_PX
    course = np.bincount(bins, across)[known] / counts[known]
    steps = np.arange(low, low + length + 0.5)
    middles = np.interp(steps, places[known], course)
    rough = float(np.sqrt(np.mean((across - np.interp(along, places[known], course)) ** 2)))
    offsets = np.arange(-SIDE_PX, SIDE_PX + 1)
    xy = middle + steps[:, None, None] * axes[0] + (middles[:, None] + offsets)[:, :, None] * axes[1]
    profiles = map_coordinates(light, (xy[..., 1], xy[..., 0]), order=1, mode="nearest")
    depth, width, unlike = _judged(profiles)
    on_line = middle + steps[:, None] * axes[0] + middles[:, None] * axes[1]
    bent = float(np.std(middles)) / max(length, 1.0)
    return Line(on_line, length, depth, width, unlike, _filled(profiles, depth), rough, bent)


def _judged(profiles: np.ndarray) -> tuple[float, float, float]:
    """Return depth, width and how unlike the sides are, of profiles (n, 2 * SIDE_PX + 1).

    depth: share of light that the line lacks. unlike: greatest difference beside it, as a multiple of the
    depth. A weld has a bright line beside the dark one.
    """
    mean = profiles.mean(axis=0)
    near, far = BESIDE
    left = float(np.median(mean[SIDE_PX - far : SIDE_PX - near + 1]))
    right = float(np.median(mean[SIDE_PX + near : SIDE_PX + far + 1]))
    core = mean[SIDE_PX - 3 : SIDE_PX + 4]
    darkest = float(core.min())
    base = min(left, right)
    if base <= 0.0 or darkest >= base:
        return 0.0, float(len(mean)), np.inf
    half = 0.5 * (darkest + base)
    width = float((mean < half).sum())
    beside = mean[np.abs(np.arange(len(mean)) - SIDE_PX) >= near]
    return 1.0 - darkest / base, width, float(np.ptp(beside)) / (base - darkest)


def _filled(profiles: np.ndarray, depth: float) -> float:
    """Return the share of a line's length, in parts, that is at least half as dark as the whole."""
    count = max(len(profiles) // BIN_PX, 1)
    parts = np.stack([part.mean(axis=0) for part in np.array_split(profiles, count)])
    near, far = BESIDE
    left = np.median(parts[:, SIDE_PX - far : SIDE_PX - near + 1], axis=1)
    right = np.median(parts[:, SIDE_PX + near : SIDE_PX + far + 1], axis=1)
    darkest = parts[:, SIDE_PX - 3 : SIDE_PX + 4].min(axis=1)
    return float((darkest < (1.0 - 0.5 * depth) * np.minimum(left, right)).mean())
