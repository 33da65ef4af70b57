"""Loops over the pixels of photographs."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True)
def block_light(picture: np.ndarray, linear: np.ndarray, side: int) -> np.ndarray:
    """Return (height // side, width // side, 3), float32: mean light of blocks of an sRGB picture, uint8.

    linear: (256,) the light of each value.
    """
    out = np.zeros((picture.shape[0] // side, picture.shape[1] // side, 3), np.float32)
    for row in range(out.shape[0]):
        for y in range(row * side, (row + 1) * side):
            for column in range(out.shape[1]):
                for x in range(column * side, (column + 1) * side):
                    for c in range(3):
                        out[row, column, c] += linear[picture[y, x, c]]
    return out / np.float32(side * side)


def mean_colour(light: np.ndarray) -> np.ndarray:
    """Return (rows, columns): the mean of three colours, float32 (rows, columns, 3), as numpy has it."""
    mean: np.ndarray = (light[..., 0] + light[..., 1] + light[..., 2]) / np.float32(3.0)
    return mean


@njit(cache=True)
def light_of(values: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """Return (height, width), float32: the light of sRGB values, uint8. linear: (256,) that of each value."""
    out = np.empty(values.shape, np.float32)
    for y in range(values.shape[0]):
        for x in range(values.shape[1]):
            out[y, x] = linear[values[y, x]]
    return out


@njit(cache=True)
def block_means(light: np.ndarray, times: int) -> np.ndarray:
    """Return (height // times, width // times), float32: means of squares. light: (height, width), float32.

    With less than 8 px along a side the sums have numpy's order, so the last bit is the same.
    """
    rows, columns = light.shape[0] // times, light.shape[1] // times
    out = np.zeros((rows, columns), np.float32)
    for y in range(rows * times):
        for column in range(columns):
            total = np.float32(0.0)
            for x in range(column * times, (column + 1) * times):
                total += light[y, x]
            out[y // times, column] += total
    return out / np.float32(times * times)


@njit(cache=True)
def dark_ridges(light: np.ndarray, reach: int, contrasts: np.ndarray, side: int) -> np.ndarray:
    """Return (height, width) bool: pixels darker than both sides, `reach` px away, along some direction.

    A step has no darker middle, so edges between two tones are none. light: (height, width), float32.
    contrasts: least share of light that the middle lacks, in blocks of `side` px; 1: nothing counts there.
    """
    out = np.zeros(light.shape, np.bool_)
    slant = max(1, round(0.7071 * reach))
    for y in range(reach, light.shape[0] - reach):
        row = min(y // side, contrasts.shape[0] - 1)
        for x in range(reach, light.shape[1] - reach):
            contrast = contrasts[row, min(x // side, contrasts.shape[1] - 1)]
            if contrast >= 1.0:
                continue
            most = light[y, x] / (1.0 - contrast)
            out[y, x] = (
                (light[y, x - reach] > most and light[y, x + reach] > most)
                or (light[y - reach, x] > most and light[y + reach, x] > most)
                or (light[y - slant, x - slant] > most and light[y + slant, x + slant] > most)
                or (light[y - slant, x + slant] > most and light[y + slant, x - slant] > most)
            )
    return out


@njit(cache=True)
def ridge_strength(values: np.ndarray, factor: float) -> np.ndarray:
    """Return (height, width), float32: the largest eigenvalue of the Hessian, times a factor; at least 0.

    values: (height, width), float32. The second differences are those of neighbouring pixels.
    """
    height, width = values.shape
    out = np.zeros((height, width), np.float32)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            middle = 2.0 * values[y, x]
            xx = values[y, x - 1] - middle + values[y, x + 1]
            yy = values[y - 1, x] - middle + values[y + 1, x]
            xy = 0.25 * (
                values[y - 1, x - 1] + values[y + 1, x + 1] - values[y - 1, x + 1] - values[y + 1, x - 1]
            )
            half = 0.5 * (xx - yy)
            largest = 0.5 * (xx + yy) + np.sqrt(half * half + xy * xy)
            out[y, x] = factor * max(largest, 0.0)
    return out


@njit(cache=True)
def raise_to_multiples(
    above: np.ndarray, strength: np.ndarray, usual: np.ndarray, y: np.ndarray, x: np.ndarray, least: float
) -> None:
    """Raise `above`, (height, width), float32, to strength / usual where that is greater.

    usual: (rows, columns) around the middles of blocks; between them it is interpolated, and it is `least` at
    least. y: (height,), x: (width,): places of the pixels among the blocks, in blocks.
    """
    rows, columns = usual.shape
    line, known = np.empty((2, len(x))), -1
    for row in range(len(y)):
        top = int(y[row])
        part = y[row] - top
        if top != known:
            known = top
            for k in range(2):
                of_blocks = usual[min(top + k, rows - 1)]
                for column in range(len(x)):
                    left = min(int(x[column]), columns - 1)
                    right = min(left + 1, columns - 1)
                    slope = of_blocks[right] - of_blocks[left]
                    line[k, column] = slope * (x[column] - left) + of_blocks[left]
        for column in range(len(x)):
            around = (1.0 - part) * line[0, column] + part * line[1, column]
            multiple = strength[row, column] / np.float32(max(around, least))
            above[row, column] = max(above[row, column], multiple)


@njit(cache=True)
def block_texture(values: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return three of (height // side, width // side), float32, of the blocks of an image, float32.

    The standard deviation of the values; the mean square of their gradient; the same times the cosine of four
    times its direction, so that level and upright edges count 1 and slanted ones -1. The gradient is Sobel's.
    """
    height, width = values.shape
    out = np.zeros((3, height // side, width // side), np.float32)
    for row in range(out.shape[1]):
        for column in range(out.shape[2]):
            total = squares = edges = along = 0.0
            for y in range(row * side, (row + 1) * side):
                up, down = max(y - 1, 0), min(y + 1, height - 1)
                for x in range(column * side, (column + 1) * side):
                    left, right = max(x - 1, 0), min(x + 1, width - 1)
                    total += values[y, x]
                    squares += values[y, x] ** 2
                    gx = 0.125 * (
                        values[up, right] - values[up, left] + values[down, right] - values[down, left]
                    )
                    gx += 0.25 * (values[y, right] - values[y, left])
                    gy = 0.125 * (
                        values[down, left] - values[up, left] + values[down, right] - values[up, right]
                    )
                    gy += 0.25 * (values[down, x] - values[up, x])
                    square = gx * gx + gy * gy
                    edges += square
                    if square > 0.0:
                        along += square - 8.0 * (gx * gy) ** 2 / square
            count = side * side
            out[0, row, column] = np.sqrt(max(squares / count - (total / count) ** 2, 0.0))
            out[1, row, column] = edges / count
            out[2, row, column] = along / count
    return out[0], out[1], out[2]
