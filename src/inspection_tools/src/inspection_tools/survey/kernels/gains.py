"""What the best photograph from a place would show that none shows yet."""

from __future__ import annotations

import math

import numpy as np

from inspection_tools.survey.kernels.sight import axes_of, is_drawn
from kernel_cache.compiler import njit

YAWS, TILTS = 48, 25
"""Directions that are tried: 7.5 deg apart, all around and from straight down to straight up."""
EXACT = 4
"""Of the directions with the most in their frame, so many are judged exactly."""


@njit(cache=True, nogil=True)
def bins_of(places: np.ndarray, begins: np.ndarray, seen: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return (k,) the direction, tilt * YAWS + yaw, in which each place sees each of its points."""
    bins = np.empty(len(seen), np.int16)
    for n in range(len(places)):
        for k in range(begins[n], begins[n + 1]):
            way = points[seen[k]] - places[n]
            yaw = round(math.atan2(way[1], way[0]) / (2.0 * math.pi) * YAWS) % YAWS
            tilt = math.atan2(way[2], math.hypot(way[0], way[1]))
            bins[k] = round((tilt / math.pi + 0.5) * (TILTS - 1)) * YAWS + yaw
    return bins


@njit(cache=True, nogil=True)
def frames(lens: np.ndarray, tilts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which directions a camera of yaw 0 has in its frame, for each tilt (deg; least and greatest).

    Returns begins (TILTS + 1,) and (k, 2): tilt and turn of each. A tilt that the gimbal lacks has none.
    """
    begins, found = np.zeros(TILTS + 1, np.int64), np.empty((TILTS * TILTS * YAWS, 2), np.int64)
    count = 0
    for t in range(TILTS):
        tilt = (t / (TILTS - 1) - 0.5) * math.pi
        axes = axes_of(0.0, tilt)
        if tilts[0] - 1e-6 <= math.degrees(tilt) <= tilts[1] + 1e-6:
            for other in range(TILTS):
                level = math.cos((other / (TILTS - 1) - 0.5) * math.pi)
                up = math.sin((other / (TILTS - 1) - 0.5) * math.pi)
                for turn in range(YAWS):
                    angle = 2.0 * math.pi * turn / YAWS
                    way = np.array((level * math.cos(angle), level * math.sin(angle), up))
                    z = (axes[:, 2] * way).sum()
                    if z <= 1e-6:
                        continue
                    x, y = (axes[:, 0] * way).sum() / z, (axes[:, 1] * way).sum() / z
                    if abs(x) <= lens[0] and abs(y) <= lens[1]:
                        found[count, 0], found[count, 1] = other, turn
                        count += 1
        begins[t + 1] = count
    return begins, found[:count].copy()


@njit(cache=True, nogil=True)
def gain_of(
    place: np.ndarray,
    axes: np.ndarray,
    lens: np.ndarray,
    seen: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    worth: np.ndarray,
) -> float:
    """Return what a photograph draws of the points that its place sees (k,), by their worth (n,)."""
    total = 0.0
    for m in seen:
        if worth[m] > 0.0 and is_drawn(place, axes, lens, points[m], normals[m]):
            total += worth[m]
    return total


@njit(cache=True, nogil=True)
def best_view(
    place: np.ndarray,
    seen: np.ndarray,
    bins: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    worth: np.ndarray,
    lens: np.ndarray,
    frame_begins: np.ndarray,
    frame_bins: np.ndarray,
) -> tuple[float, float, float]:
    """Return the gain, the yaw and the tilt, rad, of the best photograph from a place."""
    sums = np.zeros((TILTS, YAWS))
    for k in range(len(seen)):
        sums[bins[k] // YAWS, bins[k] % YAWS] += worth[seen[k]]
    totals = np.zeros((TILTS, YAWS))
    for t in range(TILTS):
        for k in range(frame_begins[t], frame_begins[t + 1]):
            other, turn = frame_bins[k, 0], frame_bins[k, 1]
            for yaw in range(YAWS):
                source = yaw + turn
                totals[t, yaw] += sums[other, source if source < YAWS else source - YAWS]
    best, best_yaw, best_tilt = 0.0, 0.0, 0.0
    flat = totals.reshape(-1)
    for _ in range(EXACT):
        number = int(np.argmax(flat))
        if flat[number] <= best:
            break
        flat[number] = -1.0
        angle = (number % YAWS) * (2.0 * math.pi / YAWS)
        tilt = ((number // YAWS) / (TILTS - 1) - 0.5) * math.pi
        gain = gain_of(place, axes_of(angle, tilt), lens, seen, points, normals, worth)
        if gain > best:
            best, best_yaw, best_tilt = gain, angle, tilt
    return best, best_yaw, best_tilt


@njit(cache=True, nogil=True)
def best_views(
    chosen: np.ndarray,
    places: np.ndarray,
    begins: np.ndarray,
    seen: np.ndarray,
    bins: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    worth: np.ndarray,
    lens: np.ndarray,
    frame_begins: np.ndarray,
    frame_bins: np.ndarray,
) -> np.ndarray:
    """Return (k, 3) gain, yaw and tilt of the best photograph from each chosen (k,) place."""
    found = np.zeros((len(chosen), 3))
    for k in range(len(chosen)):
        n = chosen[k]
        part = slice(begins[n], begins[n + 1])
        found[k] = best_view(
            places[n], seen[part], bins[part], points, normals, worth, lens, frame_begins, frame_bins
        )
    return found


@njit(cache=True, nogil=True)
def drawn_from(
    place: np.ndarray,
    axes: np.ndarray,
    lens: np.ndarray,
    seen: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
) -> np.ndarray:
    """Return which of the points that a place sees (k,) a photograph draws: their numbers."""
    kept = np.zeros(len(seen), np.bool_)
    for k in range(len(seen)):
        kept[k] = is_drawn(place, axes, lens, points[seen[k]], normals[seen[k]])
    return seen[kept]
