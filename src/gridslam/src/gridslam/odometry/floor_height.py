"""The height of the base frame over the floor where it started, by range finder and IMU, and by clouds.

Kalman filters of height, climb speed, the accelerometer's bias and the floor below, side by side: a box or a
stiffener under the range finder is a step of the floor and no climb. See `floor_hypotheses`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from gridslam.odometry.floor_hypotheses import (
    BIAS,
    CLIMB,
    CLIMB_FIRST,
    FLOOR,
    HEIGHT,
    MAP,
    NEW,
    SAME_LEVEL_M,
    SHOCK_BELOW_M,
    SLOPING,
    Hypothesis,
    Level,
    likeliest,
)
from gridslam.odometry.parameters import LidarOdometryParameters

CONFIRMED = 3
"""So many readings in a row make a floor that is recognised later."""
LEVELS_MAX = 20
BIAS_WALK, BIAS_FIRST = 0.02, 0.2
"""Of the accelerometer's bias: its walk, m/s2 in the root of a second, and its first uncertainty, m/s2."""
MAP_FIRST_M, MAP_DRIFT_M = 0.03, 0.02
"""The map of the clouds is off by the first at the start, m. The height that it tells walks by the second in
the root of a metre of way, so clouds tell a climb in one place, and hardly one over a long way. In a level
corridor of 100 m it was off by 0.3 to 0.7 m at the end."""
EDGE_S = 1.0
"""So long after a reading of the range finder that was off by a step, clouds decide what it was."""
CLOUD_SIGMA_M, EDGE_SIGMA_M = 0.2, 0.03
"""Standard deviation of the height that one cloud tells, beside that of its points; the second at an edge.
Few rings on new planes hold a climb back, so else the range finder counts more."""
JUMP_M, JUMP_S = 0.07, 3.0
"""So long after such a jump of the height that clouds tell it is their map that is off."""
EDGE_JUMP_M, EDGE_READING_SIGMA_M = 0.05, 0.3
"""A reading that differs from the one before it by more than the first, beside the climb, may be an edge that
enters the range finder's cone. Its standard deviation is the second; the readings that follow tell more."""
OFF_SLOPE_M, ALONG_SLOPE_M_S = 0.5, 4.0
"""A reading that differs from the one before it by more, beside the climb, is no longer of the same slope: so
much, and so much a second, as above a floor of 45 degrees at this speed."""
RISEN_OFF_M = 0.8
"""Over a slope the floor rises as the map's slope tells, along the way flown. A floor that is off by more is
none of this slope, or the height is wrong. Rock on the floor of a mine is off by 0.6 m."""
SAME_LEVEL_SIGMAS = 2.0
"""A floor behind a slope that differs from one seen before by fewer standard deviations is that one. So a
slope that the clouds tell by mistake adds nothing."""
SILENT_S = 1.0
"""If the last reading that counted is older, the height is not known any more; the next one begins anew."""
HELD_S = 0.05
"""An acceleration counts for this time at most. If no other one follows, the climb speed stays, and its
uncertainty grows by ``acceleration_unknown``."""


