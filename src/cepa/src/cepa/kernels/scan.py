"""Kernel of the scan's normalisation."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

DROPOUT = -1.0


@njit(cache=True)
def normalise(
    raw: np.ndarray,
    seen_raw: np.ndarray,
    reverse: bool,
    range_min: float,
    range_max: float,
    too_close: float,
    dropout_beams: int,
    ranges: np.ndarray,
    seen: np.ndarray,
) -> None:
    """Put ``raw`` (n,), read by REP-117, onto a full turn: ``ranges`` (N,), +inf: nothing; ``seen`` (N,).

    What is nearer than ``range_min`` is put at ``too_close``.
    """
    if _place(raw, seen_raw, reverse, range_min, range_max, too_close, ranges, seen):
        _fill_dropouts(dropout_beams, ranges, seen)


@njit(cache=True)
def _place(
    raw: np.ndarray,
    seen_raw: np.ndarray,
    reverse: bool,
    range_min: float,
    range_max: float,
    too_close: float,
    ranges: np.ndarray,
    seen: np.ndarray,
) -> bool:
    """Return whether there are dropouts."""
    n = raw.size
    count = ranges.size
    drops = False
    for k in range(n, count):
        ranges[k], seen[k] = np.inf, False
    for k in range(n):
        source = n - 1 - k if reverse else k
        if k < count:
            ranges[k], seen[k] = np.inf, False
        if not seen_raw[source]:
            continue
        value = raw[source]
        if value == -np.inf or 0.0 < value < range_min:
            value = too_close
        elif value > range_max:
            value = np.inf
        elif math.isnan(value) or value <= 0.0:  # drivers say 0 or less when a reading failed
            value = DROPOUT
            drops = True
        target = k if k < count else k - count
        if (
            seen[target] and ranges[target] != DROPOUT
        ):  # one beam more than a turn: the nearer of the two counts
            value = ranges[target] if value == DROPOUT else min(value, ranges[target])
        ranges[target] = value
        seen[target] = True
    return drops


@njit(cache=True)
def _fill_dropouts(dropout_beams: int, ranges: np.ndarray, seen: np.ndarray) -> None:
    count = ranges.size
    start = 0
    while start < count and ranges[start] == DROPOUT:
        start += 1
    if start == count:
        ranges[:] = np.inf
        seen[:] = False
        return
    k = 0
    while k < count:
        i = start + k if start + k < count else start + k - count
        if ranges[i] != DROPOUT:
            k += 1
            continue
        width = 1
        while ranges[(i + width) % count] == DROPOUT:
            width += 1
        before = (i - 1) % count
        after = (i + width) % count
        known = seen[before] or seen[after]
        value = min(ranges[before], ranges[after])  # an unseen neighbour is +inf and never the smaller one
        for step in range(width):
            target = (i + step) % count
            if known and width <= dropout_beams:
                ranges[target] = value
            else:
                ranges[target] = np.inf
                seen[target] = False
        k += width
