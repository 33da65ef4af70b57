"""The error-state Kalman filter as a whole: state, covariance, stored inertial data, predicted present."""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.px4.estimation.kernels.correction import (
    forget,
    fuse_components,
    fuse_yaw,
    limit_biases,
    reset_yaw,
)
from simulation_tools.px4.estimation.kernels.horizon import advance, follow, jump
from simulation_tools.px4.estimation.kernels.rotations import matrix, yaw_of
from simulation_tools.px4.estimation.kernels.states import (
    ACCELEROMETER_BIAS_ERROR,
    ATTITUDE,
    CLOCK_DTYPE,
    ERROR_SIZE,
    GYROSCOPE_BIAS_ERROR,
    IMU_DTYPE,
    NOMINAL_SIZE,
    POSITION,
    ROTATION_ERROR,
    VELOCITY,
)
from simulation_tools.px4.estimation.settings import FilterSettings

PERIOD_S = 0.008
"""Of the covariance's prediction and of fusion."""

PX4_PERIOD_S = 0.010
"""Of PX4's: 8 and 12 ms in turn on a 250 Hz IMU. EKF2_*_NOISE holds for a sample of this length."""

LEAST_BIAS_VARIANCE = 5e-8 / PX4_PERIOD_S**2
"""(m/s2)2. PX4 lets no variance of a velocity increment's bias fall below 5e-8 (m/s)2. So it stays ready to
learn the vertical bias, and follows measured heights faster than its noise parameters tell.
"""

_FARTHEST_M = 1e6  # a reset goes no farther, as in PX4
_LEAST_STEP_US = 1000  # of the simulation: how many samples the delay may hold
_INITIAL_VELOCITY_M_S, _INITIAL_POSITION_M, _INITIAL_YAW_RAD = 0.5, 0.5, 1.0


