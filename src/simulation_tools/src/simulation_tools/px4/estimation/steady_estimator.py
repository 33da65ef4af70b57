"""An estimate without a filter: the truth in NED and FRD, with errors like those of PX4's EKF2.

As in EKF2, the local frame begins at the vehicle's place at power-on. Position and velocity carry the error
of a steady Kalman filter that follows inertial data and is corrected by noisy positions. That error drifts
over seconds, and the velocity's error is the rate of the position's error. The attitude's error drifts, too.
Rates and accelerations carry white noise. There are no delays, because EKF2 compensates for them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from flight_basics.checks import check_limits, limited
from kernel_cache.compiler import njit
from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import Quaternion, Vector3
from simulation_tools.px4.estimation.interface import AIDED, ESTIMATE_DTYPE, EstimatorStatus, SolutionFlag
from simulation_tools.px4.estimation.samples import ExternalVision, RangeSample
from simulation_tools.px4.parameters import Px4Parameters

_ERROR_DTYPE = np.dtype(
    [("position", np.float64, (3,)), ("velocity", np.float64, (3,)), ("tilt", np.float64, (3,))]
)

SAMPLE_PERIOD_S = 0.05
"""Of the positions that correct the filter."""

GAINS = (0.507, 0.465, 0.167, 0.441)
"""1/s, 1, 1/s2, 1/s: how position and velocity follow the errors in measured position and velocity.

The steady solution of the Riccati equation for EKF2's default noise: 0.35 m/s2 of acceleration in 10 ms, 0.5
m and 0.3 m/s of GPS. Heights have the same gains, because the reference's heights drift as fast.
"""

_DRAWN = 64
"""For so many steps the noise is drawn at once; the numbers are the same."""

# Standard deviation of the estimate's error over that of the measured positions, by the Lyapunov equation.
_POSITION_SHARE = 0.1226
_VELOCITY_SHARE = 0.0272  # 1/s


@dataclass(frozen=True)
class EstimatorNoise:
    """Standard deviations of the filter's input, and of the other errors.

    position_*_m: white noise of each measured position. `estimated_*`: of the filter's output.
    """

    position_xy_m: float = limited(0.106, 0.0)
    position_z_m: float = limited(0.026, 0.0)
    attitude_rad: float = limited(0.0006, 0.0)
    attitude_time_s: float = limited(2.0, above=0.0)
    rate_rad_s: float = limited(0.001, 0.0)
    acceleration_m_s2: float = limited(0.05, 0.0)

    def __post_init__(self) -> None:
        check_limits(self, ValueError, "The estimator's {}")

    @property
    def estimated_position_m(self) -> Vector3:
        """Standard deviations of the estimate's position."""
        xy, z = _POSITION_SHARE * self.position_xy_m, _POSITION_SHARE * self.position_z_m
        return (xy, xy, z)

    @property
    def estimated_velocity_m_s(self) -> Vector3:
        """Standard deviations of the estimate's velocity."""
        xy, z = _VELOCITY_SHARE * self.position_xy_m, _VELOCITY_SHARE * self.position_z_m
        return (xy, xy, z)

    @classmethod
    def none(cls) -> EstimatorNoise:
        """Return a perfect estimator."""
        return cls(0.0, 0.0, 0.0, 1.0, 0.0, 0.0)


@njit(cache=True)
def _wander(error: float, sigma: float, time_constant: float, dt: float, normal: float) -> float:
    """One exact step of a first-order Gauss-Markov process."""
    keep = math.exp(-dt / time_constant)
    return keep * error + sigma * math.sqrt(1.0 - keep * keep) * normal


@njit(cache=True)
def _rotate(q: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """Take v from the frame whose attitude is q (w, x, y, z) to the frame in which q is given."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    out[0] = v[0] + w * tx + y * tz - z * ty
    out[1] = v[1] + w * ty + z * tx - x * tz
    out[2] = v[2] + w * tz + x * ty - y * tx


@njit(cache=True)
def _filter_error(error: Any, axis: int, sigma: float, dt: float, normal: float) -> None:
    """One step of a filter's error along an axis; sigma: of the measured positions."""
    position, velocity = error.position[axis], error.velocity[axis]
    innovation = sigma * math.sqrt(SAMPLE_PERIOD_S / dt) * normal - position
    error.position[axis] += dt * (velocity + GAINS[0] * innovation - GAINS[1] * velocity)
    error.velocity[axis] += dt * (GAINS[2] * innovation - GAINS[3] * velocity)


@njit(cache=True)
def _estimate(
    origin: Vector3,
    position: Vector3,
    attitude: Quaternion,
    velocity: Vector3,
    rates: Vector3,
    force: Vector3,
    sigmas: np.ndarray,
    errors: np.ndarray,
    drawn: np.ndarray,
    row: int,
    dt: float,
    gravity: float,
    out: np.ndarray,
) -> None:
    """Fill the estimate from the truth.

    The truth: origin of the frame and position ENU, attitude x y z w of FLU in ENU, velocity ENU, rates FLU,
    specific force FLU. drawn[row] (12,): standard normal numbers. sigmas (6,): the fields of EstimatorNoise
    in their order.
    """
    normals = drawn[row]
    e = errors[0]
    o = out[0]
    for i in range(3):
        _filter_error(e, i, sigmas[0] if i < 2 else sigmas[1], dt, normals[i])
        e.tilt[i] = _wander(e.tilt[i], sigmas[2], sigmas[3], dt, normals[3 + i])

    # ENU to NED and FLU to FRD: see ned_frames.py.
    o.position[0] = position[1] - origin[1] + e.position[0]
    o.position[1] = position[0] - origin[0] + e.position[1]
    o.position[2] = -(position[2] - origin[2]) + e.position[2]
    o.velocity[0] = velocity[1] + e.velocity[0]
    o.velocity[1] = velocity[0] + e.velocity[1]
    o.velocity[2] = -velocity[2] + e.velocity[2]
    sign = (1.0, -1.0, -1.0)
    for i in range(3):
        o.rates[i] = sign[i] * rates[i] + sigmas[4] * normals[6 + i]
        o.specific_force[i] = sign[i] * force[i] + sigmas[5] * normals[9 + i]

    half = math.sqrt(0.5)
    w = half * (attitude[3] + attitude[2])
    x = half * (attitude[0] + attitude[1])
    y = half * (attitude[0] - attitude[1])
    z = half * (attitude[3] - attitude[2])
    # A small rotation of the body by the tilt error, to first order.
    ex, ey, ez = 0.5 * e.tilt[0], 0.5 * e.tilt[1], 0.5 * e.tilt[2]
    q = o.attitude
    q[0] = w - x * ex - y * ey - z * ez
    q[1] = x + w * ex + y * ez - z * ey
    q[2] = y + w * ey + z * ex - x * ez
    q[3] = z + w * ez + x * ey - y * ex
    norm = math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    for i in range(4):
        q[i] /= norm
    o.yaw = math.atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] ** 2 + q[3] ** 2))
    _rotate(q, o.specific_force, o.acceleration)
    o.acceleration[2] += gravity


