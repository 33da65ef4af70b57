"""The arithmetic of the error-state Kalman filter: prediction, correction, and the way from its past to now.

J. Sola, "Quaternion kinematics for the error-state Kalman filter", arXiv:1711.02508 (2017), with the
attitude's error of chapter 7: a small rotation in the world's axes (NED), so q_true = exp(error) q. Gravity
is known. A kernel's `x` is the nominal state (16,), `p` the covariance of the error state (15, 15).

Measurements are late: GNSS by EKF2_GPS_DELAY, vision by EKF2_EV_DELAY. The filter therefore runs that much
behind, at the *fusion horizon*, and takes in each measurement at its own time. An inertial navigation without
a filter runs at the present. Its difference to the filter at the horizon is fed back to it (A. Khosravian et
al., "Recursive attitude estimation in the presence of multi-rate and multi-delay vector measurements", ACC
2015). PX4's EKF2 does the same. It is cheaper to correct thirty stored states than to predict thirty
covariances again.

All kernels are in this one file, because numba's cache notices changes of a kernel's own file only.
"""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

GRAVITY_M_S2 = 9.80665

# Nominal state: position m and velocity m/s (NED), attitude (FRD in NED, w x y z), biases of accelerometer
# m/s2 and gyroscope rad/s (FRD).
POSITION, VELOCITY, ATTITUDE, ACCELEROMETER_BIAS, GYROSCOPE_BIAS, NOMINAL_SIZE = 0, 3, 6, 10, 13, 16

# Error state: as above, with a rotation vector (rad, NED) in the place of the attitude. The first two have
# the same indices in both states.
ROTATION_ERROR, ACCELEROMETER_BIAS_ERROR, GYROSCOPE_BIAS_ERROR, ERROR_SIZE = 6, 9, 12, 15
LEAST_VARIANCE = 1e-12  # of any component of the error state

IMU_DTYPE = np.dtype(
    [
        ("time_us", np.int64),  # of the sample's end
        ("dt", np.float64),  # s
        ("rates", np.float64, (3,)),  # rad/s, FRD
        ("force", np.float64, (3,)),  # m/s2, FRD
        ("predicted", np.float64, (10,)),  # the estimate after this sample: position, velocity, attitude
    ]
)

CLOCK_DTYPE = np.dtype(
    [
        ("head", np.int64),  # where the next sample goes
        ("count", np.int64),  # samples between horizon and now
        ("horizon_us", np.int64),
        ("since_propagation", np.float64),  # s of nominal prediction without one of the covariance
        ("turn_correction", np.float64, (3,)),  # rad per sample, FRD
        ("velocity_integral", np.float64, (3,)),
        ("position_integral", np.float64, (3,)),
    ]
)


# Rotations: quaternions w x y z (Hamilton), matrices from body to NED


@njit(cache=True)
def multiply(a: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """Fill `out` (4,) with the normalised product of two quaternions; `out` may be one of them."""
    w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    out[0], out[1], out[2], out[3] = w / norm, x / norm, y / norm, z / norm


@njit(cache=True)
def exponential(x: float, y: float, z: float, out: np.ndarray) -> None:
    """Fill `out` (4,) with the quaternion of a rotation vector, rad (Sola, equation 101)."""
    angle = math.sqrt(x * x + y * y + z * z)
    scale = 0.5 if angle < 1e-8 else math.sin(0.5 * angle) / angle
    out[0], out[1], out[2], out[3] = math.cos(0.5 * angle), scale * x, scale * y, scale * z


@njit(cache=True)
def matrix(q: np.ndarray, out: np.ndarray) -> None:
    """Fill `out` (3, 3) with the rotation matrix of a unit quaternion."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0, 0], out[0, 1], out[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[1, 0], out[1, 1], out[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[2, 0], out[2, 1], out[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@njit(cache=True)
def yaw_of(q: np.ndarray) -> float:
    """Return the heading of a quaternion, rad clockwise from north."""
    return math.atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] ** 2 + q[3] ** 2))


@njit(cache=True)
def wrapped(angle_rad: float) -> float:
    """Return the same angle in (-pi, pi]."""
    return angle_rad - 2.0 * math.pi * math.ceil((angle_rad - math.pi) / (2.0 * math.pi))


# Prediction


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


# Correction (chapter 6). Each measurement is a scalar, so there is nothing to invert. The covariance's reset
# after the injection of an error (equation 285) is left out, because it is the identity to first order.


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


# From the horizon to the present


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
