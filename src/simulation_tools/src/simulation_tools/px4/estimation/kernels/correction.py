"""Correction (Sola, chapter 6). Each measurement is a scalar, so there is nothing to invert.

The covariance's reset after the injection of an error (equation 285) is left out, because it is the identity
to first order.
"""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.px4.estimation.kernels.rotations import exponential, matrix, multiply, wrapped, yaw_of
from simulation_tools.px4.estimation.kernels.states import (
    ACCELEROMETER_BIAS,
    ACCELEROMETER_BIAS_ERROR,
    ATTITUDE,
    ERROR_SIZE,
    GYROSCOPE_BIAS,
    GYROSCOPE_BIAS_ERROR,
    LEAST_VARIANCE,
    ROTATION_ERROR,
)


@njit(cache=True)
def correct(x: np.ndarray, p: np.ndarray, row: np.ndarray, innovation: float, variance: float) -> None:
    """Take in one scalar measurement: its row H (15,), innovation and innovation variance H P H' + R."""
    spread = np.empty(ERROR_SIZE)  # P H'
    for i in range(ERROR_SIZE):
        total = 0.0
        for j in range(ERROR_SIZE):
            if row[j] != 0.0:
                total += p[i, j] * row[j]
        spread[i] = total
    for i in range(ERROR_SIZE):
        gain = spread[i] / variance
        for j in range(i, ERROR_SIZE):
            p[i, j] -= gain * spread[j]
            p[j, i] = p[i, j]
        p[i, i] = max(p[i, i], LEAST_VARIANCE)
    inject(x, spread * (innovation / variance))


@njit(cache=True)
def inject(x: np.ndarray, error: np.ndarray) -> None:
    """Add an error (15,) to the nominal state (equations 283a to 283e)."""
    for i in range(ROTATION_ERROR):
        x[i] += error[i]
    turn = np.empty(4)
    exponential(error[ROTATION_ERROR], error[ROTATION_ERROR + 1], error[ROTATION_ERROR + 2], turn)
    attitude = x[ATTITUDE : ATTITUDE + 4]
    multiply(turn, attitude, attitude)
    for i in range(3):
        x[ACCELEROMETER_BIAS + i] += error[ACCELEROMETER_BIAS_ERROR + i]
        x[GYROSCOPE_BIAS + i] += error[GYROSCOPE_BIAS_ERROR + i]


@njit(cache=True)
def fuse_components(
    x: np.ndarray, p: np.ndarray, first: int, measured: np.ndarray, variances: np.ndarray, gate: float
) -> float:
    """Take in measured components of position or velocity, all or none of them; return the test ratio.

    first: index of the first component. measured, variances: (n,). The ratio is the greatest of
    innovation^2 / (gate^2 innovation variance). Above 1, or NaN, the measurement is rejected.
    """
    ratio = 0.0
    for k in range(measured.size):
        i = first + k
        here = (measured[k] - x[i]) ** 2 / (gate * gate * (p[i, i] + variances[k]))
        if here > ratio or math.isnan(here):  # once NaN, it stays NaN
            ratio = here
    if ratio <= 1.0:
        row = np.zeros(ERROR_SIZE)
        for k in range(measured.size):
            i = first + k
            row[i] = 1.0
            correct(x, p, row, measured[k] - x[i], p[i, i] + variances[k])
            row[i] = 0.0
    return ratio


@njit(cache=True)
def yaw_row(x: np.ndarray, row: np.ndarray) -> None:
    """Fill the row (15,) of a measured heading: the derivative of the yaw by the error state.

    With R the rotation matrix, yaw = atan2(R10, R00), and a small rotation t in NED changes R by [t]x R.
    """
    turned = np.empty((3, 3))
    matrix(x[ATTITUDE : ATTITUDE + 4], turned)
    level = max(turned[0, 0] ** 2 + turned[1, 0] ** 2, 1e-6)
    row[:] = 0.0
    row[ROTATION_ERROR] = -turned[2, 0] * turned[0, 0] / level
    row[ROTATION_ERROR + 1] = -turned[2, 0] * turned[1, 0] / level
    row[ROTATION_ERROR + 2] = 1.0


@njit(cache=True)
def fuse_yaw(
    x: np.ndarray, p: np.ndarray, yaw_rad: float, variance: float, gate: float, clipped: bool
) -> float:
    """Take in a heading; return the test ratio. clipped: reduce a too great innovation to the gate's."""
    row = np.empty(ERROR_SIZE)
    yaw_row(x, row)
    total = variance
    for i in range(ROTATION_ERROR, ROTATION_ERROR + 3):
        for j in range(ROTATION_ERROR, ROTATION_ERROR + 3):
            total += row[i] * p[i, j] * row[j]
    innovation = wrapped(yaw_rad - yaw_of(x[ATTITUDE : ATTITUDE + 4]))
    ratio = innovation**2 / (gate * gate * total)
    if ratio > 1.0 and clipped:
        innovation = math.copysign(gate * math.sqrt(total), innovation)
    if ratio <= 1.0 or (clipped and math.isfinite(ratio)):
        correct(x, p, row, innovation, total)
    return ratio


@njit(cache=True)
def forget(p: np.ndarray, first: int, variances: np.ndarray) -> None:
    """Give components of the error state new variances (n,), without any correlation to the others."""
    for k in range(variances.size):
        i = first + k
        p[i, :] = 0.0
        p[:, i] = 0.0
        p[i, i] = variances[k]


@njit(cache=True)
def limit_biases(x: np.ndarray, p: np.ndarray, greatest: float, least_variance: float) -> None:
    """Keep each accelerometer bias within +-greatest, m/s2, and its variance from falling too low."""
    for i in range(3):
        x[ACCELEROMETER_BIAS + i] = min(max(x[ACCELEROMETER_BIAS + i], -greatest), greatest)
        k = ACCELEROMETER_BIAS_ERROR + i
        p[k, k] = max(p[k, k], least_variance)


@njit(cache=True)
def reset_yaw(x: np.ndarray, p: np.ndarray, yaw_rad: float, variance: float, turn: np.ndarray) -> None:
    """Turn the attitude about the vertical to a heading; fills `turn` (4,), from the old to the new."""
    exponential(0.0, 0.0, wrapped(yaw_rad - yaw_of(x[ATTITUDE : ATTITUDE + 4])), turn)
    attitude = x[ATTITUDE : ATTITUDE + 4]
    multiply(turn, attitude, attitude)
    forget(p, ROTATION_ERROR + 2, np.array([variance]))
