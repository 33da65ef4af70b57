"""Puts the effects onto a picture that is drawn: colours, light on the relief, highlights on water."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.camera.effects.colour import WET, coat, film
from simulation_tools.camera.effects.relief import PITTING, SCALE, WAVINESS, WELDS, height
from simulation_tools.camera.kernels import agree

LEAST_STEP_M = 0.00025
"""The slope is that over a pixel, or over twice this."""
WATER, GLOSS = 0.02, 1500.0
"""What water gives back at normal incidence, and the exponent of its highlight (Blinn and Phong)."""


@njit(cache=True, fastmath=True)
def shade(su: float, sv: float, lu: float, lv: float, ln: float) -> float:
    """Return the light on a slope as a multiple of that on the plane. su, sv: slope. l: to the lamp, unit."""
    facing = (ln - su * lu - sv * lv) / math.sqrt(1.0 + su * su + sv * sv)
    return max(facing, 0.0) / max(ln, 0.02)


@njit(cache=True, fastmath=True)
def highlight(
    su: float, sv: float, lu: float, lv: float, ln: float, eu: float, ev: float, en: float
) -> float:
    """Return what water mirrors, as the albedo that would be as bright. l, e: to lamp and eye, unit."""
    hu, hv, hn = lu + eu, lv + ev, ln + en
    long = math.sqrt(hu * hu + hv * hv + hn * hn) + 1e-9
    near = (hn - su * hu - sv * hv) / (long * math.sqrt(1.0 + su * su + sv * sv))
    if near < 0.95:
        return 0.0
    grazing = 1.0 - (eu * hu + ev * hv + en * hn) / long
    mirrored = WATER + (1.0 - WATER) * grazing**5
    return mirrored * (GLOSS + 2.0) / 8.0 * near**GLOSS


@njit(cache=True, fastmath=True)
def overlay(
    picture: np.ndarray,
    x0: int,
    y0: int,
    size: int,
    face: int,
    corners: np.ndarray,
    layout: tuple,
    lamp: np.ndarray,
    eye: np.ndarray,
    gain: float,
    ambient: float,
    rgb: np.ndarray,
) -> None:
    """Change a cell of the picture as `kernels.fill` has drawn it.

    lamp, eye: (3,) in the world. rgb: (3,) to use.
    """
    if face < 0:
        return
    rows, columns = picture.shape[:2]
    amounts, seed, seams, _, shifts, axes, offsets, _, _, clouds = layout
    shift = shifts[face]
    across = math.hypot(corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1])
    down = math.hypot(corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1])
    footprint = max(max(across, down) / size, 1e-6)
    step = max(0.5 * footprint, LEAST_STEP_M)
    relief = amounts[WELDS] + amounts[WAVINESS] + amounts[SCALE] + amounts[PITTING] > 0.0
    side = 1.0 if _along(axes[face, 0], eye) > offsets[face] else -1.0
    lamp_u, lamp_v = _along(axes[face, 1], lamp), _along(axes[face, 2], lamp)
    lamp_n = side * (_along(axes[face, 0], lamp) - offsets[face])
    eye_u, eye_v = _along(axes[face, 1], eye), _along(axes[face, 2], eye)
    eye_n = side * (_along(axes[face, 0], eye) - offsets[face])
    for y in range(y0, min(y0 + size, rows)):
        t = (y - y0) / size
        for x in range(x0, min(x0 + size, columns)):
            s = (x - x0) / size
            u, v, lux, passed = (
                _between(corners, 0, s, t), _between(corners, 1, s, t), _between(corners, 2, s, t),
                _between(corners, 3, s, t),
            )  # fmt: skip
            rgb[0] = rgb[1] = rgb[2] = 1.0
            coat(u, v, face, footprint, layout, rgb)
            su = sv = 0.0
            if relief:
                args = (amounts, seed, seams, shift, clouds, footprint)
                su = (height(u + step, v, *args) - height(u - step, v, *args)) / (2.0 * step)
                sv = (height(u, v + step, *args) - height(u, v - step, *args)) / (2.0 * step)
            lu, lv = lamp_u - u, lamp_v - v
            far = math.sqrt(lu * lu + lv * lv + lamp_n * lamp_n) + 1e-9
            lu, lv, ln = lu / far, lv / far, max(lamp_n / far, 1e-3)
            much = (lux * shade(su, sv, lu, lv, ln) + ambient) / max(lux + ambient, 1e-9)
            glare = 0.0
            if amounts[WET] > 0.0 and lux > 0.0:
                eu, ev = eye_u - u, eye_v - v
                way = math.sqrt(eu * eu + ev * ev + eye_n * eye_n) + 1e-9
                mirrored = highlight(su, sv, lu, lv, ln, eu / way, ev / way, eye_n / way)
                glare = gain * lux * passed * mirrored * film(u, v, amounts[WET], shift, clouds)
            for c in range(3):
                value = picture[y, x, c] * rgb[c] * much + glare
                picture[y, x, c] = np.uint16(min(max(value, 0.0), 65535.0))


@njit(cache=True, fastmath=True)
def _along(axis: np.ndarray, place: np.ndarray) -> float:
    return axis[0] * place[0] + axis[1] * place[1] + axis[2] * place[2]


@njit(cache=True, fastmath=True)
def _between(corners: np.ndarray, what: int, s: float, t: float) -> float:
    """Return a number of the four corners of a cell at shares of its width and height."""
    above = corners[0, what] * (1 - s) + corners[1, what] * s
    return above * (1 - t) + (corners[2, what] * (1 - s) + corners[3, what] * s) * t


@njit(cache=True, fastmath=True)
def overlay_grid(
    picture: np.ndarray,
    faces: np.ndarray,
    mixed: np.ndarray,
    lights: np.ndarray,
    step: int,
    layout: tuple,
    lamp: np.ndarray,
    eye: np.ndarray,
    gain: float,
    ambient: float,
) -> None:
    """Change all cells of a grid that are not mixed, as `kernels.fill_grid` has drawn them."""
    corners, rgb = np.empty((4, 4)), np.empty(3)
    for row in range(mixed.shape[0]):
        for column in range(mixed.shape[1]):
            if not mixed[row, column]:
                corners[0], corners[1] = lights[row, column], lights[row, column + 1]
                corners[2], corners[3] = lights[row + 1, column], lights[row + 1, column + 1]
                overlay(picture, column * step, row * step, step, faces[row, column], corners, layout,
                        lamp, eye, gain, ambient, rgb)  # fmt: skip


@njit(cache=True, fastmath=True)
def overlay_patches(
    picture: np.ndarray,
    places: np.ndarray,
    faces: np.ndarray,
    lit: np.ndarray,
    lights: np.ndarray,
    layout: tuple,
    lamp: np.ndarray,
    eye: np.ndarray,
    gain: float,
    ambient: float,
) -> None:
    """Change mixed cells of 8 x 8 px, as `kernels.fill_patches` has drawn them, each pixel once."""
    corners, rgb = np.empty((4, 4)), np.empty(3)
    for k in range(len(places)):
        for size in (4, 2, 1):
            for y in range(0, 8, size):
                for x in range(0, 8, size):
                    if size < 4 and agree(faces[k], lit[k], x // 4 * 4, y // 4 * 4, 4):
                        continue
                    if size < 2 and agree(faces[k], lit[k], x // 2 * 2, y // 2 * 2, 2):
                        continue
                    if size > 1:
                        if not agree(faces[k], lit[k], x, y, size):
                            continue
                        corners[0], corners[1] = lights[k, y, x], lights[k, y, x + size]
                        corners[2], corners[3] = lights[k, y + size, x], lights[k, y + size, x + size]
                    else:
                        corners[0] = corners[1] = corners[2] = corners[3] = lights[k, y, x]
                        corners[1, 0] += 0.001
                    overlay(picture, places[k, 0] + x, places[k, 1] + y, size, faces[k, y, x], corners,
                            layout, lamp, eye, gain, ambient, rgb)  # fmt: skip


@njit(cache=True, fastmath=True)
def tints(faces: np.ndarray, lights: np.ndarray, footprint: float, layout: tuple, out: np.ndarray) -> None:
    """Fill out (n, 3): what the effects leave of the light of places. lights: (n, 4) of `kernels.light`."""
    for k in range(len(faces)):
        out[k, 0] = out[k, 1] = out[k, 2] = 1.0
        if faces[k] >= 0:
            coat(lights[k, 0], lights[k, 1], faces[k], footprint, layout, out[k])
