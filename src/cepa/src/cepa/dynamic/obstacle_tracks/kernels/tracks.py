"""Kalman filters of constant velocity, one for each track."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import RESIZED_M, RESIZED_SHARE
from cepa.dynamic.obstacle_tracks.kernels.columns import (
    EVIDENCE,
    HIDDEN,
    MIDDLE_X,
    MIDDLE_Y,
    NORMALS,
    PP,
    PV,
    RADIUS,
    REACH,
    SIZE,
    TILTED,
    UNSEEN,
    VV,
    VX,
    VY,
    X,
    Y,
)
from cepa.dynamic.obstacle_tracks.kernels.sides import reaches_of, shift_of
from kernel_cache.compiler import njit


@njit(cache=True)
def predict(tracks: np.ndarray, dt: float, acceleration: float) -> None:
    """Move tracks on by ``dt`` s at constant velocity; acceleration: m/s2, its standard deviation for 1 s.

    Out of sight a thing is taken to go on as it did. Else its disc would soon fill every way past it.
    """
    for k in range(tracks.shape[0]):
        track = tracks[k]
        q = acceleration * acceleration * dt if track[UNSEEN] == 0.0 else 0.0
        track[X] += dt * track[VX]
        track[Y] += dt * track[VY]
        track[PP] += dt * (2.0 * track[PV] + dt * track[VV]) + q * dt * dt / 3.0
        track[PV] += dt * track[VV] + 0.5 * q * dt
        track[VV] += q
        track[UNSEEN] += dt


@njit(cache=True)
def associate(
    clusters: np.ndarray,
    tracks: np.ndarray,
    gate: float,
    unwatched: np.ndarray,
    matches: np.ndarray,
    owners: np.ndarray,
) -> None:
    """Fill ``matches`` (c,) with each cluster's track or -1, ``owners`` (t,) with each track's cluster or -1.

    A pair is each other's nearest, within ``gate`` m plus three standard deviations and half the radius.
    Of what moves, a part alone may be in sight, so all of its radius counts. What is ``unwatched`` (t,) moves
    on where no beam looks. Nothing tells against its predicted place, so its standard deviations do not
    count. Else it would soon be taken for its neighbour.
    """
    for c in range(clusters.shape[0]):
        best = math.inf
        matches[c] = -1
        for t in range(tracks.shape[0]):
            d = _separation(clusters[c], tracks[t])
            share = 1.0 if tracks[t, EVIDENCE] > 0.0 else 0.5
            spread = 0.0 if unwatched[t] else 3.0 * math.sqrt(tracks[t, PP])
            if d < best and d < gate + spread + share * tracks[t, RADIUS]:
                best = d
                matches[c] = t
    for t in range(tracks.shape[0]):
        best = math.inf
        owners[t] = -1
        for c in range(clusters.shape[0]):
            if matches[c] == t:
                d = _separation(clusters[c], tracks[t])
                if d < best:
                    best = d
                    owners[t] = c
    for c in range(clusters.shape[0]):
        if matches[c] >= 0 and owners[matches[c]] != c:
            matches[c] = -1


@njit(cache=True)
def _separation(cluster: np.ndarray, track: np.ndarray) -> float:
    return math.hypot(cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y])


@njit(cache=True)
def correct(
    tracks: np.ndarray,
    clusters: np.ndarray,
    owners: np.ndarray,
    points: np.ndarray,
    pose: np.ndarray,
    deviation: float,
    deviation_hidden: float,
    memory: float,
    learning: float,
) -> None:
    """Take the sides of the clusters as measurements of their tracks; deviations in m.

    The middle of what is in sight jumps when another side comes into sight, or a part goes out of it. A side
    does not. The track learns by the share ``learning`` where its sides are, and at once where a new one is.
    Before it moves, a thing without a known side is measured by its middle. ``memory`` (0 to 1) of the disc's
    radius is left after each scan, and then it grows and shifts so that it holds the cluster. A lidar that
    leans may see less of a thing because its beams pass over the rest. Then a tilted end is cut.
    """
    reaches, shift, are_new = np.empty(NORMALS.shape[0]), np.empty(2), np.empty(NORMALS.shape[0], np.bool_)
    for t in range(tracks.shape[0]):
        if owners[t] < 0:
            continue
        track, cluster = tracks[t], clusters[owners[t]]
        track[UNSEEN] = 0.0
        is_smaller = cluster[SIZE] < track[RADIUS] - max(RESIZED_M, RESIZED_SHARE * track[RADIUS])
        reaches_of(points, cluster, pose, TILTED if is_smaller else HIDDEN, reaches)
        sigma = deviation
        known = shift_of(reaches, track, shift, are_new)
        if known == 0 and track[EVIDENCE] == 0.0:
            shift[0], shift[1] = cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y]
            sigma = deviation_hidden
        if known > 0 or track[EVIDENCE] == 0.0:
            gain = 1.0 / (track[PP] + sigma * sigma)
            gain_p, gain_v = track[PP] * gain, track[PV] * gain
            track[X] += gain_p * shift[0]
            track[Y] += gain_p * shift[1]
            track[VX] += gain_v * shift[0]
            track[VY] += gain_v * shift[1]
            track[VV] -= gain_v * track[PV]
            track[PV] *= 1.0 - gain_p
            track[PP] *= 1.0 - gain_p
        for k in range(NORMALS.shape[0]):
            reach = reaches[k] - NORMALS[k, 0] * track[X] - NORMALS[k, 1] * track[Y]
            if math.isnan(track[REACH + k]) or are_new[k]:
                track[REACH + k] = reach
            elif not math.isnan(reach):
                track[REACH + k] += learning * (reach - track[REACH + k])
        _hold(track, cluster, memory)


@njit(cache=True)
def _hold(track: np.ndarray, cluster: np.ndarray, memory: float) -> None:
    """Shrink a track's disc to ``memory``; then make it the least one that holds it and the cluster."""
    radius, size = memory * track[RADIUS], cluster[SIZE]
    x, y = cluster[MIDDLE_X] - track[X], cluster[MIDDLE_Y] - track[Y]
    apart = math.hypot(x, y)
    track[RADIUS] = max(radius, size, 0.5 * (radius + apart + size))
    if radius < apart + size:
        share = (track[RADIUS] - radius) / apart if size < apart + radius else 1.0
        track[X] += share * x
        track[Y] += share * y
        for k in range(NORMALS.shape[0]):
            track[REACH + k] -= share * (NORMALS[k, 0] * x + NORMALS[k, 1] * y)