class ErrorStateFilter:
    """The filter at its horizon, `state` (16,) and `covariance` (15, 15), and `now` (16,), the present.

    See `kernels` for the order of the states. now_us, horizon_us: their times.
    """

    def __init__(self, settings: FilterSettings) -> None:
        self.state, self.now = np.empty(NOMINAL_SIZE), np.empty(NOMINAL_SIZE)
        self.covariance = np.empty((ERROR_SIZE, ERROR_SIZE))
        self.delay_us = settings.horizon_delay_us
        self._samples = np.zeros(self.delay_us // _LEAST_STEP_US + 3, IMU_DTYPE)
        self._clock = np.zeros(1, CLOCK_DTYPE)
        self._settings = settings
        # The same random walk in shorter samples.
        self._noise = math.sqrt(PX4_PERIOD_S / PERIOD_S) * np.array(
            [
                settings.acceleration_noise_m_s2,
                settings.rate_noise_rad_s,
                settings.acceleration_bias_noise_m_s3,
                settings.rate_bias_noise_rad_s2,
            ]
        )
        self._turned = np.empty((3, 3))
        self._turn = np.empty(4)
        self.now_us = self.horizon_us = 0
        self.resets = 0

    def start(self, force: np.ndarray) -> bool:
        """Begin at rest, levelled by the specific force (3,), FRD; False if it is not the weight at rest."""
        norm = float(np.linalg.norm(force))
        if not 0.8 * 9.80665 <= norm <= 1.2 * 9.80665:
            return False
        roll, pitch = math.atan2(-force[1], -force[2]), math.asin(force[0] / norm)
        cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
        cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
        self.state[:] = 0.0
        self.state[ATTITUDE : ATTITUDE + 4] = (cr * cp, sr * cp, cr * sp, -sr * sp)
        self.now[:] = self.state
        s = self._settings
        deviations = np.empty(ERROR_SIZE)
        deviations[POSITION : POSITION + 3] = _INITIAL_POSITION_M
        deviations[VELOCITY : VELOCITY + 3] = _INITIAL_VELOCITY_M_S
        deviations[ROTATION_ERROR : ROTATION_ERROR + 3] = s.initial_tilt_rad
        deviations[ROTATION_ERROR + 2] = _INITIAL_YAW_RAD
        deviations[ACCELEROMETER_BIAS_ERROR : ACCELEROMETER_BIAS_ERROR + 3] = s.initial_acceleration_bias_m_s2
        deviations[GYROSCOPE_BIAS_ERROR : GYROSCOPE_BIAS_ERROR + 3] = s.initial_rate_bias_rad_s
        self.covariance[:] = np.diag(deviations**2)
        self._samples[:] = np.zeros(1, IMU_DTYPE)
        self._samples["predicted"][:, ATTITUDE : ATTITUDE + 4] = self.state[ATTITUDE : ATTITUDE + 4]
        self._clock[:] = np.zeros(1, CLOCK_DTYPE)
        self.resets = 0
        return True

    def advance(self, time_us: int, dt_s: float, rates: np.ndarray, force: np.ndarray) -> bool:
        """Predict with an IMU sample (FRD) that ended at time_us; return whether it is time to fuse."""
        sample = self._samples[self._clock["head"][0]]
        sample["time_us"], sample["dt"], sample["rates"], sample["force"] = time_us, dt_s, rates, force
        due = advance(
            self._samples,
            self._clock,
            self.state,
            self.covariance,
            self._noise,
            self.now,
            self.delay_us,
            PERIOD_S,
        )
        self.now_us, self.horizon_us = time_us, int(self._clock["horizon_us"][0])
        return due

    def follow(self) -> None:
        """Lead the present to the filter, after all measurements of an instant are in."""
        s = self._settings
        limit_biases(self.state, self.covariance, s.acceleration_bias_limit_m_s2, LEAST_BIAS_VARIANCE)
        follow(
            self._samples,
            self._clock,
            self.state,
            self.now,
            PERIOD_S,
            s.velocity_time_constant_s,
            s.position_time_constant_s,
        )

    # Measurements: each returns its test ratio; above 1 it was rejected.

    def fuse_position(self, first: int, measured: np.ndarray, variances: np.ndarray, gate: float) -> float:
        """Take in position components from `first` on (0 north, 1 east, 2 down), m and m2, (n,)."""
        return fuse_components(self.state, self.covariance, POSITION + first, measured, variances, gate)

    def fuse_velocity(self, first: int, measured: np.ndarray, variances: np.ndarray, gate: float) -> float:
        """Take in velocity components from `first` on, m/s and m2/s2, (n,)."""
        return fuse_components(self.state, self.covariance, VELOCITY + first, measured, variances, gate)

    def fuse_yaw(self, yaw_rad: float, variance: float, gate: float, clipped: bool) -> float:
        """Take in a heading. clipped: an innovation beyond the gate is reduced to it, not rejected."""
        return fuse_yaw(self.state, self.covariance, yaw_rad, variance, gate, clipped)

    # Resets

    def reset_position(self, first: int, values: np.ndarray, variances: np.ndarray) -> None:
        """Put position components (n,) from `first` on to values; the present jumps along."""
        self._reset(POSITION + first, values, variances)
        self.resets += 1

    def reset_velocity(self, first: int, values: np.ndarray, variances: np.ndarray) -> None:
        """Put velocity components (n,) from `first` on to values; the present jumps along."""
        self._reset(VELOCITY + first, values, variances)

    def _reset(self, first: int, values: np.ndarray, variances: np.ndarray) -> None:
        self.state[first : first + len(values)] = np.clip(values, -_FARTHEST_M, _FARTHEST_M)
        forget(self.covariance, first, variances)
        self._jump()

    def reset_yaw(self, yaw_rad: float, variance: float) -> None:
        """Turn to a heading; the present turns along."""
        reset_yaw(self.state, self.covariance, yaw_rad, variance, self._turn)
        self._jump()

    def _jump(self) -> None:
        jump(self._samples, self._clock, self.state, self.now)

    # Views

    def rotation(self) -> np.ndarray:
        """Return the rotation matrix (3, 3) at the horizon, FRD to NED; the same array each time."""
        matrix(self.state[ATTITUDE : ATTITUDE + 4], self._turned)
        return self._turned

    @property
    def yaw_rad(self) -> float:
        """The heading at the horizon."""
        return yaw_of(self.state[ATTITUDE : ATTITUDE + 4])

    @property
    def position(self) -> np.ndarray:
        """Position at the horizon, NED, (3,), a view."""
        return self.state[POSITION : POSITION + 3]

    @property
    def velocity(self) -> np.ndarray:
        """Velocity at the horizon, NED, (3,), a view."""
        return self.state[VELOCITY : VELOCITY + 3]
