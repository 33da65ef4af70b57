"""From the fusion horizon to the present.

Measurements are late: GNSS by EKF2_GPS_DELAY, vision by EKF2_EV_DELAY. The filter therefore runs that much
behind, at the *fusion horizon*, and takes in each measurement at its own time. An inertial navigation without
a filter runs at the present. Its difference to the filter at the horizon is fed back to it (A. Khosravian et
al., "Recursive attitude estimation in the presence of multi-rate and multi-delay vector measurements", ACC
2015). PX4's EKF2 does the same. It is cheaper to correct thirty stored states than to predict thirty
covariances again.
"""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.px4.estimation.kernels.prediction import GRAVITY_M_S2, integrate, propagate
from simulation_tools.px4.estimation.kernels.rotations import matrix, multiply, yaw_of
from simulation_tools.px4.estimation.kernels.states import (
    ACCELEROMETER_BIAS,
    ATTITUDE,
    GYROSCOPE_BIAS,
    POSITION,
    VELOCITY,
)


@njit(cache=True)
def advance(
    samples: np.ndarray,
    clocks: np.ndarray,
    x: np.ndarray,
    p: np.ndarray,
    noise: np.ndarray,
    now: np.ndarray,
    delay_us: int,
    period: float,
) -> bool:
    """Take in the newest sample, which has been written to samples[head]; return whether it is time to fuse.

    now (16,): the present nominal state, predicted by the sample. x, p: the filter, predicted with every
    sample that leaves the delay. The covariance follows at the slower `period`, s.
    """
    clock = clocks[0]
    newest = samples[clock.head]
    dt = newest.dt
    now[10:] = x[10:]
    rates = np.empty(3)
    for i in range(3):
        rates[i] = newest.rates[i] + clock.turn_correction[i] / dt
    turned = np.empty((3, 3))
    integrate(now, rates, newest.force, dt, turned)
    newest.predicted[:] = now[:10]
    clock.head = (clock.head + 1) % samples.size
    clock.count += 1

    due = False
    while clock.count > 0:
        oldest = samples[(clock.head - clock.count) % samples.size]
        if oldest.time_us > newest.time_us - delay_us and clock.count < samples.size:
            break
        integrate(x, oldest.rates, oldest.force, oldest.dt, turned)
        clock.horizon_us = oldest.time_us
        clock.count -= 1
        clock.since_propagation += oldest.dt
        if clock.since_propagation >= period - 0.5 * oldest.dt:
            propagate(p, x, turned, oldest.force, clock.since_propagation, noise)
            clock.since_propagation = 0.0
            due = True
    return due


@njit(cache=True)
def follow(
    samples: np.ndarray,
    clocks: np.ndarray,
    x: np.ndarray,
    now: np.ndarray,
    period: float,
    time_constant_velocity: float,
    time_constant_position: float,
) -> None:
    """Feed the difference between filter and prediction at the horizon back to the prediction.

    Positions and velocities: proportional and integral, on the whole history at once, so that the delay is
    not within the loop. Attitude: by a rate, with half of the greatest gain that the delay allows.
    """
    clock = clocks[0]
    at_horizon = samples[(clock.head - clock.count - 1) % samples.size]
    newest = samples[(clock.head - 1) % samples.size]
    gain_velocity = period / max(time_constant_velocity, period)
    gain_position = period / max(time_constant_position, period)
    moved = np.zeros(6)
    for i in range(3):
        error = x[POSITION + i] - at_horizon.predicted[POSITION + i]
        clock.position_integral[i] += error
        moved[i] = gain_position * error + 0.1 * gain_position**2 * clock.position_integral[i]
        error = x[VELOCITY + i] - at_horizon.predicted[VELOCITY + i]
        clock.velocity_integral[i] += error
        moved[3 + i] = gain_velocity * error + 0.1 * gain_velocity**2 * clock.velocity_integral[i]
    turn = np.empty(4)
    turn[0] = at_horizon.predicted[ATTITUDE]
    turn[1:] = -at_horizon.predicted[ATTITUDE + 1 : ATTITUDE + 4]
    multiply(turn, x[ATTITUDE : ATTITUDE + 4], turn)
    share = math.copysign(newest.dt / max(1e-6 * (newest.time_us - clock.horizon_us), newest.dt), turn[0])
    clock.turn_correction[:] = share * turn[1:]
    _move(samples, clock.head, clock.count, moved, now)


@njit(cache=True)
def jump(samples: np.ndarray, clocks: np.ndarray, x: np.ndarray, now: np.ndarray) -> None:
    """Make the prediction equal to the filter at the horizon, at once; for resets."""
    clock = clocks[0]
    at_horizon = samples[(clock.head - clock.count - 1) % samples.size]
    moved = x[:6] - at_horizon.predicted[:6]
    turn = np.empty(4)
    turn[0] = at_horizon.predicted[ATTITUDE]
    turn[1:] = -at_horizon.predicted[ATTITUDE + 1 : ATTITUDE + 4]
    multiply(x[ATTITUDE : ATTITUDE + 4], turn, turn)  # from the old to the new, in NED
    for k in range(-1, clock.count):
        stored = samples[(clock.head - clock.count + k) % samples.size].predicted
        attitude = stored[ATTITUDE : ATTITUDE + 4]
        multiply(turn, attitude, attitude)
    attitude = now[ATTITUDE : ATTITUDE + 4]
    multiply(turn, attitude, attitude)
    clock.turn_correction[:] = 0.0
    clock.velocity_integral[:] = 0.0
    clock.position_integral[:] = 0.0
    _move(samples, clock.head, clock.count, moved, now)


@njit(cache=True)
def _move(samples: np.ndarray, head: int, count: int, by: np.ndarray, now: np.ndarray) -> None:
    """Add to position and velocity (6,) of the present and of every stored state from the horizon on."""
    for k in range(-1, count):
        stored = samples[(head - count + k) % samples.size].predicted
        for i in range(6):
            stored[i] += by[i]
    for i in range(6):
        now[i] += by[i]


@njit(cache=True)
def publish(now: np.ndarray, rates: np.ndarray, force: np.ndarray, estimates: np.ndarray) -> None:
    """Fill the estimate: the filter's present (16,), and the newest IMU sample (3,) without its biases."""
    known = estimates[0]
    for i in range(3):
        known.position[i] = now[POSITION + i]
        known.velocity[i] = now[VELOCITY + i]
        known.rates[i] = rates[i] - now[GYROSCOPE_BIAS + i]
        known.specific_force[i] = force[i] - now[ACCELEROMETER_BIAS + i]
    known.attitude[:] = now[ATTITUDE : ATTITUDE + 4]
    known.yaw = yaw_of(known.attitude)
    turned = np.empty((3, 3))
    matrix(known.attitude, turned)
    for i in range(3):
        known.acceleration[i] = GRAVITY_M_S2 if i == 2 else 0.0
        for j in range(3):
            known.acceleration[i] += turned[i, j] * known.specific_force[j]