@njit(cache=True)
def are_fast(
    tracks: np.ndarray, owners: np.ndarray, speed_min: float, significance: float, fast: np.ndarray
) -> None:
    """Fill ``fast`` (t,) with which tracks are in sight and have a velocity that counts.

    It is above ``speed_min``, m/s, and above so many standard deviations.
    """
    for t in range(tracks.shape[0]):
        least = max(speed_min, significance * math.sqrt(tracks[t, VV]))
        fast[t] = owners[t] >= 0 and math.hypot(tracks[t, VX], tracks[t, VY]) > least


@njit(cache=True)
def weigh(
    tracks: np.ndarray,
    owners: np.ndarray,
    fast: np.ndarray,
    shown: np.ndarray,
    dt: float,
    losses: tuple[float, float],
    enough: float,
    most: float,
    speed_min: float,
    moving: np.ndarray,
) -> None:
    """Update the evidence of the tracks in sight, and which tracks are ``moving`` (t,).

    The evidence grows by ``dt``, s, for a track that has ``shown`` (t,) that it moves, up to ``most``. It
    falls by the first of the losses for one that is ``fast`` (t,), and else by the second. From ``enough`` on
    a track faster than ``speed_min``, m/s, is moving, until there is no evidence any more.
    """
    for t in range(tracks.shape[0]):
        change = 0.0
        if owners[t] >= 0:
            change = 1.0 if shown[t] else -losses[0] if fast[t] else -losses[1]
        evidence = min(max(tracks[t, EVIDENCE] + dt * change, 0.0), most)
        tracks[t, EVIDENCE] = evidence
        starts = evidence > enough and math.hypot(tracks[t, VX], tracks[t, VY]) > speed_min
        moving[t] = starts or (moving[t] and evidence > 0.0)
