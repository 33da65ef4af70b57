"""What the best photograph from a place would show that none shows yet."""

from __future__ import annotations

import math

import numpy as np

from inspection.survey.kernels.sight import axes_of, eye_of, is_drawn, triple
from kernel_cache.compiler import njit

YAWS, TILTS = 48, 25
"""Directions that are tried: 7.5 deg apart, all around and from straight down to straight up."""
EXACT = 4
"""Of the directions with the most in their frame, so many are judged exactly."""
HALVINGS = 2
"""The best of them is turned by half a step, a quarter, and so on."""


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
    """Return for each tilt of a line of sight which directions of the camera have it in their frame.

    lens: (4,) of `is_drawn`. tilts: (2,) least and greatest of the gimbal, rad; beyond them is no direction.

    Returns begins (TILTS + 1,) and runs (k, 3): the camera's tilt, and numbers of steps in yaw, `first` and
    `length`. The camera's yaw lies from `first` beyond that of the line of sight to before first + length.
    """
    begins, runs = np.zeros(TILTS + 1, np.int64), np.empty((TILTS * TILTS * YAWS, 3), np.int64)
    count = 0
    for other in range(TILTS):
        for t in range(TILTS):
            tilt = (t / (TILTS - 1) - 0.5) * math.pi
            if not tilts[0] - 1e-6 <= tilt <= tilts[1] + 1e-6:
                continue
            has = _has_in_frame(lens, tilt, (other / (TILTS - 1) - 0.5) * math.pi)
            for first in range(YAWS):
                if has[first] and (not has[first - 1] or (first == 0 and has.all())):
                    length = 1
                    while length < YAWS and has[(first + length) % YAWS]:
                        length += 1
                    runs[count, 0], runs[count, 1], runs[count, 2] = t, first, length
                    count += 1
        begins[other + 1] = count
    return begins, runs[:count].copy()


@njit(cache=True, nogil=True)
def _has_in_frame(lens: np.ndarray, tilt: float, line_tilt: float) -> np.ndarray:
    """Return for each yaw (YAWS,) of the camera if it has a line of sight of yaw 0 in its frame."""
    has = np.zeros(YAWS, np.bool_)
    way = np.array((math.cos(line_tilt), 0.0, math.sin(line_tilt)))
    for yaw in range(YAWS):
        axes = axes_of(2.0 * math.pi * yaw / YAWS, tilt)
        z = (axes[:, 2] * way).sum()
        if z > 1e-6:
            x, y = (axes[:, 0] * way).sum() / z, (axes[:, 1] * way).sum() / z
            has[yaw] = abs(x) <= lens[0] and abs(y) <= lens[1]
    return has


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
    total, eye = 0.0, eye_of(place, axes, lens)
    for m in seen:
        if worth[m] > 0.0 and is_drawn(eye, triple(points[m]), triple(normals[m])):
            total += worth[m]
    return total


