"""The evidence that a thing moves: it is where scans saw nothing, or gone from where they saw it."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import EVIDENCE_HEIGHT_M, HEADING_ERROR_RAD
from kernel_cache.compiler import njit


@njit(cache=True)
def _is_free(
    x: float, y: float, from_x: float, from_y: float, turn: float, bins: np.ndarray, gap: float
) -> bool:
    """Whether a scan from (from_x, from_y) sees past (x, y) by more than ``gap`` m.

    bins (m,): how far it sees in equal directions from ``turn`` rad, m, negative where it does not look. All
    directions that pass within half a ``gap`` or HEADING_ERROR_RAD must agree, so the edge of a standing
    thing never counts.
    """
    dx, dy = x - from_x, y - from_y
    distance = math.sqrt(dx * dx + dy * dy)
    if distance < gap:
        return False
    per_rad = bins.size / (2.0 * math.pi)
    middle = math.floor((math.atan2(dy, dx) - turn) * per_rad + 0.5)
    guard = math.ceil((0.5 * gap / distance + HEADING_ERROR_RAD) * per_rad + 0.5)
    least = math.inf
    for b in range(middle - guard, middle + guard + 1):
        least = min(least, bins[b % bins.size])
    return least >= distance + gap


@njit(cache=True)
def are_free(places: np.ndarray, pose: np.ndarray, bins: np.ndarray, gap: float, free: np.ndarray) -> None:
    """Fill ``free`` (t,) with whether the scan sees past each of ``places`` (t, 2); see ``_is_free``."""
    for t in range(places.shape[0]):
        free[t] = _is_free(places[t, 0], places[t, 1], pose[0], pose[1], pose[2], bins, gap)


@njit(cache=True)
def are_behind(places: np.ndarray, pose: np.ndarray, bins: np.ndarray, behind: np.ndarray) -> None:
    """Fill ``behind`` (t,) with whether each of ``places`` (t, 2) is where no beam of the scan looks."""
    per_rad = bins.size / (2.0 * math.pi)
    for t in range(places.shape[0]):
        direction = math.atan2(places[t, 1] - pose[1], places[t, 0] - pose[0]) - pose[2]
        behind[t] = bins[math.floor(direction * per_rad + 0.5) % bins.size] < 0.0


@njit(cache=True)
def _height(x: float, y: float, pose: np.ndarray, plane: np.ndarray) -> float:
    """Return the height of a scan's plane at (x, y), m. plane (3,): the lidar's height, and its falls."""
    return plane[0] - plane[1] * (x - pose[0]) - plane[2] * (y - pose[1])


@njit(cache=True)
def _has_moved(
    points: np.ndarray,
    first: int,
    end: int,
    surfaces: np.ndarray,
    pose: np.ndarray,
    plane: np.ndarray,
    bins: np.ndarray,
    frames: np.ndarray,
    planes: np.ndarray,
    frames_bins: np.ndarray,
    ages: np.ndarray,
    youngest: float,
    gap: float,
    share: float,
    samples: int,
) -> bool:
    """Whether points ``first`` to ``end`` are where scans saw nothing, or gone from where they were.

    surfaces (f, 2): the thing's middle point in earlier scans, NaN where it was not seen. frames (f, 3: x, y,
    turn of the bins), planes (f, 3: the lidar's height, and its plane's falls), frames_bins (f, m), ages
    (f,): those scans. They do not count if they are younger than ``youngest`` s, nor where they look more
    than EVIDENCE_HEIGHT_M higher or lower: there a beam passes under a deck girder, or a wall that slopes is
    elsewhere. pose (3,), plane (3,), bins (m,): the scan's own. ``share`` of ``samples`` points must be in
    the free, each in two earlier scans.
    """
    vacated = 0
    for f in range(ages.size):
        if ages[f] < youngest or math.isnan(surfaces[f, 0]):
            continue
        x, y = surfaces[f, 0], surfaces[f, 1]
        if abs(_height(x, y, frames[f], planes[f]) - _height(x, y, pose, plane)) > EVIDENCE_HEIGHT_M:
            continue
        if _is_free(x, y, pose[0], pose[1], pose[2], bins, gap):
            vacated += 1
    if vacated >= 2:
        return True
    n = points.shape[0]
    size = end - first
    taken = min(samples, size)
    entered = 0
    for s in range(taken):
        k = (first + (s * size + size // 2) // taken) % n
        x, y, times = points[k, 0], points[k, 1], 0
        height = _height(x, y, pose, plane)
        for f in range(ages.size):
            if ages[f] < youngest or abs(_height(x, y, frames[f], planes[f]) - height) > EVIDENCE_HEIGHT_M:
                continue
            if _is_free(x, y, frames[f, 0], frames[f, 1], frames[f, 2], frames_bins[f], gap):
                times += 1
                if times == 2:
                    entered += 1
                    break
    return entered >= max(2.0, share * taken)


@njit(cache=True)
def have_moved(
    points: np.ndarray,
    spans: np.ndarray,
    larger: np.ndarray,
    owners: np.ndarray,
    surfaces: np.ndarray,
    pose: np.ndarray,
    plane: np.ndarray,
    bins: np.ndarray,
    frames: np.ndarray,
    planes: np.ndarray,
    frames_bins: np.ndarray,
    ages: np.ndarray,
    youngest: float,
    gap: float,
    share: float,
    samples: int,
    moved: np.ndarray,
) -> None:
    """Clear ``moved`` (t,) where a track's cluster does not show that it has moved.

    spans (c, 2): first and end index of each cluster's points. larger (t,): so many times less of a long
    thing, and of the more points, must be in the free. owners (t,): each track's cluster. surfaces (t, f, 2);
    the other arguments as in ``_has_moved``.
    """
    for t in range(moved.size):
        if moved[t]:
            span = spans[owners[t]]
            scans = pose, plane, bins, frames, planes, frames_bins, ages
            limits = youngest, gap, share / larger[t], math.ceil(larger[t] * samples)
            moved[t] = _has_moved(points, int(span[0]), int(span[1]), surfaces[t], *scans, *limits)
