"""Finds what comes down near the UAV, as a load on a hook, by clouds."""

from __future__ import annotations

import math
from collections import deque
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import (
    ARRIVES_S,
    FALLING_APART_M,
    FALLING_BESIDE_M,
    FALLING_BEYOND_M,
    FALLING_CELL_M,
    FALLING_CELLS,
    FALLING_DROP_M,
    FALLING_FEWEST,
    FALLING_HIGHEST_M,
    FALLING_LARGEST_M,
    FALLING_LEVEL_M,
    FALLING_REACH_M,
    FALLING_RESIDUAL_M,
    FALLING_SIGN_KEPT_S,
    FALLING_SIGN_LATE_S,
    FALLING_SIGN_M,
    FALLING_SIGN_S,
    FALLING_SPANS_S,
    FALLING_SPREAD,
    FALLING_UNEVEN,
    FALLING_WALL_M,
    SINKING_FASTEST_M_S,
    SINKING_FORGET_S,
    SINKING_LEAST_M_S,
)
from cepa.dynamic.obstacle_tracks.kernels.falling import fall_rates, lowest_over
from cepa.motion import Motion

NO_COLUMNS = np.empty((0, 8))
NOTHING = np.empty((0, 3)), np.empty(0)


class _Seen(NamedTuple):
    """What one cloud has shown."""

    stamp_s: float
    position_m: tuple[float, float, float]
    lowest_m: np.ndarray
    """(n * n, 3): the lowest point over the body in each cell of the plan; inf: there is none."""
    free_m: np.ndarray
    """(rows, bins): how far it was free in each direction, as `CloudPicture.free`."""
    row_tan: float
    """Height of a row at 1 m."""

    def is_free(self, place_m: np.ndarray) -> bool:
        """Return whether the cloud has seen a place (x, y, z) free, m from the lidar."""
        x, y, z = place_m.tolist()
        h_m, (rows, bins) = max(math.hypot(x, y), 1e-6), self.free_m.shape
        row = math.floor(z / (h_m * self.row_tan) + 0.5 * rows)
        column = math.floor((math.atan2(y, x) + math.pi) * bins / (2.0 * math.pi))
        return 0 <= row < rows and bool(self.free_m[row, column % bins] > h_m)


class _Column(NamedTuple):
    """A disc that something comes down into."""

    x_m: float
    y_m: float
    radius_m: float
    from_s: float
    until_s: float


class _Sign(NamedTuple):
    """Where something may come down, until its speed is known."""

    column: _Column
    cells: np.ndarray
    """(k,): of the plan, in which it was seen."""


