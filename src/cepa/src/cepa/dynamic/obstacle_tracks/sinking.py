"""Finds what comes down on the UAV, or comes up to it, by its range finders."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import (
    ARRIVES_S,
    SINKING_FASTEST_M_S,
    SINKING_FEWEST,
    SINKING_FORGET_S,
    SINKING_GAP_M,
    SINKING_KEPT,
    SINKING_LEAST_M_S,
    SINKING_MISS_S,
    SINKING_NOISE_M,
    SINKING_OPEN_M,
    SINKING_RADIUS_M,
    SINKING_RESIDUAL_M,
    SINKING_SIGN_HEIGHTS,
    SINKING_SIGN_M,
    SINKING_SIGN_PAUSE_S,
    SINKING_SIGNIFICANCE,
    SINKING_SLOPE,
    SINKING_SLOPE_OF_ROOFS,
    SINKING_SOON_S,
    SINKING_SPANS_S,
    SINKING_SURE_S,
    SINKING_TIMES,
    SINKING_TIMES_OF_ROOFS,
    SINKING_UNEVEN,
    UPRIGHT_COSINE,
)
from cepa.motion import Motion, Ranging

NO_COLUMNS = np.empty((0, 8))


class _Height(NamedTuple):
    """Where a beam ended, in the odometry's frame; z_m is inf where it met nothing."""

    stamp_s: float
    x_m: float
    y_m: float
    z_m: float
    start_m: tuple[float, float, float]
    lean: tuple[float, float]
    """How far (x, y) it goes on a metre up."""

    def passed_m(self, z_m: float) -> tuple[float, float]:
        """Return where the beam passed a height (x, y), m: if it leans, not where it ended 40 m up."""
        x, y, z = self.start_m
        return x + (z_m - z) * self.lean[0], y + (z_m - z) * self.lean[1]


class _Column(NamedTuple):
    """A disc that something comes down into, or up."""

    x_m: float
    y_m: float
    arrives_s: float
    """When it is at the body's height."""
    z_m: float = math.nan
    """How high it was when it was found, at ``found_s``."""
    found_s: float = math.nan
    rises_m_s: float = 0.0
    """How fast it rose then; < 0: it came down."""

    def is_closed(self, now_s: float) -> bool:
        """Return whether it counts."""
        return self.arrives_s - ARRIVES_S <= now_s <= self.arrives_s + SINKING_FORGET_S

    def holds(self, place_m: tuple[float, ...], now_s: float) -> bool:
        """Return whether it counts, and a place (x, y), m, is in it."""
        return self.is_closed(now_s) and math.dist(place_m, (self.x_m, self.y_m)) <= SINKING_RADIUS_M


