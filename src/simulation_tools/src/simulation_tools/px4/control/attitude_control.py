"""PX4's attitude and rate control: attitude setpoint and estimate in, torques out (FRD, normalised to -1..1).

Attitude: P on the quaternion error, with yaw weighted less than tilt (Brescianini, Hehn, D'Andrea, "Nonlinear
quadrocopter attitude control", ETH 2013). Rate: PID on low-passed gyro rates. Structure as PX4's
AttitudeControl and RateControl.
"""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.geometry import Vector3
from simulation_tools.px4.parameters import Px4Parameters

AXES = ("ROLL", "PITCH", "YAW")
_FULL_INTEGRAL_RATE_ERROR = math.radians(400.0)  # rad/s; the integral gain falls to zero towards this error

ATTITUDE_GAINS_DTYPE = np.dtype(
    [("p", np.float64, (3,)), ("yaw_weight", np.float64), ("rate_max", np.float64, (3,))]
)

RATE_GAINS_DTYPE = np.dtype(
    [
        ("p", np.float64, (3,)),
        ("i", np.float64, (3,)),
        ("d", np.float64, (3,)),
        ("integral_max", np.float64, (3,)),
        ("gyro", np.float64, (5,)),  # low pass of the rates: b0, b1, b2, a1, a2
        ("acceleration", np.float64, (5,)),  # low pass of the angular acceleration
    ]
)

RATE_STATE_DTYPE = np.dtype(
    [
        ("integral", np.float64, (3,)),
        ("filtered", np.float64, (3,)),  # rad/s, low-passed rates
        ("gyro_delay", np.float64, (3, 2)),
        ("acceleration_delay", np.float64, (3, 2)),
        ("has_previous", np.int64),
    ]
)


_Quaternion = tuple[float, float, float, float]  # w, x, y, z


@njit(cache=True)
def _multiply(a: _Quaternion, b: _Quaternion) -> _Quaternion:
    """Hamilton product of (w, x, y, z) tuples."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@njit(cache=True)
def _body_z(q: _Quaternion) -> Vector3:
    """Where the body's z axis points, in the outer frame."""
    w, x, y, z = q
    return (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z)


@njit(cache=True)
def fill_rates_setpoint(
    attitude: np.ndarray, wanted: np.ndarray, yaw_rate: float, gain_records: np.ndarray, out: np.ndarray
) -> None:
    """Attitude P: fill out (3,), rad/s FRD, from the attitude and the wanted one (w, x, y, z)."""
    gains = gain_records[0]
    q = (attitude[0], attitude[1], attitude[2], attitude[3])
    qd = (wanted[0], wanted[1], wanted[2], wanted[3])
    inverse = (q[0], -q[1], -q[2], -q[3])

    # The shortest turn of the thrust axis onto the wanted one; it leaves yaw alone.
    a, b = _body_z(q), _body_z(qd)
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    reduced = qd
    if dot > -1.0 + 1e-9:
        half = math.sqrt(2.0 * (1.0 + dot))
        turn = (
            0.5 * half,
            (a[1] * b[2] - a[2] * b[1]) / half,
            (a[2] * b[0] - a[0] * b[2]) / half,
            (a[0] * b[1] - a[1] * b[0]) / half,
        )
        if abs(turn[1]) <= 1.0 - 1e-5 and abs(turn[2]) <= 1.0 - 1e-5:
            reduced = _multiply(turn, q)

    # The rest of the way to the full attitude is a turn about the thrust axis. Take a part of it.
    mix = _multiply((reduced[0], -reduced[1], -reduced[2], -reduced[3]), qd)
    sign = -1.0 if mix[0] < 0.0 else 1.0
    mix_w = min(max(sign * mix[0], -1.0), 1.0)
    mix_z = min(max(sign * mix[3], -1.0), 1.0)
    weight = gains.yaw_weight
    part = (math.cos(weight * math.acos(mix_w)), 0.0, 0.0, math.sin(weight * math.asin(mix_z)))
    error = _multiply(inverse, _multiply(reduced, part))
    sign = -1.0 if error[0] < 0.0 else 1.0

    down = _body_z(inverse)  # the world's z axis in the body
    for i in range(3):
        # The yaw gain makes up for the yaw weight.
        p = gains.p[i] / weight if i == 2 and weight > 1e-4 else gains.p[i]
        rate = p * 2.0 * sign * error[1 + i] + down[i] * yaw_rate
        out[i] = min(max(rate, -gains.rate_max[i]), gains.rate_max[i])


@njit(cache=True)
def _filter(coefficients: np.ndarray, delay: np.ndarray, value: float) -> float:
    """One step of a second-order filter in direct form II; delay (2,)."""
    b0, b1, b2 = coefficients[0], coefficients[1], coefficients[2]
    a1, a2 = coefficients[3], coefficients[4]
    d0 = value - delay[0] * a1 - delay[1] * a2
    out = d0 * b0 + delay[0] * b1 + delay[1] * b2
    delay[1] = delay[0]
    delay[0] = d0
    return out


