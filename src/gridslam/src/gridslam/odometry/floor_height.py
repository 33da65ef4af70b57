"""The height of the base frame over the floor where it started, by range finder and IMU.

A Kalman filter of height, climb speed and the accelerometer's bias. A box under the range finder is a step
of the floor and no climb: if the height below jumps from one reading to the next, and several readings agree
on it, the floor has moved, not the UAV.
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


class FloorHeight:
    """Height and climb speed. ``floor_m``: of the floor below now, over that of the start."""

    def __init__(self, parameters: LidarOdometryParameters) -> None:
        self._p = parameters
        self._state = np.zeros(3)  # height in m, climb in m/s, bias in m/s2
        self._covariance = np.diag((1.0, CLIMB_FIRST**2, BIAS_FIRST**2))
        self._stamp_s: float | None = None
        self._acceleration = 0.0
        self._levels_m = [0.0]
        self._doubtful_m: list[float] = []
        self._counted_s: float | None = None
        self._last: tuple[float, float] | None = None  # stamp in s and height in m of the last reading
        self.floor_m = 0.0

    @property
    def is_known(self) -> bool:
        """Whether a reading of the range finder has counted lately."""
        return (
            self._counted_s is not None
            and self._stamp_s is not None
            and self._stamp_s - self._counted_s < SILENT_S
        )

    @property
    def climb_variance(self) -> float:
        """Variance of the climb speed, m2/s2."""
        return float(self._covariance[1, 1])

    def on_acceleration(self, stamp_s: float, acceleration_m_s2: float) -> None:
        """Take the vertical acceleration, upwards and without gravity, that holds from this instant on."""
        self._advance(stamp_s)
        self._acceleration = acceleration_m_s2

    def at(self, stamp_s: float) -> tuple[float, float, float]:
        """Return height in m, climb speed in m/s, and the height's variance at an instant."""
        past_s = 0.0 if self._stamp_s is None else stamp_s - self._stamp_s
        z, climb, bias = self._state
        variance = float(self._covariance[0, 0] + 2.0 * past_s * self._covariance[0, 1])
        pull = self._acceleration - bias
        return z + past_s * climb + 0.5 * past_s**2 * pull, climb + past_s * pull, variance

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
        if self._stamp_s is None:
            self._stamp_s = stamp_s
        dt = stamp_s - self._stamp_s
        if dt <= 0.0:
            return
        model = np.array(((1.0, dt, -0.5 * dt * dt), (0.0, 1.0, -dt), (0.0, 0.0, 1.0)))
        self._state = model @ self._state + (0.5 * dt * dt * self._acceleration, dt * self._acceleration, 0.0)
        q = self._p.climb_noise**2
        noise = np.array(
            ((q * dt**3 / 3.0, q * dt**2 / 2.0, 0.0), (q * dt**2 / 2.0, q * dt, 0.0), (0.0, 0.0, 0.0))
        )
        noise[2, 2] = BIAS_WALK**2 * dt
        self._covariance = model @ self._covariance @ model.T + noise
        self._stamp_s = stamp_s
