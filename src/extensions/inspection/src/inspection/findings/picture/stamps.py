"""Date, time and other writing that a camera has burnt into a picture: its digits are neither crack nor rust.

Writing is a row of glyphs of one height and one colour, along the upper or the lower border.
"""

from __future__ import annotations

from typing import Iterator, NamedTuple

import numpy as np
from scipy import ndimage

STRIP = 0.15
"""Of the picture's height: so far from its upper and lower border writing is looked for."""
COPY_PX = 800
"""Of the smaller side of the copy that is looked at."""
STROKE_PX, LEAST_CONTRAST = 15, 60.0
"""Strokes are thinner; so much they differ from what is around them, of 255."""
HEIGHTS_PX = (7, 70)
"""Of glyphs in the copy."""
WIDEST, FILLED = 1.3, (0.1, 0.9)
"""Of a glyph: its greatest width as a multiple of its height; the share of its box that is stroke."""
LEAST_GLYPHS = 6
"""In a row: the shortest date has six digits."""
LEVEL_OFF, FARTHEST = 0.12, 1.6
"""Of glyphs in a row, as multiples of the height: difference in level, of both ends; gap to the next."""
COLOUR_OFF = 25.0
"""The greatest standard deviation of the glyphs' mean colours, of 255."""
TOUCHING = np.ones((3, 3), bool)


class Box(NamedTuple):
    """Of pixels; right and bottom are the first ones beyond it."""

    left: int
    top: int
    right: int
    bottom: int


def writing_in(picture: np.ndarray) -> list[Box]:
    """Return where writing is burnt into a picture, uint8 (height, width, 3), with a margin."""
    height, width = picture.shape[:2]
    times = max(1, round(min(height, width) / COPY_PX))
    strip = int(STRIP * height) // times
    found = []
    for top in (0, height - strip * times):
        copy = _smaller(picture[top : top + strip * times], times)
        for row in _rows_of_glyphs(copy):
            margin = row.bottom - row.top
            box = np.clip(np.add(row, (-margin, -margin // 2, margin, margin // 2)), 0, None) * times
            left, first, right, end = (int(each) for each in box)
            found.append(Box(left, top + first, min(right, width), min(top + end, height)))
    return found


def without_writing(marked: np.ndarray, boxes: list[Box], side: int) -> np.ndarray:
    """Return marked places, bool (rows, columns), of `side` px each, without those in the boxes."""
    if not boxes:
        return marked
    kept = marked.copy()
    for box in boxes:
        kept[box.top // side : -(-box.bottom // side), box.left // side : -(-box.right // side)] = False
    return kept


def _smaller(picture: np.ndarray, times: int) -> np.ndarray:
    """Return the means of squares of so many pixels along each side, float32 (height, width, 3)."""
    rows, columns = picture.shape[0] // times, picture.shape[1] // times
    cut = picture[: rows * times, : columns * times]
    down = cut.reshape(rows, times, columns * times * 3).sum(axis=1, dtype=np.uint32)
    copy: np.ndarray = down.reshape(rows, columns, times, 3).sum(axis=2) / np.float32(times**2)
    return copy.astype(np.float32)


def _rows_of_glyphs(copy: np.ndarray) -> Iterator[Box]:
    """Yield the rows of glyphs in a strip, float32 (height, width, 3). They are bright, dark, or coloured."""
    if min(copy.shape[:2]) <= HEIGHTS_PX[0]:
        return
    brightest, darkest = copy.max(axis=2), copy.min(axis=2)
    for image in (brightest, 255.0 - brightest, brightest - darkest):
        strokes = ndimage.white_tophat(image, (STROKE_PX, STROKE_PX)) > LEAST_CONTRAST
        yield from _rows(_glyphs(strokes), copy, strokes)


def _glyphs(strokes: np.ndarray) -> list[Box]:
    """Return the boxes of what may be a glyph, by their left sides."""
    numbers, _ = ndimage.label(strokes, TOUCHING)
    found = []
    for number, (y, x) in enumerate(ndimage.find_objects(numbers), 1):
        height, width = y.stop - y.start, x.stop - x.start
        if HEIGHTS_PX[0] <= height <= HEIGHTS_PX[1] and width <= WIDEST * height:
            filled = np.count_nonzero(numbers[y, x] == number) / (height * width)
            if FILLED[0] <= filled <= FILLED[1] or width < 0.4 * height:  # a one may be a bar
                found.append(Box(x.start, y.start, x.stop, y.stop))
    return sorted(found)


def _rows(glyphs: list[Box], copy: np.ndarray, strokes: np.ndarray) -> Iterator[Box]:
    """Yield the rows that enough glyphs of one height, level and colour make."""
    left = list(glyphs)
    while left:
        row = [left.pop(0)]
        for each in list(left):
            if each.left - row[-1].right > FARTHEST * (row[0].bottom - row[0].top):
                break
            if _goes_on(row, each):
                row.append(each)
                left.remove(each)
        if len(row) >= LEAST_GLYPHS and _is_of_one_colour(row, copy, strokes):
            x0, y0, x1, y1 = np.array(row).T
            yield Box(int(x0.min()), int(y0.min()), int(x1.max()), int(y1.max()))


def _goes_on(row: list[Box], each: Box) -> bool:
    top, bottom = (float(np.median([getattr(one, side) for one in row])) for side in ("top", "bottom"))
    height = bottom - top
    off = max(abs(each.top - top), abs(each.bottom - bottom))
    return off <= max(1.0, LEVEL_OFF * height) and each.left >= row[-1].right - 1


def _is_of_one_colour(row: list[Box], copy: np.ndarray, strokes: np.ndarray) -> bool:
    colours = [
        copy[box.top : box.bottom, box.left : box.right][
            strokes[box.top : box.bottom, box.left : box.right]
        ].mean(axis=0)
        for box in row
    ]
    return bool(np.std(colours, axis=0).max() <= COLOUR_OFF)
