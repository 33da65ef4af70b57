"""Cracks in one photograph, or in a smaller copy: thin dark lines, and ridges where the surface is rough."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.kernels import block_means, dark_ridges, light_of
from inspection.findings.picture.lines import Line, line_through, pieces_joined
from inspection.findings.picture.one_surface import may_be_crack, surroundings
from inspection.findings.picture.ridges import ALSO_CORNERS
from inspection.findings.picture.rough_cracks import STRAIGHT, STRAIGHT_PX, cracks_on_rough
from inspection.findings.picture.smoothing import smoothed

SMOOTH_PX, SMOOTH_REACH, REACH_PX = 1.0, 2.5, 5
NOISE_PX = 32
"""Noise is measured in blocks: the sensor's in the dark, and that of a rough surface."""
NOISES = 3.0
"""A ridge is so many times deeper than the noise."""
MOST_CONTRAST = 0.99
"""Of a ridge that is looked for on the roughest surface."""
ROUGH = 1.5
"""A surface is rough where a ridge must be so many times deeper than on a plain one."""
STRAIGHT_UNLIKE = 0.2
"""Greatest difference of the surfaces beside a straight line, as a multiple of its depth. The toe of a weld
is straight, and dark as a crack is. But the bead's face leans another way than the plate, so it has another
light. A crack runs through one surface.
"""


class Marked(NamedTuple):
    """A crack. places: (n, 2), x, y, px of the whole picture. size_px: pixels of it that are dark."""

    places: np.ndarray
    size_px: int


def cracks_in(
    picture: np.ndarray,
    times: int,
    linear: np.ndarray,
    elsewhere: np.ndarray,
    parameters: FindingParameters,
    looked_at: np.ndarray | None,
) -> list[Marked]:
    """Return the cracks in a copy of a picture, uint8 (height, width, 3), that is so many times smaller.

    linear: (256,) light of the picture's values. elsewhere: (rows, columns) bool of blocks that fill it,
    where nothing is a crack. looked_at: as `candidates_in` has it.
    """
    light = light_of(picture[..., 1], linear)  # green has the least noise
    if times > 1:
        light = block_means(light, times)
    light = smoothed(light, SMOOTH_PX, SMOOTH_REACH)
    contrasts = _contrasts(light, parameters.crack_contrast, looked_at)
    block_px = picture.shape[0] // elsewhere.shape[0]
    rows, columns = (
        np.minimum(np.arange(size) * times // block_px, blocks - 1)
        for size, blocks in zip(light.shape, elsewhere.shape)
    )
    free = ~elsewhere[np.ix_(rows, columns)]
    lines, sizes = _thin_lines(light, contrasts, free, parameters)
    as_strong = 1
    if parameters.crack_rough:
        is_rough = _rough_places(contrasts, parameters.crack_contrast, light.shape) & free
        ridges, as_strong = cracks_on_rough(light, SMOOTH_PX, is_rough, parameters)
        lines += ridges
        sizes += [len(each) for each in ridges]
    if parameters.crack_surface:
        colours = picture[times // 2 :: times, times // 2 :: times]
        kept = [may_be_crack(surroundings(each, light, colours), as_strong) for each in lines]
    else:
        kept = [True] * len(lines)
    return [
        Marked(places * times + 0.5 * (times - 1), size * times**2)
        for places, size, is_kept in zip(lines, sizes, kept)
        if is_kept
    ]


def unlike_marked(lines: list[Marked], marked: list[Marked], within_px: float) -> list[Marked]:
    """Return the lines of which at most half runs along what is marked."""
    if not marked:
        return lines
    tree = cKDTree(np.concatenate([each.places for each in marked]))
    return [each for each in lines if np.mean(tree.query(each.places)[0] <= within_px) <= 0.5]


def _thin_lines(
    light: np.ndarray, contrasts: np.ndarray, free: np.ndarray, parameters: FindingParameters
) -> tuple[list[np.ndarray], list[int]]:
    """Return the courses of thin dark lines, and how many pixels each has. They are free no more."""
    ridges = dark_ridges(light, REACH_PX, contrasts, NOISE_PX) & free
    lines, sizes = [], []
    for group in pieces_joined(groups_of(ridges)):
        line = line_through(group, light)
        if is_thin(line, parameters):
            lines.append(line.pixels)
            sizes.append(len(group))
            x, y = group.T
            free[y, x] = False
    return lines, sizes


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


def _rough_places(contrasts: np.ndarray, least: float, shape: tuple[int, ...]) -> np.ndarray:
    """Return (height, width) bool: where the surface's own contrasts are as great as that of a crack."""
    rows, columns = (
        np.minimum(np.arange(size) // NOISE_PX, blocks - 1) for size, blocks in zip(shape, contrasts.shape)
    )
    is_rough = (contrasts > ROUGH * least) & (contrasts < 1.0)
    places: np.ndarray = is_rough[np.ix_(rows, columns)]
    return places


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


def groups_of(marked: np.ndarray) -> list[np.ndarray]:
    """Return the places (n, 2), x, y, of each group of marked pixels that touch, corners included."""
    numbers, count = ndimage.label(marked, ALSO_CORNERS)
    y, x = np.nonzero(numbers)
    of = numbers[y, x]
    order = np.argsort(of, kind="stable")
    places = np.column_stack((x, y))[order]
    return np.split(places, np.searchsorted(of[order], np.arange(2, count + 1))) if count else []
