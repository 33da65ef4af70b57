"""What PX4 believes about the vehicle: the truth in NED and FRD with errors like those of PX4's EKF2.

The errors of position and velocity wander slowly (first-order Gauss-Markov), as those of a filter that trusts
GPS over seconds; the attitude's wander too; rates and accelerations carry white noise. Delays are left out:
EKF2 makes up for them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from simulation_tools.px4.autopilot import VehicleState

ESTIMATE_DTYPE = np.dtype(
    [
        ("position", np.float64, (3,)),  # m, NED, from where the estimator's origin is
        ("velocity", np.float64, (3,)),  # m/s, NED
        ("acceleration", np.float64, (3,)),  # m/s2, NED, gravity taken out: 0 at rest
        ("attitude", np.float64, (4,)),  # FRD in NED, w x y z
        ("rates", np.float64, (3,)),  # rad/s, FRD
        ("specific_force", np.float64, (3,)),  # m/s2, FRD: (0, 0, -g) at rest
        ("yaw", np.float64),  # rad, from the attitude
    ]
)

_ERROR_DTYPE = np.dtype(
    [("position", np.float64, (3,)), ("velocity", np.float64, (3,)), ("tilt", np.float64, (3,))]
)


@dataclass(frozen=True)
class EstimatorNoise:
    """Standard deviations of the estimate's errors and the time constants with which they wander."""

    position_xy_m: float = 0.008
    position_z_m: float = 0.002
    position_time_s: float = 8.0
    velocity_xy_m_s: float = 0.004
    velocity_z_m_s: float = 0.0015
    velocity_time_s: float = 1.0
    attitude_rad: float = 0.0006
    attitude_time_s: float = 2.0
    rate_rad_s: float = 0.001
    acceleration_m_s2: float = 0.05

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (math.isfinite(value) and value >= 0.0) or (name.endswith("_time_s") and value == 0.0):
                raise ValueError(f"{name} must be finite and not negative (a time: positive), got {value}")

    @classmethod
    def none(cls) -> EstimatorNoise:
        """Return a perfect estimator."""
        times = {"position_time_s": 1.0, "velocity_time_s": 1.0, "attitude_time_s": 1.0}
        return cls(**{name: times.get(name, 0.0) for name in cls.__dataclass_fields__})


@njit(cache=True)
def _wander(error, sigma, time_constant, dt, normal):
    """One exact step of a first-order Gauss-Markov process."""
    keep = math.exp(-dt / time_constant)
    return keep * error + sigma * math.sqrt(1.0 - keep * keep) * normal


@njit(cache=True)
def _rotate(q, v, out):
    """Take v from the frame whose attitude is q (w, x, y, z) to the frame in which q is given."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    out[0] = v[0] + w * tx + y * tz - z * ty
    out[1] = v[1] + w * ty + z * tx - x * tz
    out[2] = v[2] + w * tz + x * ty - y * tx


@njit(cache=True)
def _estimate(truth, sigmas, errors, normals, dt, gravity, out):
    """Fill the estimate from the truth.

    truth (16,): position ENU, attitude x y z w of FLU in ENU, velocity ENU, rates FLU, specific force FLU.
    normals (15,): standard normal numbers. sigmas (10,): the fields of EstimatorNoise in their order.
    """
    e = errors[0]
    o = out[0]
    for i in range(3):
        xy = i < 2
        e.position[i] = _wander(e.position[i], sigmas[0] if xy else sigmas[1], sigmas[2], dt, normals[i])
        e.velocity[i] = _wander(e.velocity[i], sigmas[3] if xy else sigmas[4], sigmas[5], dt, normals[3 + i])
        e.tilt[i] = _wander(e.tilt[i], sigmas[6], sigmas[7], dt, normals[6 + i])

    # ENU to NED and FLU to FRD: see frames.py.
    o.position[0] = truth[1] + e.position[0]
    o.position[1] = truth[0] + e.position[1]
    o.position[2] = -truth[2] + e.position[2]
    o.velocity[0] = truth[8] + e.velocity[0]
    o.velocity[1] = truth[7] + e.velocity[1]
    o.velocity[2] = -truth[9] + e.velocity[2]
    sign = (1.0, -1.0, -1.0)
    for i in range(3):
        o.rates[i] = sign[i] * truth[10 + i] + sigmas[8] * normals[9 + i]
        o.specific_force[i] = sign[i] * truth[13 + i] + sigmas[9] * normals[12 + i]

    half = math.sqrt(0.5)
    w = half * (truth[6] + truth[5])
    x = half * (truth[3] + truth[4])
    y = half * (truth[3] - truth[4])
    z = half * (truth[6] - truth[5])
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


class Estimator:
    """Truth in, PX4-like estimate out: `estimate`, one record of ESTIMATE_DTYPE, shape (1,)."""

    GRAVITY_M_S2 = 9.80665

    def __init__(self, noise: EstimatorNoise, rng: np.random.Generator) -> None:
        """rng: its state at this call is where every `reset` starts again, so that flights repeat exactly."""
        self._rng = rng
        self._first_rng_state = rng.bit_generator.state
        self._sigmas = np.array([getattr(noise, name) for name in EstimatorNoise.__dataclass_fields__])
        self._truth = np.zeros(16)
        self._errors = np.zeros(1, _ERROR_DTYPE)
        self.estimate = np.zeros(1, ESTIMATE_DTYPE)
        self.reset()

    def reset(self) -> None:
        """Start again with the first random numbers."""
        self._rng.bit_generator.state = self._first_rng_state
        self.estimate[:] = np.zeros(1, ESTIMATE_DTYPE)
        self.estimate["attitude"][0, 0] = 1.0
        errors, sigmas = self._errors[0], self._sigmas
        # Steady state from the first step on.
        errors["position"][:] = self._rng.standard_normal(3) * sigmas[[0, 0, 1]]
        errors["velocity"][:] = self._rng.standard_normal(3) * sigmas[[3, 3, 4]]
        errors["tilt"][:] = self._rng.standard_normal(3) * sigmas[6]

    def update(self, state: VehicleState, dt_s: float) -> None:
        """Take in the true state, dt_s after the one before."""
        self._truth[:] = (
            *state.pose.position_m,
            *state.pose.orientation_xyzw,
            *state.velocity_world_m_s,
            *state.angular_velocity_body_rad_s,
            *state.specific_force_body_m_s2,
        )
        normals = self._rng.standard_normal(15)
        _estimate(self._truth, self._sigmas, self._errors, normals, dt_s, self.GRAVITY_M_S2, self.estimate)