class Sinking:
    """Keeps the heights that range finders have met, and tells which of them come nearer.

    What comes down closes its whole column: the UAV leaves it to the side, never between it and the floor. A
    beam shows one spot of a thing. So the disc is as wide as a load may be, and ends where the beam met
    nothing so near just before. It stays where it was found, for a load hangs still. If it went with the UAV,
    all ways out would be as long as before after each step, and the UAV would waver.
    """

    def __init__(self, body_below_m: float, body_above_m: float) -> None:
        self._ends_m = {1.0: body_above_m, -1.0: body_below_m}
        self.reset()

    def reset(self) -> None:
        """Forget all heights."""
        self._heights: dict[float, deque[_Height]] = {way: deque(maxlen=SINKING_KEPT) for way in (1.0, -1.0)}
        self._columns: dict[float, _Column] = {}
        self._last_m: dict[float, float] = {}
        self._times: dict[float, int] = {}  # that it was found without a break
        self._open_s = -math.inf  # when it was open far up
        self._sign: _Column | None = None
        self._sign_s = -math.inf  # when the last one was given up
        self._sign_seen = 0  # in so many heights

    def take_over(self, earlier: Sinking) -> None:
        """Take over what one with other parameters knows; it must not be used any longer."""
        self._heights, self._columns = earlier._heights, earlier._columns
        self._last_m, self._times = earlier._last_m, earlier._times
        self._open_s = earlier._open_s
        self._sign, self._sign_s, self._sign_seen = earlier._sign, earlier._sign_s, earlier._sign_seen

    def is_in_the_open(self, now_s: float) -> bool:
        """Return whether a beam has just met no ceiling, as under a crane, and unlike in a tank."""
        return now_s - self._open_s <= ARRIVES_S

    def take_in(self, rangings: Sequence[Ranging], motion: Motion, clouds_show: bool = False) -> np.ndarray:
        """Take in ranges in the lidar's frame; return what comes near as discs (k, 8), see `Observation`.

        clouds_show: clouds come, and they show loads from afar, or it is under a ceiling. Then a range finder
        need not find one in a hurry, which it does where plates, stiffeners and slopes are near, too.
        """
        for ranging in rangings:
            self._keep(ranging, motion, clouds_show)
        now_s, (x, y, _) = motion.stamp_s, motion.position_m
        columns = [(*c[:3], way) for way, c in self._columns.items() if c.is_closed(now_s)]
        if self._sign is not None and not columns:
            columns = [(*self._sign[:3], 1.0)]
        if not columns:
            return NO_COLUMNS
        discs = [(cx - x, cy - y, 0, 0, SINKING_RADIUS_M, 0, s - now_s, way) for cx, cy, s, way in columns]
        return np.array(discs, float)

    def _keep(self, ranging: Ranging, motion: Motion, clouds_show: bool) -> None:
        rotation = motion.rotation()
        direction = rotation @ ranging.direction
        way = math.copysign(1.0, float(direction[2]))
        if abs(direction[2]) < UPRIGHT_COSINE or math.isnan(ranging.range_m) or ranging.range_m < 0.0:
            return
        if self._last_m.get(way) == ranging.range_m <= ranging.range_max_m:
            return  # slower than the lidar: it is the same measurement again
        self._last_m[way] = ranging.range_m
        start = np.array(motion.position_m) + rotation @ ranging.origin_m
        end = start + ranging.free_m * direction
        height_m = float(end[2]) if ranging.range_m <= ranging.range_max_m else way * math.inf
        if height_m - motion.position_m[2] >= SINKING_OPEN_M:
            self._open_s = motion.stamp_s
        heights = self._heights[way]
        x, y, up = direction.tolist()
        lean = x / up, y / up
        heights.append(
            _Height(motion.stamp_s, float(end[0]), float(end[1]), height_m, tuple(start.tolist()), lean)
        )
        gap_m = way * (height_m - motion.position_m[2]) - self._ends_m[way]
        is_roofed = clouds_show and not self.is_in_the_open(motion.stamp_s)
        if way > 0.0 and not clouds_show:
            self._take_sign(heights, gap_m)
        rises_m_s = _speed_m_s(heights, gap_m, clouds_show, is_roofed)
        speed = way * rises_m_s
        self._times[way] = self._times.get(way, 0) + 1 if speed < 0.0 else 0
        if speed < 0.0:  # it comes, also if the beam should miss it from now on
            arrives_s = motion.stamp_s + max(0.0, gap_m) / -speed
            is_soon = arrives_s <= motion.stamp_s + SINKING_SURE_S and not is_roofed
            fewest = SINKING_TIMES_OF_ROOFS if is_roofed else SINKING_TIMES
            if self._times[way] < fewest and not is_soon:
                return  # there is time to look again, or a roof is over the UAV and clouds show loads
            known, (x_m, y_m) = self._columns.get(way), _middle_of(heights, way, rises_m_s)
            if known is not None and known.holds(heights[-1][1:3], motion.stamp_s):
                x_m, y_m = known[:2]
            self._columns[way] = _Column(x_m, y_m, arrives_s, height_m, motion.stamp_s, rises_m_s)
        elif way in self._columns and _stands(self._columns[way], heights):
            del self._columns[way]

    def _take_sign(self, heights: deque[_Height], gap_m: float) -> None:
        """Take in that something has just appeared near over the body, where it was open.

        Three heights tell how fast it comes, a tenth of a second later. A load may touch a UAV that flies
        on until then. gap_m: from the body.
        """
        newest = heights[-1]
        was_open = len(heights) > 1 and self._open_s == heights[-2].stamp_s
        if self._sign is not None:
            self._sign_seen += gap_m <= SINKING_SIGN_M
            knows = self._sign_seen >= SINKING_SIGN_HEIGHTS
            if knows or newest.stamp_s > self._sign.arrives_s + SINKING_FORGET_S:
                self._sign, self._sign_s = None, newest.stamp_s
        elif was_open and gap_m <= SINKING_SIGN_M and newest.stamp_s - self._sign_s > SINKING_SIGN_PAUSE_S:
            arrives_s = newest.stamp_s + max(0.0, gap_m) / SINKING_FASTEST_M_S
            self._sign, self._sign_seen = _Column(*_middle_of(heights, 1.0, 0.0), arrives_s), 1