@njit(cache=True)
def fill_torques(
    rates: np.ndarray,
    wanted: np.ndarray,
    saturation: np.ndarray,
    integrate: bool,
    dt: float,
    gain_records: np.ndarray,
    states: np.ndarray,
    out: np.ndarray,
) -> None:
    """Rate PID: fill out (3,), normalised torques.

    rates, wanted: rad/s FRD. saturation (3, 2): for each axis, whether the mixer is at its limit in the
    negative and in the positive direction. integrate: false on the ground.
    """
    gains, state = gain_records[0], states[0]
    for i in range(3):
        if not state.has_previous:
            # Start the filter in its steady state.
            d = rates[i] / (1.0 + gains.gyro[3] + gains.gyro[4])
            state.gyro_delay[i, 0] = d
            state.gyro_delay[i, 1] = d
            state.filtered[i] = rates[i]
        before = state.filtered[i]
        state.filtered[i] = _filter(gains.gyro, state.gyro_delay[i], rates[i])
        acceleration = _filter(
            gains.acceleration, state.acceleration_delay[i], (state.filtered[i] - before) / dt
        )
        error = wanted[i] - state.filtered[i]
        out[i] = min(max(gains.p[i] * error + state.integral[i] - gains.d[i] * acceleration, -1.0), 1.0)
        if integrate:
            if saturation[i, 1]:
                error = min(error, 0.0)
            if saturation[i, 0]:
                error = max(error, 0.0)
            # Less integral at large errors, because else the UAV bounces back after a flip.
            factor = max(0.0, 1.0 - (error / _FULL_INTEGRAL_RATE_ERROR) ** 2)
            integral = state.integral[i] + factor * gains.i[i] * error * dt
            state.integral[i] = min(max(integral, -gains.integral_max[i]), gains.integral_max[i])
    state.has_previous = 1


def low_pass(cutoff_hz: float, sample_rate_hz: float) -> tuple[float, float, float, float, float]:
    """Coefficients b0, b1, b2, a1, a2 of a second-order Butterworth low pass (bilinear transform).

    A cut-off of 0, or one above half of the sample rate, lets everything pass.
    """
    if cutoff_hz <= 0.0 or cutoff_hz >= 0.5 * sample_rate_hz:
        return (1.0, 0.0, 0.0, 0.0, 0.0)
    ohm = math.tan(math.pi * cutoff_hz / sample_rate_hz)
    c = 1.0 + 2.0 * math.cos(0.25 * math.pi) * ohm + ohm * ohm
    b0 = ohm * ohm / c
    a1 = 2.0 * (ohm * ohm - 1.0) / c
    a2 = (1.0 - 2.0 * math.cos(0.25 * math.pi) * ohm + ohm * ohm) / c
    return (b0, 2.0 * b0, b0, a1, a2)


class AttitudeControl:
    """Attitude P controller; `rates_setpoint` (3,) rad/s FRD is its newest output.

    gains: a record of ATTITUDE_GAINS_DTYPE, shape (1,).
    """

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.gains = np.zeros(1, ATTITUDE_GAINS_DTYPE)
        self.rates_setpoint = np.zeros(3)
        self.load_parameters()

    def load_parameters(self) -> None:
        """Take the gains from the parameters again."""
        p = self._parameters
        self.gains["p"] = [p[f"MC_{axis}_P"] for axis in AXES]
        self.gains["yaw_weight"] = p["MC_YAW_WEIGHT"]
        self.gains["rate_max"] = [math.radians(p[f"MC_{axis}RATE_MAX"]) for axis in AXES]

    def reset(self) -> None:
        """Forget the last output."""
        self.rates_setpoint[:] = 0.0

    def update(self, attitude: np.ndarray, wanted: np.ndarray, yaw_rate: float) -> np.ndarray:
        """attitude, wanted: (4,) FRD in NED, w x y z; yaw_rate: rad/s about the world's down axis."""
        fill_rates_setpoint(attitude, wanted, yaw_rate, self.gains, self.rates_setpoint)
        return self.rates_setpoint


class RateControl:
    """Rate PID controller with PX4's filters; `torques` (3,) in -1..1 is its newest output.

    gains, state: records of RATE_GAINS_DTYPE and RATE_STATE_DTYPE, shape (1,).
    """

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.gains = np.zeros(1, RATE_GAINS_DTYPE)
        self.state = np.zeros(1, RATE_STATE_DTYPE)
        self._dt_s = 0.004
        self.torques = np.zeros(3)
        self.load_parameters()

    def load_parameters(self) -> None:
        """Take gains and filters from the parameters again."""
        p, gains = self._parameters, self.gains
        scale = np.array([p[f"MC_{axis}RATE_K"] for axis in AXES])
        for term in "PID":
            gains[term.lower()] = scale * [p[f"MC_{axis}RATE_{term}"] for axis in AXES]
        gains["integral_max"] = [p[f"MC_{letter}R_INT_LIM"] for letter in "RPY"]
        gains["gyro"] = low_pass(p["IMU_GYRO_CUTOFF"], 1.0 / self._dt_s)
        gains["acceleration"] = low_pass(p["IMU_DGYRO_CUTOFF"], 1.0 / self._dt_s)

    def reset(self) -> None:
        """Forget everything, as at power-on."""
        self.state[:] = np.zeros(1, RATE_STATE_DTYPE)
        self.torques[:] = 0.0

    def reset_integral(self) -> None:
        """Forget the integrators: disarmed they would wind up."""
        self.state["integral"] = 0.0

    def adapt_to(self, dt_s: float) -> None:
        """Set the filters for gyro samples that are dt_s apart."""
        if abs(dt_s - self._dt_s) > 1e-9:
            self._dt_s = dt_s
            self.load_parameters()

    def update(
        self, rates: np.ndarray, wanted: np.ndarray, saturation: np.ndarray, integrate: bool, dt_s: float
    ) -> np.ndarray:
        """Return the torques; arguments as `fill_torques` says, dt_s since the last call."""
        self.adapt_to(dt_s)
        fill_torques(rates, wanted, saturation, integrate, dt_s, self.gains, self.state, self.torques)
        return self.torques