class SteadyEstimator:
    """Truth in, PX4-like estimate out; an `Estimator` that needs no aiding and never loses its position.

    origin_m: where the local frame begins in the world (ENU): where the vehicle is at the first update.
    """

    GRAVITY_M_S2 = 9.80665
    uses_gnss = True

    def __init__(self, noise: EstimatorNoise, rng: np.random.Generator, parameters: Px4Parameters) -> None:
        """rng: every `reset` goes back to its state at this call, so that flights repeat exactly."""
        self._noise = noise
        self._rng = rng
        self._parameters = parameters
        self._first_rng_state = rng.bit_generator.state
        self._sigmas = np.array([getattr(noise, name) for name in EstimatorNoise.__dataclass_fields__])
        self._errors = np.zeros(1, _ERROR_DTYPE)
        self.estimate = np.zeros(1, ESTIMATE_DTYPE)
        self.reset()

    def reset(self) -> None:
        """Start again with the first random numbers, and with a local frame of its own."""
        self._rng.bit_generator.state = self._first_rng_state
        self._drawn, self._row = np.zeros((0, 12)), 0
        self.origin_m: Vector3 | None = None
        self._started_us = self._time_us = 0
        self.estimate[:] = np.zeros(1, ESTIMATE_DTYPE)
        self.estimate["attitude"][0, 0] = 1.0
        self._errors[:] = np.zeros(1, _ERROR_DTYPE)

    def update(self, state: VehicleState, dt_s: float, in_air: bool = False) -> None:
        """Take in the true state, dt_s after the one before. in_air changes nothing."""
        if self.origin_m is None or state.time_us < self._time_us:
            self._started_us = state.time_us
        self._time_us = state.time_us
        if self.origin_m is None:
            self.origin_m = state.pose.position_m
        if self._row == len(self._drawn):
            self._drawn, self._row = self._rng.standard_normal((_DRAWN, 12)), 0
        _, pose, velocity, rates, force, _ = state
        _estimate(
            self.origin_m,
            pose.position_m,
            pose.orientation_xyzw,
            velocity,
            rates,
            force,
            self._sigmas,
            self._errors,
            self._drawn,
            self._row,
            dt_s,
            self.GRAVITY_M_S2,
            self.estimate,
        )
        self._row += 1

    @property
    def horizontal_valid(self) -> bool:
        """Whether EKF2_REQ_GPS_H has passed since power-on."""
        if self.origin_m is None:
            return False
        return self._time_us - self._started_us >= 1e6 * self._parameters["EKF2_REQ_GPS_H"]

    @property
    def vertical_valid(self) -> bool:
        """The same as `horizontal_valid`."""
        return self.horizontal_valid

    @property
    def status(self) -> EstimatorStatus:
        """The errors' closed form; what PX4 says in flight with GPS."""
        noise, ratio = self._noise, 0.01
        return EstimatorStatus(
            flags=int(AIDED if self.horizontal_valid else SolutionFlag.ATTITUDE),
            velocity_ratio=ratio,
            horizontal_position_ratio=ratio,
            vertical_position_ratio=ratio,
            magnetometer_ratio=ratio,
            height_over_ground_ratio=0.0,
            airspeed_ratio=0.0,
            horizontal_accuracy_m=0.3,
            vertical_accuracy_m=0.3,
            position_variance_m2=_squares(noise.estimated_position_m),
            velocity_variance_m2_s2=_squares(noise.estimated_velocity_m_s),
        )

    def offer_external_vision(self, sample: ExternalVision) -> None:
        """Ignore it: the truth is known."""

    def offer_range(self, sample: RangeSample) -> None:
        """Ignore it: the truth is known."""


def _squares(deviations: Vector3) -> Vector3:
    x, y, z = deviations
    return (x**2, y**2, z**2)
