"""Prediction by the inertial sensors (Sola, chapters 5 and 7)."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.px4.estimation.kernels.rotations import exponential, matrix, multiply
from simulation_tools.px4.estimation.kernels.states import (
    ACCELEROMETER_BIAS,
    ACCELEROMETER_BIAS_ERROR,
    ATTITUDE,
    ERROR_SIZE,
    GYROSCOPE_BIAS,
    GYROSCOPE_BIAS_ERROR,
    POSITION,
    ROTATION_ERROR,
    VELOCITY,
)

GRAVITY_M_S2 = 9.80665


@njit(cache=True)
def integrate(x: np.ndarray, rates: np.ndarray, force: np.ndarray, dt: float, turned: np.ndarray) -> None:
    """Predict the nominal state over dt (equations 260a to 260e), from what the IMU measured on average.

    rates (3,): rad/s FRD. force (3,): specific force, m/s2 FRD. turned (3, 3): filled with the new rotation
    matrix. The force acts in the axes at the interval's end; the position follows the mean velocity.
    """
    turn = np.empty(4)
    bias = x[GYROSCOPE_BIAS : GYROSCOPE_BIAS + 3]
    exponential((rates[0] - bias[0]) * dt, (rates[1] - bias[1]) * dt, (rates[2] - bias[2]) * dt, turn)
    attitude = x[ATTITUDE : ATTITUDE + 4]
    multiply(attitude, turn, attitude)
    matrix(attitude, turned)
    for i in range(3):
        gain = GRAVITY_M_S2 if i == 2 else 0.0
        for j in range(3):
            gain += turned[i, j] * (force[j] - x[ACCELEROMETER_BIAS + j])
        before = x[VELOCITY + i]
        x[VELOCITY + i] = before + gain * dt
        x[POSITION + i] += 0.5 * (before + x[VELOCITY + i]) * dt


@njit(cache=True)
def propagate(
    p: np.ndarray, x: np.ndarray, turned: np.ndarray, force: np.ndarray, dt: float, noise: np.ndarray
) -> None:
    """Predict the covariance over dt: P = F P F' + Q (equations 268 and 269 with F of section 7.2.2).

    noise (4,): standard deviations of one sample of length dt: specific force m/s2, rates rad/s, and the
    biases' rates of change, m/s3 and rad/s2. F differs from the identity in four blocks: position by
    velocity, velocity by rotation error and accelerometer bias, rotation error by gyroscope bias.
    """
    pulled = np.empty(3)  # specific force in NED, times dt
    for i in range(3):
        pulled[i] = 0.0
        for j in range(3):
            pulled[i] += dt * turned[i, j] * (force[j] - x[ACCELEROMETER_BIAS + j])
    _transition(p, turned, pulled, dt)
    _transpose(p)
    _transition(p, turned, pulled, dt)
    for i in range(3):
        p[VELOCITY + i, VELOCITY + i] += (noise[0] * dt) ** 2
        p[ROTATION_ERROR + i, ROTATION_ERROR + i] += (noise[1] * dt) ** 2
        p[ACCELEROMETER_BIAS_ERROR + i, ACCELEROMETER_BIAS_ERROR + i] += (noise[2] * dt) ** 2
        p[GYROSCOPE_BIAS_ERROR + i, GYROSCOPE_BIAS_ERROR + i] += (noise[3] * dt) ** 2


@njit(cache=True)
def _transition(p: np.ndarray, turned: np.ndarray, pulled: np.ndarray, dt: float) -> None:
    """Replace p by F p. pulled (3,): specific force in NED, times dt."""
    for c in range(ERROR_SIZE):
        for i in range(3):
            p[POSITION + i, c] += dt * p[VELOCITY + i, c]
        r0, r1, r2 = p[ROTATION_ERROR, c], p[ROTATION_ERROR + 1, c], p[ROTATION_ERROR + 2, c]
        p[VELOCITY, c] -= pulled[1] * r2 - pulled[2] * r1
        p[VELOCITY + 1, c] -= pulled[2] * r0 - pulled[0] * r2
        p[VELOCITY + 2, c] -= pulled[0] * r1 - pulled[1] * r0
        for i in range(3):
            for j in range(3):
                p[VELOCITY + i, c] -= dt * turned[i, j] * p[ACCELEROMETER_BIAS_ERROR + j, c]
                p[ROTATION_ERROR + i, c] -= dt * turned[i, j] * p[GYROSCOPE_BIAS_ERROR + j, c]


@njit(cache=True)
def _transpose(p: np.ndarray) -> None:
    for i in range(ERROR_SIZE):
        for j in range(i):
            p[i, j], p[j, i] = p[j, i], p[i, j]
