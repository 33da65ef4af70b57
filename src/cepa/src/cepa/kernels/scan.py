"""Kernel of the scan's normalisation."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

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
) -> float:
    """Put ``raw`` (n,), read by REP-117, onto a full turn: ``ranges`` (N,), +inf: nothing; ``seen`` (N,).

    What is nearer than ``range_min`` is put at ``too_close``. Return the least of ``ranges``.
    """
    if _place(raw, seen_raw, reverse, range_min, range_max, too_close, ranges, seen):
        _fill_dropouts(dropout_beams, ranges, seen)
    return _least(ranges)


@njit(cache=True, fastmath={"nnan", "nsz"})  # so that several beams go at once
def _least(ranges: np.ndarray) -> float:
    least = np.inf
    for k in range(ranges.size):
        least = ranges[k] if ranges[k] < least else least
    return least


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
    n, count = raw.size, ranges.size
    limits = range_min, range_max, too_close
    for k in range(n, count):
        ranges[k], seen[k] = np.inf, False
    drops = False
    for k in range(min(n, count)):  # without a branch, so that several beams go at once
        source = n - 1 - k if reverse else k
        value = _read(raw[source], *limits) if seen_raw[source] else np.inf
        ranges[k], seen[k] = value, seen_raw[source]
        drops |= value == DROPOUT
    last = 0 if reverse else n - 1
    if n > count and seen_raw[last]:  # one beam more than a turn: the nearer of the two counts
        value = _read(raw[last], *limits)
        drops |= value == DROPOUT
        if seen[0] and ranges[0] != DROPOUT:
            value = ranges[0] if value == DROPOUT else min(value, ranges[0])
        ranges[0], seen[0] = value, True
    return drops


@njit(cache=True)
def _read(value: float, range_min: float, range_max: float, too_close: float) -> float:
    """Return a range as it counts; DROPOUT for a failed reading: not a number, or 0 or less."""
    valid = value > 0.0  # NaN fails, too
    near = (value == -np.inf) | valid & (value < range_min)
    return too_close if near else np.inf if value > range_max else value if valid else DROPOUT


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
