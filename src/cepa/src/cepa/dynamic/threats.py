"""Which of what moves the UAV may meet, and whether it is within it."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.choice import (
    FRONT_APART_M,
    FRONT_FILES,
    FRONT_M,
    FRONT_S,
    FRONT_STEP_M,
    HURRIED_S,
    OUTRUN,
    OUTRUN_MOST_M_S,
    SAME_WAY_M_S,
    SEEN_DISC_M,
)
from cepa.dynamic.constants.obstacle_tracks import BESIDE_DISC_M
from cepa.dynamic.constants.response import BRAKE_S, LONGEST_COMMIT_S, MEETING_S, PATH_STEP_S

FORESEEN_S = max(MEETING_S, LONGEST_COMMIT_S + BRAKE_S)
FRONT_SHARES = np.linspace(0.0, 1.0, FRONT_FILES)
"""Where, between two of a group, points are."""
TIMES_S = PATH_STEP_S * np.arange(1, math.ceil(FORESEEN_S / PATH_STEP_S) + 1)


def threats(movers: np.ndarray, speed: float, near_m: float) -> np.ndarray:
    """Return those of ``movers`` (k, 6) that may come within ``near_m`` of a UAV, see `Surroundings`.

    speed: the greatest that the UAV may have, m/s, in any direction. No path that is foreseen comes so near
    to what is left out. So that changes neither what is admissible nor, over the same horizon, what it costs.
    """
    if not len(movers):
        return movers
    x, y, vx, vy, radius_m, growth = (column[:, None] for column in movers.T)
    apart_m = np.hypot(x + vx * TIMES_S, y + vy * TIMES_S) - radius_m - (growth + speed) * TIMES_S
    return movers[apart_m.min(axis=1) <= near_m]


def evasion_speed(movers: np.ndarray, least_m_s: float) -> float:
    """Return with which speed, m/s, the UAV evades ``movers`` (k, 6): faster than who comes nearer.

    People who are as fast as the UAV, side by side, drive it before them for ever.
    """
    x, y, vx, vy = movers[:, :4].T
    fastest = float(np.hypot(vx, vy)[x * vx + y * vy < 0.0].max(initial=0.0))
    return max(least_m_s, min(OUTRUN * fastest, OUTRUN_MOST_M_S))


def is_hurried(columns: np.ndarray, body_m: float) -> bool:
    """Return whether something soon sinks onto the UAV, or rises to it; see `arrives_in_s`."""
    return min(arrives_in_s(columns, body_m)) <= HURRIED_S


def is_within(discs: np.ndarray) -> bool:
    """Return whether the UAV is in one of the discs (k, 6 or more), which count from it as movers do."""
    return bool(len(discs)) and bool(np.any(np.hypot(discs[:, 0], discs[:, 1]) < discs[:, 4]))


def are_within(movers: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return which movers (k, 6) have their middle in one of the columns (c, 6 or more) (k,)."""
    apart = movers[:, None, :2] - columns[None, :, :2]
    return np.asarray((np.hypot(apart[:, :, 0], apart[:, :, 1]) < columns[:, 4]).any(axis=1))


def arrives_in_s(columns: np.ndarray, body_m: float) -> tuple[float, float]:
    """Return in how many s something arrives that sinks onto the body, and that rises to it; inf: nothing.

    columns (k, 8): see `Observation`; it is negative if it has arrived. body_m: radius.
    """
    if not len(columns):
        return math.inf, math.inf  # nearly always
    within = columns[np.hypot(columns[:, 0], columns[:, 1]) < columns[:, 4] + body_m]
    above, below = (within[within[:, 7] == way, 6].min(initial=math.inf) for way in (1.0, -1.0))
    return float(above), float(below)


def as_seen(movers: np.ndarray, points: np.ndarray, delay_s: float) -> np.ndarray:
    """Return ``movers`` (k, 6) as small discs (n, 6) on the points that the scan shows of each.

    points (m, 2), m: what moves in the scan, ``delay_s`` before the movers. A disc around people abreast, or
    around a lorry, reaches far before them. What has no point keeps its disc, and so does a column that a
    load comes down into (it does not grow): who walks through it shows nothing of the load. Nothing grows.
    """
    parts = []
    for mover in movers:
        way_m = delay_s * mover[2:4]
        apart = points - (mover[:2] - way_m)
        own = points[np.hypot(apart[:, 0], apart[:, 1]) < mover[4] + BESIDE_DISC_M]
        if mover[5] == 0.0 or not len(own):
            parts.append(np.array([[*mover[:5], 0.0]]))
            continue
        places = np.unique(np.round(own / SEEN_DISC_M), axis=0) * SEEN_DISC_M + way_m
        discs = np.tile(mover, (len(places), 1))
        discs[:, :2], discs[:, 4], discs[:, 5] = places, SEEN_DISC_M, 0.0
        parts.append(discs)
    return np.concatenate(parts)


def fronts(movers: np.ndarray) -> np.ndarray:
    """Return points (n, 2), m, that close the ways which a group of ``movers`` (k, 6) will close.

    A group moves alike and leaves no room in between, as people abreast. A UAV that flies up to it, to see
    whether a gap is left, has no time to go around. So its way out leads around the group from the start: the
    points are where the group is, and where it comes until FRONT_M before the UAV.
    """
    x, y, vx, vy, radius = movers[:, :5].T
    apart_m = np.hypot(x[:, None] - x, y[:, None] - y) - radius[:, None] - radius
    alike = np.hypot(vx[:, None] - vx, vy[:, None] - vy) < SAME_WAY_M_S
    first, second = np.nonzero(np.triu(alike & (apart_m < FRONT_APART_M), k=1))
    if not len(first):
        return np.empty((0, 2))
    between = [
        movers[i] + share * (movers[j] - movers[i]) for i, j in zip(first, second) for share in FRONT_SHARES
    ]
    return np.concatenate([_sweep(mover) for mover in between])


def _sweep(mover: np.ndarray) -> np.ndarray:
    """Return points (n, 2) along the way of a mover (6,), until it is before the UAV."""
    place, velocity = mover[:2], mover[2:4]
    speed = max(float(np.hypot(*velocity)), 1e-6)
    ahead_m = -float(place @ velocity) / speed - FRONT_M
    length_m = min(max(ahead_m, 0.0), FRONT_S * speed)
    return place + np.arange(0.0, length_m + FRONT_STEP_M, FRONT_STEP_M)[:, None] * velocity / speed