@njit(cache=True, nogil=True)
def worth_of_directions(
    bins: np.ndarray, worth: np.ndarray, frame_begins: np.ndarray, frame_runs: np.ndarray
) -> np.ndarray:
    """Return (TILTS, YAWS) the worth (k,) of the points, with their bins (k,), in each direction's frame."""
    sums = np.zeros((TILTS, YAWS))
    for k in range(len(bins)):
        sums[bins[k] // YAWS, bins[k] % YAWS] += worth[k]
    steps = np.zeros((TILTS, 2 * YAWS + 1))
    for other in range(TILTS):
        for yaw in range(YAWS):
            if sums[other, yaw] > 0.0:
                for k in range(frame_begins[other], frame_begins[other + 1]):
                    t, first, length = frame_runs[k, 0], frame_runs[k, 1], frame_runs[k, 2]
                    begin = (yaw + first) % YAWS
                    steps[t, begin] += sums[other, yaw]
                    steps[t, begin + length] -= sums[other, yaw]
    totals = np.zeros((TILTS, YAWS))
    for t in range(TILTS):
        total = 0.0
        for k in range(2 * YAWS):
            total += steps[t, k]
            totals[t, k % YAWS] += total
    return totals


@njit(cache=True, nogil=True)
def best_view(
    place: np.ndarray,
    seen: np.ndarray,
    bins: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    worth: np.ndarray,
    lens: np.ndarray,
    tilts: np.ndarray,
    frame_begins: np.ndarray,
    frame_runs: np.ndarray,
) -> tuple[float, float, float]:
    """Return the gain, the yaw and the tilt, rad, of the best photograph from a place.

    The direction with the most worth in its frame is sought on a raster, and then turned by less than a step.
    """
    counts = np.zeros(len(seen), np.bool_)
    for k in range(len(seen)):
        counts[k] = worth[seen[k]] > 0.0
    seen, bins = seen[counts], bins[counts]
    best, best_yaw, best_tilt = 0.0, 0.0, 0.0
    if len(seen) == 0:
        return best, best_yaw, best_tilt
    flat = worth_of_directions(bins, worth[seen], frame_begins, frame_runs).reshape(-1)
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
    return turned_better(best, best_yaw, best_tilt, place, seen, points, normals, worth, lens, tilts)


@njit(cache=True, nogil=True)
def turned_better(
    gain: float,
    yaw: float,
    tilt: float,
    place: np.ndarray,
    seen: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    worth: np.ndarray,
    lens: np.ndarray,
    tilts: np.ndarray,
) -> tuple[float, float, float]:
    """Return the gain, yaw and tilt of the photograph, turned by less than a step if it shows more then."""
    step = 2.0 * math.pi / YAWS
    for _ in range(HALVINGS):
        step *= 0.5
        middle_yaw, middle_tilt = yaw, tilt
        for right, up in ((step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)):
            turned, tilted = middle_yaw + right, middle_tilt + up
            if tilts[0] <= tilted <= tilts[1]:
                shown = gain_of(place, axes_of(turned, tilted), lens, seen, points, normals, worth)
                if shown > gain:
                    gain, yaw, tilt = shown, turned, tilted
    return gain, yaw, tilt


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
    tilts: np.ndarray,
    frame_begins: np.ndarray,
    frame_runs: np.ndarray,
) -> np.ndarray:
    """Return (k, 3) gain, yaw and tilt of the best photograph from each chosen (k,) place."""
    found = np.zeros((len(chosen), 3))
    for k in range(len(chosen)):
        n = chosen[k]
        part = slice(begins[n], begins[n + 1])
        found[k] = best_view(
            places[n], seen[part], bins[part], points, normals, worth, lens, tilts, frame_begins, frame_runs
        )
    return found


@njit(cache=True, nogil=True)
def likely_gains(
    chosen: np.ndarray,
    begins: np.ndarray,
    seen: np.ndarray,
    bins: np.ndarray,
    worth: np.ndarray,
    frame_begins: np.ndarray,
    frame_runs: np.ndarray,
) -> np.ndarray:
    """Return (k,) the most worth in one direction's frame, from each chosen (k,) place.

    It is seldom less than the gain of `best_views`, which draws less of the frame, and is found much sooner.
    """
    found = np.zeros(len(chosen))
    for k in range(len(chosen)):
        part = slice(begins[chosen[k]], begins[chosen[k] + 1])
        counts = np.zeros(len(seen[part]), np.bool_)
        for m in range(len(counts)):
            counts[m] = worth[seen[part][m]] > 0.0
        if counts.any():
            there = worth[seen[part][counts]]
            found[k] = worth_of_directions(bins[part][counts], there, frame_begins, frame_runs).max()
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
    kept, eye = np.zeros(len(seen), np.bool_), eye_of(place, axes, lens)
    for k in range(len(seen)):
        kept[k] = is_drawn(eye, triple(points[seen[k]]), triple(normals[seen[k]]))
    return seen[kept]


@njit(cache=True, nogil=True)
def sums_alone(
    begins: np.ndarray,
    drawn: np.ndarray,
    counts: np.ndarray,
    areas: np.ndarray,
    parts: np.ndarray,
    names: int,
) -> np.ndarray:
    """Return (n, names) the area of the points that one photograph alone draws, by the thing they are of.

    begins: (n + 1,) of the points drawn by each photograph. counts: (m,) photographs that draw each point.
    """
    sums = np.zeros((len(begins) - 1, names))
    for shot in range(len(begins) - 1):
        for k in range(begins[shot], begins[shot + 1]):
            if counts[drawn[k]] == 1:
                sums[shot, parts[drawn[k]]] += areas[drawn[k]]
    return sums