class FloorHeight:
    """Height and climb speed over the floor of the start.

    is_sloping: whether the floor below slopes, so that clouds alone tell the height.
    """

    def __init__(self, parameters: LidarOdometryParameters) -> None:
        self._p = parameters
        first = np.diag((1.0, CLIMB_FIRST**2, BIAS_FIRST**2, 0.0, MAP_FIRST_M**2))
        self._alive = [Hypothesis(np.zeros(5), first)]
        self._levels = [Level(0.0, 0.0)]
        self._stamp_s: float | None = None
        self._acceleration = 0.0
        self._held_until_s = -math.inf
        self._range_m = self._range_s = math.nan  # the newest reading
        self._counted_s: float | None = None
        self._told_m, self._told_s = math.nan, -math.inf  # the newest height by clouds
        self._edge_s = -math.inf  # time of the newest reading that was off by a step
        self._jump_s = -math.inf  # time of the newest jump of the height by clouds
        self.is_sloping = False  # the floor below
        self._slope_begins_m = 0.0  # the floor where the slope began
        self._risen_m = 0.0  # since then, by the slope
        self._levels_trusted = 1  # of the levels, those that were seen before a height that may be wrong
        self._wrong_m = 0.0

    @property
    def wrong_m(self) -> float:
        """By how much the height may be wrong, m: the floor rose by so much more than its slope tells.

        0: floor and slope agree, within `RISEN_OFF_M`. It stays until a floor comes that was seen before.
        """
        return self._wrong_m

    @property
    def floor_m(self) -> float:
        """Height of the floor below now over that of the start, m."""
        return float(self._alive[0].state[FLOOR])

    @property
    def floor_variance_m2(self) -> float:
        """Variance of the height of the floor below, m2."""
        return float(self._alive[0].covariance[FLOOR, FLOOR])

    @property
    def map_m(self) -> float:
        """By how much the clouds' map tells too great a height, m."""
        return float(self._alive[0].state[MAP])

    def is_known_at(self, stamp_s: float) -> bool:
        """Whether a reading has counted lately."""
        return self._counted_s is not None and stamp_s - self._counted_s < SILENT_S

    @property
    def climb_variance(self) -> float:
        """Variance of the climb speed, m2/s2."""
        return float(self._alive[0].covariance[CLIMB, CLIMB])

    def on_acceleration(self, stamp_s: float, acceleration_m_s2: float) -> None:
        """Take the vertical acceleration, upwards and without gravity, of the time up to an instant.

        It counts on until the next one comes, too.
        """
        if stamp_s <= self._held_until_s:
            self._acceleration = acceleration_m_s2
        self._advance(stamp_s)
        self._acceleration, self._held_until_s = acceleration_m_s2, stamp_s + HELD_S

    def at(self, stamp_s: float) -> tuple[float, float, float]:
        """Return height in m, climb speed in m/s, and the height's variance, by the likeliest hypothesis."""
        now_s = stamp_s if self._stamp_s is None else self._stamp_s
        past_s = stamp_s - now_s
        held_s = max(min(stamp_s, self._held_until_s) - now_s, 0.0)
        best = self._alive[0]
        z, climb, bias, *_ = best.state.tolist()
        gain = held_s * (self._acceleration - bias)
        z_at = z + past_s * climb + (past_s - 0.5 * held_s) * gain
        return z_at, climb + gain, self._variance(best.covariance, past_s, held_s)

    def _variance(self, covariance: np.ndarray, past_s: float, held_s: float) -> float:
        """Return the height's variance after ``past_s``, during ``held_s`` of which an acceleration holds."""
        model = np.array((1.0, past_s, -(past_s - 0.5 * held_s) * held_s, 0.0, 0.0))
        silent_s = max(past_s - held_s, 0.0)
        measured, unknown = self._p.climb_noise**2, self._p.acceleration_unknown**2
        noise = measured * (max(past_s, 0.0) ** 3 - silent_s**3) + unknown * silent_s**3
        return float(model @ covariance @ model) + noise / 3.0

    def on_range(self, stamp_s: float, height_m: float, sigma_m: float = 0.0) -> None:
        """Take the height over whatever is below, as measured at an instant.

        sigma_m: standard deviation beside ``range_noise_m``.
        """
        self._advance(stamp_s)
        variance_m2 = self._p.range_noise_m**2 + sigma_m**2
        jump_m, past_s = height_m - self._range_m, stamp_s - self._range_s
        slid_m = abs(jump_m - past_s * self._alive[0].state[CLIMB])
        if self.is_sloping and slid_m > OFF_SLOPE_M + past_s * ALONG_SLOPE_M_S:
            self.on_slope(stamp_s, False)  # the edge of a deck: the floors that were seen tell the height
        if self.is_sloping:
            self._alive = [self._alive[0].over_slope(height_m, variance_m2)]
            self._range_m, self._range_s, self._counted_s = height_m, stamp_s, stamp_s
            off_m = self.floor_m - self._slope_begins_m - self._risen_m
            if abs(off_m) > max(RISEN_OFF_M, self._wrong_m):
                self._wrong_m = abs(off_m)
            return
        self._range_m, self._range_s = height_m, stamp_s
        last_s = max(self._told_s, -math.inf if self._counted_s is None else self._counted_s)
        if stamp_s - last_s > SILENT_S:
            self._begin(stamp_s, height_m, variance_m2)
            return
        if height_m > SHOCK_BELOW_M and abs(jump_m - past_s * self._alive[0].state[CLIMB]) > EDGE_JUMP_M:
            variance_m2 += EDGE_READING_SIGMA_M**2
        delay_s = (self._stamp_s or stamp_s) - stamp_s
        best = self._alive[0].state
        if abs(height_m - (best[HEIGHT] - delay_s * best[CLIMB] - best[FLOOR])) > self._p.floor_step_m:
            self._edge_s = stamp_s
        self._alive = likeliest(
            [
                meaning
                for each in self._alive
                for meaning in each.explanations(
                    height_m, jump_m, delay_s, variance_m2, self._levels, self._p.floor_step_m
                )
            ]
        )
        if self._alive[0].has_counted:
            self._counted_s = stamp_s
        if self._wrong_m and 0 <= self._alive[0].level < self._levels_trusted:
            self._wrong_m = 0.0
        self._confirm_level()

    def on_height(self, stamp_s: float, height_m: float, variance_m2: float) -> None:
        """Take the height over the floor of the start, as the clouds' map tells it at an instant.

        While the range finder is silent this counts alone. So a floor that comes into its sight then is new
        unless it fits one of before.
        """
        self._advance(stamp_s)
        if not self.is_known_at(stamp_s):
            best = replace(self._alive[0], log_chance=0.0)
            self._alive = [_at_rest(best, height_m - self.map_m, variance_m2)]
            self._told_m, self._told_s = height_m, stamp_s
            return
        model = np.array((1.0, stamp_s - (self._stamp_s or stamp_s), 0.0, 0.0, 1.0))
        if self.is_sloping:
            self._alive = [replace(self._alive[0].measured(model, height_m, variance_m2), log_chance=0.0)]
            return
        is_at_edge = stamp_s - self._edge_s < EDGE_S
        variance_m2 += (EDGE_SIGMA_M if is_at_edge else CLOUD_SIGMA_M) ** 2
        jump_m = height_m - self._told_m - (stamp_s - self._told_s) * float(self._alive[0].state[CLIMB])
        self._told_m, self._told_s = height_m, stamp_s
        if abs(jump_m) > JUMP_M:
            self._jump_s = stamp_s
            self._alive = [each.with_other_map(jump_m) for each in self._alive]
        may_shift = stamp_s - self._jump_s > JUMP_S
        self._alive = likeliest(
            [
                meaning
                for each in self._alive
                for meaning in each.after_height(
                    model, height_m, variance_m2, self._levels, self._p.floor_step_m, may_shift
                )
            ]
        )

    def on_way(self, way_m: float) -> None:
        """Take the way that the clouds have told since the last time, m. Along it their map drifts."""
        added = np.diag((0.0, 0.0, 0.0, 0.0, MAP_DRIFT_M**2 * way_m))
        self._alive = [replace(each, covariance=each.covariance + added) for each in self._alive]

    def on_slope(self, stamp_s: float, is_sloping: bool, rise_m: float = 0.0, missed_m: float = 0.0) -> None:
        """Take whether the floor below slopes from an instant on.

        rise_m: by its slope, the floor below has risen by so much since the last time. missed_m: standard
        deviation of what it has risen before a slope was told.

        Over a slope the range finder does not tell a climb from a floor that rises. So clouds alone tell the
        height, and what the map of the clouds is off by stays. Where the slope ends the floor is as high as
        clouds and range finder together tell.
        """
        self._risen_m += rise_m
        if is_sloping == self.is_sloping:
            return
        self._advance(stamp_s)
        self.is_sloping = is_sloping
        best = self._alive[0]
        if is_sloping:
            self._slope_begins_m, self._risen_m = float(best.state[FLOOR]), 0.0
            if not self._wrong_m:
                self._levels_trusted = len(self._levels)
        self._told_m, self._jump_s = math.nan, -math.inf
        best = replace(best, log_chance=0.0)
        self._alive = [best.shifted(0.0, SLOPING, missed_m**2, 1.0) if is_sloping else self._on_level(best)]

    def _on_level(self, best: Hypothesis) -> Hypothesis:
        """Return it over a level floor: one that was seen before, unless it is surely another one."""
        best = replace(best, level=NEW, readings=0)
        off, index = min((self._off_in_sigmas(best, seen), i) for i, seen in enumerate(self._levels))
        if off > SAME_LEVEL_SIGMAS:
            return best
        seen = self._levels[index]
        return best.over(index, seen.height_m, seen.variance_m2, 1.0)

    def _off_in_sigmas(self, best: Hypothesis, seen: Level) -> float:
        """Return how far the floor below is from one that was seen, in standard deviations."""
        variance_m2 = float(best.covariance[FLOOR, FLOOR]) + seen.variance_m2 + SAME_LEVEL_M**2
        return abs(seen.height_m - float(best.state[FLOOR])) / math.sqrt(variance_m2)

    def _begin(self, stamp_s: float, height_m: float, variance_m2: float) -> None:
        """Begin at a reading over the floor of before, as if at rest."""
        best = replace(self._alive[0], log_chance=0.0, has_counted=True)
        self._alive = [_at_rest(best, height_m + best.state[FLOOR], variance_m2)]
        self._counted_s = stamp_s

    def _confirm_level(self) -> None:
        """Note the floor of the likeliest hypothesis, if it is a new one that several readings agree on."""
        best = self._alive[0]
        if best.level != NEW or best.readings < CONFIRMED:
            return
        seen_m = float(best.state[FLOOR])
        if len(self._levels) == LEVELS_MAX:
            del self._levels[1]  # the oldest but that of the start
            self._levels_trusted = max(self._levels_trusted - 1, 1)
            self._alive = [
                replace(each, level=NEW if each.level == 1 else each.level - (each.level > 1))
                for each in self._alive
            ]
        self._levels.append(Level(seen_m, float(best.covariance[FLOOR, FLOOR])))
        number = len(self._levels) - 1
        self._alive = [
            replace(each, level=number)
            if each.level == NEW and abs(each.state[FLOOR] - seen_m) < SAME_LEVEL_M
            else each
            for each in self._alive
        ]

    def _advance(self, stamp_s: float) -> None:
        now_s = stamp_s if self._stamp_s is None else self._stamp_s
        held_s = min(stamp_s, self._held_until_s)
        self._step(held_s - now_s, 1.0, self._acceleration, self._p.climb_noise)
        self._step(stamp_s - max(now_s, held_s), 0.0, 0.0, self._p.acceleration_unknown)
        self._stamp_s = max(now_s, stamp_s)

    def _step(self, dt: float, is_measured: float, acceleration: float, noise: float) -> None:
        """Predict for dt seconds. is_measured: 1; 0: accelerometer and bias have no part in it."""
        if dt <= 0.0:
            return
        pull, q = dt * is_measured, noise**2
        model, added = np.eye(5), np.zeros((5, 5))
        model[HEIGHT, CLIMB], model[HEIGHT, BIAS], model[CLIMB, BIAS] = dt, -0.5 * dt * pull, -pull
        added[:2, :2] = ((q * dt**3 / 3.0, q * dt**2 / 2.0), (q * dt**2 / 2.0, q * dt))
        added[BIAS, BIAS] = BIAS_WALK**2 * dt
        push = np.array((0.5 * dt * dt * acceleration, dt * acceleration, 0.0, 0.0, 0.0))
        self._alive = [
            replace(
                each, state=model @ each.state + push, covariance=model @ each.covariance @ model.T + added
            )
            for each in self._alive
        ]


def _at_rest(hypothesis: Hypothesis, height_m: float, variance_m2: float) -> Hypothesis:
    """Return a hypothesis at this height, with a climb speed of 0."""
    state, covariance = hypothesis.state.copy(), hypothesis.covariance.copy()
    state[[HEIGHT, CLIMB]] = height_m, 0.0
    covariance[:2, :] = covariance[:, :2] = 0.0
    covariance[HEIGHT, HEIGHT], covariance[CLIMB, CLIMB] = variance_m2, CLIMB_FIRST**2
    return replace(hypothesis, state=state, covariance=covariance)