class Falling:
    """Keeps how low clouds have seen things over the UAV in each cell of a plan, and tells which come down.

    Something comes down where the lowest point of a cell sinks evenly, into what an earlier cloud has seen
    free. So a wall of which the UAV sees more and more does not fall. All the way that it came must have been
    free, and so must what is beside and below. So the rim of a manhole does not fall, either: what is lowest
    over the UAV there sinks as the UAV does.
    """

    def __init__(self, body_above_m: float) -> None:
        self._above_m = body_above_m
        self.reset()

    def reset(self) -> None:
        """Forget all clouds."""
        self._seen: deque[_Seen] = deque()
        self._columns: list[_Column] = []
        self._sign: _Sign | None = None

    def take_in(self, points: np.ndarray, free_m: np.ndarray, row_tan: float, motion: Motion) -> None:
        """Take in a cloud's points (n, 3), m, along the odometry's axes from the lidar, and what it saw free.

        free_m, row_tan: see `_Seen`.
        """
        if self._seen and not 0.0 < motion.stamp_s - self._seen[-1].stamp_s < FALLING_SPANS_S[-1]:
            self._seen.clear()
        lowest_m, heights = np.empty((FALLING_CELLS * FALLING_CELLS, 3)), (self._above_m, FALLING_HIGHEST_M)
        plan = FALLING_WALL_M, FALLING_REACH_M, FALLING_CELL_M
        lowest_over(points, motion.position_m, heights, *plan, lowest_m)
        self._seen.append(_Seen(motion.stamp_s, motion.position_m, lowest_m, free_m.copy(), row_tan))
        while motion.stamp_s - self._seen[0].stamp_s > FALLING_SPANS_S[-1] + 1e-6:
            self._seen.popleft()
        (cells,) = np.nonzero(self._are_lower(lowest_m[:, 2]))
        if len(cells):
            all_m = np.array([seen.lowest_m[cells, 2] for seen in self._seen])
            for span_s in FALLING_SPANS_S:
                self._close(*self._coming(span_s, lowest_m[cells], all_m), motion)

    def _are_lower(self, heights_m: np.ndarray) -> np.ndarray:
        """Return in which cells (n * n,) the newest heights are lower than shortly before, as few are."""
        short_s, longer_s = FALLING_SPANS_S[:2]
        much_m, little_m = 0.5 * FALLING_DROP_M, 0.5 * longer_s * SINKING_LEAST_M_S
        (short_m, longer_m) = (self._earliest_in(span_s).lowest_m[:, 2] for span_s in (short_s, longer_s))
        is_fast = np.isfinite(short_m) & (heights_m < short_m - much_m)
        return np.asarray(is_fast | (np.isfinite(longer_m) & (heights_m < longer_m - little_m)))

    def _earliest_in(self, span_s: float) -> _Seen:
        """Return the earliest cloud of the last ``span_s``."""
        newest_s = self._seen[-1].stamp_s
        return next(seen for seen in self._seen if newest_s - seen.stamp_s <= span_s + 1e-6)

    def columns(self, motion: Motion, counts_signs: bool = False) -> np.ndarray:
        """Return the discs (k, 8) that something comes down into now, see `Observation`.

        counts_signs: what may come down counts, too, until its speed is known.
        """
        now_s, (x, y, _) = motion.stamp_s, motion.position_m
        self._columns = [column for column in self._columns if column.until_s >= now_s]
        near = [c for c in self._columns if c.from_s <= now_s]
        if counts_signs and not near:
            near = self._signs(motion)
        if not near:
            return NO_COLUMNS
        discs = [(c.x_m - x, c.y_m - y, 0, 0, c.radius_m, 0, c.from_s + ARRIVES_S - now_s, 1) for c in near]
        return np.array(discs, float)

    def _signs(self, motion: Motion) -> list[_Column]:
        """Return where something may come down, see `_new_sign`.

        A UAV that flies on, or leans, may see it no longer. So it counts until it should have arrived, or
        until it is seen to stand.
        """
        found = self._new_sign(motion)
        if found is not None:
            self._sign = found
        elif self._sign is not None:
            is_over = motion.stamp_s > self._sign.column.until_s
            self._sign = None if is_over or self._stands(self._sign.cells) else self._sign
        return [] if self._sign is None else [self._sign.column]

    def _stands(self, cells: np.ndarray) -> bool:
        """Return whether the newest cloud shows something in these cells (k,), and no lower than before."""
        newest_s, now_m = self._seen[-1].stamp_s, self._seen[-1].lowest_m[cells, 2]
        lately = [seen for seen in self._seen if newest_s - seen.stamp_s <= FALLING_SIGN_KEPT_S]
        before_m = np.array([seen.lowest_m[cells, 2] for seen in lately])
        before_m[np.isinf(before_m)] = -math.inf
        is_lower = now_m < before_m.max(axis=0) - 0.5 * FALLING_DROP_M
        return bool(np.isfinite(now_m).any()) and not is_lower.any()

    def _new_sign(self, motion: Motion) -> _Sign | None:
        """Return where something has just come into view over the body, near the UAV, in two clouds.

        What stands in the open is seen from afar. Nearer, it leaves the view upwards. So what comes into view
        from above sinks, and faster than the UAV could fly under it. What stood behind something else comes
        into view, too. So an earlier cloud must have seen its place free.
        """
        now_s = motion.stamp_s
        are_older = [FALLING_SIGN_S <= now_s - seen.stamp_s <= FALLING_SIGN_KEPT_S for seen in self._seen]
        older = [seen for seen, is_older in zip(self._seen, are_older) if is_older]
        if len(older) < FALLING_FEWEST:
            return None
        newest_m, before_m = self._seen[-1].lowest_m, self._seen[-2].lowest_m
        x, y, z = motion.position_m
        (cells,) = np.nonzero(np.isfinite(newest_m[:, 2]))  # few: the rest is not looked at
        cells = cells[np.hypot(newest_m[cells, 0] - x, newest_m[cells, 1] - y) < FALLING_SIGN_M]
        earlier_m = np.array([seen.lowest_m[:, 2] for seen in older])
        cells = cells[np.isinf(earlier_m[:, cells]).all(axis=0)]
        cells = np.array([c for c in cells if _was_seen_free(newest_m[c], older)], np.int64)
        if not len(cells):
            return None
        places = newest_m[cells]
        before = before_m[np.isinf(earlier_m).all(axis=0) & np.isfinite(before_m[:, 2])]
        if not len(before):
            return None
        apart_m = np.hypot(*(before[:, None, :2] - places[None, :, :2]).transpose(2, 0, 1))
        if apart_m.min() > FALLING_APART_M:
            return None
        places = self._with_unseen(places)
        x_m, y_m = places[:, :2].mean(axis=0).tolist()
        radius_m = float(np.hypot(*(places[:, :2] - (x_m, y_m)).T).max()) + FALLING_BEYOND_M
        gap_m = max(0.0, float(places[:, 2].min()) - z - self._above_m)
        arrives_s = now_s + gap_m / SINKING_FASTEST_M_S
        disc = x_m, y_m, radius_m
        return _Sign(_Column(*disc, arrives_s - ARRIVES_S, arrives_s + FALLING_SIGN_LATE_S), cells)

    def _coming(
        self, span_s: float, places: np.ndarray, heights: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return where something comes down (j, 3), m in the odometry's frame, and how fast (j,), m/s.

        places (k, 3): the newest cloud's lowest points, m. heights (clouds, k): of their cells in all clouds.
        """
        times_s = np.array([seen.stamp_s for seen in self._seen])
        first = int(np.argmax(times_s[-1] - times_s <= span_s + 1e-6))
        times_s, heights = times_s[first:], heights[first:]
        lasted_s = times_s[-1] - times_s[0]
        if len(times_s) < FALLING_FEWEST or lasted_s < 0.8 * span_s:
            return NOTHING
        slopes, residual_m = np.empty((2, len(places)))
        fall_rates(times_s, heights, slopes, residual_m)  # NaN where it was not seen: it does not fall
        x, y, _ = self._seen[-1].position_m
        between_m = FALLING_SPREAD * np.hypot(places[:, 0] - x, places[:, 1] - y)  # of two channels
        falls = -slopes * lasted_s > np.maximum(FALLING_DROP_M, 2.0 * between_m)
        own_m_s = max(0.0, self._seen[first].position_m[2] - self._seen[-1].position_m[2]) / lasted_s
        falls &= (-slopes > own_m_s + SINKING_LEAST_M_S) & (residual_m < FALLING_RESIDUAL_M + 0.4 * between_m)
        if span_s == FALLING_SPANS_S[0]:
            falls &= residual_m < FALLING_UNEVEN * -slopes * lasted_s
        if falls.any():
            sunk_m = heights[0, falls] - heights[-1, falls]
            falls[falls] = _was_free(places[falls], sunk_m, self._seen[first])
        return places[falls], -slopes[falls]

    def _close(self, places: np.ndarray, speeds: np.ndarray, motion: Motion) -> None:
        """Close the columns of what comes down; neighbours are one thing."""
        while len(places):
            is_one = np.hypot(*(places[:, :2] - places[0, :2]).T) < FALLING_APART_M
            one, speed = self._with_new(places[is_one]), float(speeds[is_one].max())
            one = self._with_unseen(one)
            x_m, y_m = one[:, :2].mean(axis=0).tolist()
            radius_m = float(np.hypot(*(one[:, :2] - (x_m, y_m)).T).max()) + FALLING_BEYOND_M
            gap_m = float(one[:, 2].min()) - motion.position_m[2] - self._above_m
            arrives_s = motion.stamp_s + max(0.0, gap_m) / speed
            disc, times = (x_m, y_m, radius_m), (arrives_s - ARRIVES_S, arrives_s + SINKING_FORGET_S)
            same = [c for c in self._columns if math.dist((c.x_m, c.y_m), (x_m, y_m)) <= c.radius_m]
            largest = max([disc, *(c[:3] for c in same)], key=itemgetter(2))  # once seen, it stays as large
            self._columns = [*(c for c in self._columns if c not in same), _Column(*largest, *times)]
            places, speeds = places[~is_one], speeds[~is_one]

    def _with_new(self, one: np.ndarray) -> np.ndarray:
        """Return the places of one thing (n, 3), m, and what is new beside them, as low as they are.

        Of a load that has just come into view, few cells have been seen for long enough to tell that they
        fall.
        """
        lowest_m, before_m = self._seen[-1].lowest_m, self._earliest_in(FALLING_SPANS_S[0]).lowest_m[:, 2]
        middle = one.mean(axis=0)
        beside = np.abs(lowest_m[:, 2] - one[:, 2].min()) < FALLING_LEVEL_M
        beside &= before_m > lowest_m[:, 2] + 0.5 * FALLING_DROP_M
        new_m = lowest_m[beside]
        near = np.hypot(new_m[:, 0] - middle[0], new_m[:, 1] - middle[1]) < FALLING_APART_M
        return np.concatenate((one, new_m[near]))

    def _with_unseen(self, one: np.ndarray) -> np.ndarray:
        """Return the places of one thing (n, 3), m, and how far it may go on where the UAV sees nothing.

        That is over the highest channel: of a large load that comes steeply, only the far side is seen.
        """
        newest = self._seen[-1]
        away_m = one - newest.position_m
        nearest = int(np.hypot(away_m[:, 0], away_m[:, 1]).argmin())
        h_m = math.hypot(*away_m[nearest, :2])
        towards = np.array((*(-away_m[nearest, :2] / max(h_m, 1e-6)), 0.0))
        nearer_m = away_m[nearest] + min(FALLING_CELL_M, h_m) * towards
        if newest.is_free(nearer_m):
            return one
        seen_m = np.ptp((away_m - away_m[nearest]) @ towards)
        return np.append(one, (one[nearest] + max(0.0, FALLING_LARGEST_M - seen_m) * towards)[None], axis=0)


def _was_seen_free(place: np.ndarray, earlier: list[_Seen]) -> bool:
    """Return whether one of these clouds has seen a place (3,), m in the odometry's frame, free."""
    return any(seen.is_free(place - seen.position_m) for seen in earlier)


def _was_free(places: np.ndarray, sunk_m: np.ndarray, seen: _Seen) -> np.ndarray:
    """Return which places (k, 3), m in the odometry's frame, a cloud has seen free (k,).

    sunk_m (k,): from how far above something would have come since then. All that way must have been free,
    and what is FALLING_BESIDE_M beside and below it. A side, a sill or a lintel that the UAV sinks past is
    free at its very edge only.
    """
    x, y, z = (places - seen.position_m).T
    h_m, (rows, bins) = np.maximum(np.hypot(x, y), 1e-6), seen.free_m.shape
    row_m, middle = h_m * seen.row_tan, 0.5 * rows
    row = np.floor(z / row_m + middle).astype(np.int64)
    column = np.floor((np.arctan2(y, x) + math.pi) * bins / (2.0 * math.pi)).astype(np.int64)
    free = (row >= 0) & (row < rows)
    free &= seen.free_m[np.clip(row, 0, rows - 1), column % bins] > h_m + FALLING_CELL_M
    lowest = np.floor((z - FALLING_BESIDE_M) / row_m + middle).astype(np.int64).clip(0, rows - 1)
    highest = np.maximum(np.floor((z + sunk_m) / row_m + middle).astype(np.int64) - 1, row)
    beside = np.ceil(np.arctan2(FALLING_BESIDE_M, h_m) * bins / (2.0 * math.pi)).astype(np.int64)
    for k in np.flatnonzero(free):
        around = np.arange(column[k] - beside[k], column[k] + beside[k] + 1) % bins
        way_m = seen.free_m[lowest[k] : highest[k] + 1, around]
        free[k] = way_m.min() > h_m[k] + FALLING_CELL_M
    return free