def _speed_m_s(heights: deque[_Height], gap_m: float, clouds_show: bool, is_roofed: bool) -> float:
    """Return how fast the newest heights rise, m/s; 0.0: they stand, or belong to several things.

    gap_m: from the body to the newest. is_roofed: clouds show loads, and the UAV is under a roof, which may
    slope. A ceiling that slopes comes nearer as well while the UAV flies along it. So the speed must be
    greater than a share of the UAV's own, unless the body would meet even the ceiling very soon. A stiffener
    or a step that a slow UAV passes is nearer at once. So the heights must change evenly.
    """
    newest = heights[-1]
    if not math.isfinite(newest.z_m):
        return 0.0
    run = [newest]
    for height in reversed(list(heights)[:-1]):
        is_old = newest.stamp_s - height.stamp_s > SINKING_SPANS_S[-1] + 1e-6
        if is_old or not abs(height.z_m - run[-1].z_m) <= SINKING_GAP_M:  # another thing, or none
            break
        run.append(height)
    found = np.array([height[:4] for height in run])
    spans = list(zip(SINKING_SPANS_S, SINKING_FEWEST))
    floor_m = 0.5 * SINKING_RESIDUAL_M if clouds_show else SINKING_NOISE_M
    for span_s, fewest in spans[clouds_show:]:
        part = found[newest.stamp_s - found[:, 0] <= span_s + 1e-6]
        lasted_s = newest.stamp_s - part[-1, 0]
        if len(part) < fewest or lasted_s < 0.8 * span_s:
            continue
        speed, residual_m, spread = _line(part[:, 0], part[:, 3])
        flown_m_s = math.dist(part[0, 1:3], part[-1, 1:3]) / lasted_s
        noise = max(residual_m, floor_m) / math.sqrt(spread)
        is_soon = not clouds_show and gap_m <= SINKING_SOON_S * abs(speed)
        slope = SINKING_SLOPE_OF_ROOFS if is_roofed else SINKING_SLOPE
        of_slope = 0.0 if is_soon else slope * flown_m_s
        least = max(SINKING_LEAST_M_S + of_slope, SINKING_SIGNIFICANCE * noise)
        most_m = min(SINKING_RESIDUAL_M, SINKING_UNEVEN * abs(speed) * lasted_s)
        if residual_m < most_m and abs(speed) > least:
            return speed
    return 0.0


def _line(stamps_s: np.ndarray, heights_m: np.ndarray) -> tuple[float, float, float]:
    """Return a line's speed through heights (n,), m/s, how far off it they are, m, and the times' spread.

    The spread is the sum of the squares of the times from their mean, s².
    """
    times_s, z_m = stamps_s - stamps_s.mean(), heights_m - heights_m.mean()
    spread = float(times_s @ times_s)
    speed = float(times_s @ z_m) / spread
    return speed, math.sqrt(float(np.mean((z_m - speed * times_s) ** 2))), spread


def _stands(column: _Column, heights: deque[_Height]) -> bool:
    """Return whether the heights since something was found to come show that it stands.

    Noise, or an estimate of the own height that drifts, may look once like a floor that rises slowly. Its
    column would stay closed until the floor should have arrived.
    """
    since = [height for height in heights if height.stamp_s > column.found_s]
    z_m = np.array([column.z_m, *(height.z_m for height in since)])
    if (
        len(since) < SINKING_FEWEST[0]
        or not np.isfinite(z_m).all()
        or np.abs(np.diff(z_m)).max() > SINKING_GAP_M
    ):
        return False  # the beam has met something else, or nothing
    if not all(math.dist(height[1:3], column[:2]) <= SINKING_RADIUS_M for height in since):
        return False
    stamps_s = np.array([height.stamp_s for height in since])
    speed, residual_m, spread = _line(stamps_s, z_m[1:])
    sure_m_s = SINKING_SIGNIFICANCE * max(residual_m, SINKING_NOISE_M) / math.sqrt(spread)
    way = math.copysign(1.0, column.rises_m_s)
    return way * speed + sure_m_s < 0.5 * abs(column.rises_m_s)


def _middle_of(heights: deque[_Height], way: float, rises_m_s: float) -> tuple[float, float]:
    """Return where the disc's middle is (x, y), m: a miss of the beam just before is on its rim.

    rises_m_s: speed of what comes, so that its own earlier heights are no misses.
    """
    newest = heights[-1]
    for height in reversed(heights):
        age_s = newest.stamp_s - height.stamp_s
        if age_s > SINKING_MISS_S:
            break
        then_m = newest.z_m - rises_m_s * age_s
        if way * (height.z_m - then_m) > SINKING_GAP_M:
            x_m, y_m = height.passed_m(then_m)
            apart_m = math.dist(newest[1:3], (x_m, y_m))
            if apart_m < 0.01:
                break
            share = SINKING_RADIUS_M / apart_m
            return x_m + share * (newest.x_m - x_m), y_m + share * (newest.y_m - y_m)
    return newest.x_m, newest.y_m
