"""The height of the base frame over the floor where it started, by range finder and IMU.

A Kalman filter of height, climb speed and the accelerometer's bias. A box under the range finder is a step
of the floor and no climb: if the height below jumps from one reading to the next, and several readings agree
on it, the floor has moved, not the UAV. If the prediction is off and the height below has not jumped, the
prediction is wrong, for example after a touchdown's shock. Then the next readings count alone.
"""

from __future__ import annotations

import math

import numpy as np

from gridslam.odometry.parameters import LidarOdometryParameters

CONFIRMED = 3
"""So many readings in a row make a step of the floor."""
SAME_LEVEL_M = 0.1
"""A floor nearer than this to one that was seen before is that one."""
SIGMAS = 4.0
BIAS_WALK = 0.02
BIAS_FIRST, CLIMB_FIRST = 0.2, 0.5
JUMP_SHARE = 0.5
"""A step of the floor shows within one reading, by at least this share of it. A bad prediction does not."""
SILENT_S = 1.0
"""If the last reading that counted is older, the height is not known any more; the next one begins anew."""
HELD_S = 0.05
"""An acceleration counts for this time at most. If no other one follows, the climb speed stays, and its
uncertainty grows by ``acceleration_unknown``."""


class FloorHeight:
    """Height and climb speed. ``floor_m``: of the floor below now, over that of the start."""

    def __init__(self, parameters: LidarOdometryParameters) -> None:
        self._p = parameters
        self._state = np.zeros(3)  # height in m, climb in m/s, bias in m/s2
        self._covariance = np.diag((1.0, CLIMB_FIRST**2, BIAS_FIRST**2))
        self._stamp_s: float | None = None
        self._acceleration = 0.0
        self._held_until_s = -math.inf
        self._levels_m = [0.0]
        self._doubtful_m: list[float] = []
        self._counted_s: float | None = None
        self._last: tuple[float, float] | None = None  # stamp in s and height in m of the last reading
        self.floor_m = 0.0

    def is_known_at(self, stamp_s: float) -> bool:
        """Whether a reading of the range finder has counted lately."""
        return self._counted_s is not None and stamp_s - self._counted_s < SILENT_S

    @property
    def climb_variance(self) -> float:
        """Variance of the climb speed, m2/s2."""
        return float(self._covariance[1, 1])

    def on_acceleration(self, stamp_s: float, acceleration_m_s2: float) -> None:
        """Take the vertical acceleration, upwards and without gravity, that holds from this instant on."""
        self._advance(stamp_s)
        self._acceleration, self._held_until_s = acceleration_m_s2, stamp_s + HELD_S

    def at(self, stamp_s: float) -> tuple[float, float, float]:
        """Return height in m, climb speed in m/s, and the height's variance at an instant."""
        now_s = stamp_s if self._stamp_s is None else self._stamp_s
        past_s = stamp_s - now_s
        held_s = max(min(stamp_s, self._held_until_s) - now_s, 0.0)
        z, climb, bias = self._state
        gain = held_s * (self._acceleration - bias)
        z_at = z + past_s * climb + (past_s - 0.5 * held_s) * gain
        return z_at, climb + gain, self._variance(past_s, held_s)

    def _variance(self, past_s: float, held_s: float) -> float:
        """Return the height's variance after ``past_s``, during ``held_s`` of which an acceleration holds."""
        model = np.array((1.0, past_s, -(past_s - 0.5 * held_s) * held_s))
        silent_s = max(past_s - held_s, 0.0)
        measured, unknown = self._p.climb_noise**2, self._p.acceleration_unknown**2
        noise = measured * (max(past_s, 0.0) ** 3 - silent_s**3) + unknown * silent_s**3
        return float(model @ self._covariance @ model) + noise / 3.0

    def on_range(self, stamp_s: float, height_m: float) -> None:
        """Take the height over whatever is below, as measured at an instant."""
        self._advance(stamp_s)
        last, self._last = self._last, (stamp_s, height_m)
        if last is None or stamp_s - (self._counted_s or last[0]) > SILENT_S:
            self._begin(stamp_s, height_m)
            return
        jump_m = height_m - last[1]
        delay_s = (self._stamp_s or stamp_s) - stamp_s
        model = np.array((1.0, -delay_s, 0.0))
        spread = self._covariance @ model
        variance = float(model @ spread) + self._p.range_noise_m**2
        innovation = height_m + self.floor_m - float(model @ self._state)
        is_off = abs(innovation) > max(self._p.floor_step_m, SIGMAS * math.sqrt(variance))
        if is_off and (self._doubtful_m or abs(jump_m) > JUMP_SHARE * abs(innovation)):
            innovation = self._innovation_by_step(height_m - float(model @ self._state))
            if math.isnan(innovation):
                return
        elif is_off:
            self._doubt_prediction(innovation)
            spread = self._covariance @ model
            variance = float(model @ spread) + self._p.range_noise_m**2
        self._doubtful_m.clear()
        self._counted_s = stamp_s
        gain = spread / variance
        self._state += gain * innovation
        self._covariance -= np.outer(gain, spread)

    def _begin(self, stamp_s: float, height_m: float) -> None:
        """Begin at a reading over the floor of before, as if at rest."""
        self._state[:2] = height_m + self.floor_m, 0.0
        self._covariance[:2, :] = self._covariance[:, :2] = 0.0
        self._covariance[0, 0], self._covariance[1, 1] = self._p.range_noise_m**2, CLIMB_FIRST**2
        self._counted_s = stamp_s
        self._doubtful_m.clear()

    def _doubt_prediction(self, error_m: float) -> None:
        """Let height and climb be uncertain, because the height is off by this much."""
        self._covariance[0, 0] += error_m**2
        self._covariance[1, 1] += CLIMB_FIRST**2

    def _innovation_by_step(self, drop_m: float) -> float:
        """Note a floor at -drop_m. Return the innovation over it when it is confirmed, else NaN."""
        if self._doubtful_m and abs(drop_m - self._doubtful_m[-1]) > SAME_LEVEL_M:
            self._doubtful_m.clear()
        self._doubtful_m.append(drop_m)
        if len(self._doubtful_m) < CONFIRMED:
            return math.nan
        seen_m = -sum(self._doubtful_m) / len(self._doubtful_m)
        nearest_m = min(self._levels_m, key=lambda level: abs(level - seen_m))
        if abs(nearest_m - seen_m) < SAME_LEVEL_M:
            self.floor_m = nearest_m
        else:
            self.floor_m = seen_m
            self._levels_m.append(seen_m)
        return drop_m + self.floor_m

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
        pull = dt * is_measured
        model = np.array(((1.0, dt, -0.5 * dt * pull), (0.0, 1.0, -pull), (0.0, 0.0, 1.0)))
        self._state = model @ self._state + (0.5 * dt * dt * acceleration, dt * acceleration, 0.0)
        q = noise**2
        added = np.array(
            ((q * dt**3 / 3.0, q * dt**2 / 2.0, 0.0), (q * dt**2 / 2.0, q * dt, 0.0), (0.0, 0.0, 0.0))
        )
        added[2, 2] = BIAS_WALK**2 * dt
        self._covariance = model @ self._covariance @ model.T + added
