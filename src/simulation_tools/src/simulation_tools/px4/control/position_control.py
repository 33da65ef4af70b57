"""PX4's position and velocity control: setpoint and estimate in, attitude and thrust setpoint out (NED).

Position P, velocity PID that gives an acceleration, thrust vector with limited tilt, and the attitude that
points along it with the wanted yaw. Structure and saturation are those of PX4's PositionControl. The control
law was measured on real PX4: v = P e_p, a = P e_v + I - D dv/dt.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.px4.control.records import ATTITUDE_SETPOINT_DTYPE
from simulation_tools.px4.parameters import Px4Parameters

GRAVITY_M_S2 = 9.80665

GAINS_DTYPE = np.dtype(
    [
        ("position_p", np.float64, (3,)),
        ("velocity_p", np.float64, (3,)),
        ("velocity_i", np.float64, (3,)),
        ("velocity_d", np.float64, (3,)),
        ("derivative_cutoff_hz", np.float64),
        ("speed_xy_max", np.float64),
        ("thrust_max", np.float64),
    ]
)

LIMITS_DTYPE = np.dtype(
    [
        ("speed_up", np.float64),  # m/s; below zero at the start of the take-off ramp
        ("speed_down", np.float64),
        ("tilt", np.float64),  # rad
        ("thrust_min", np.float64),
    ]
)
"""`FlightControl` fills it as a whole, in this order."""

STATE_DTYPE = np.dtype(
    [
        ("integral", np.float64, (3,)),  # m/s2
        ("derivative", np.float64, (3,)),  # m/s2, low-passed
        ("previous_velocity", np.float64, (3,)),
        ("has_previous", np.int64),
        ("hover_thrust", np.float64),
    ]
)


@njit(cache=True)
def _limit_xy(
    preferred_x: float, preferred_y: float, extra_x: float, extra_y: float, limit: float
) -> tuple[float, float]:
    """Add two horizontal velocities within a limit. Reduce the preferred one last."""
    sum_x, sum_y = preferred_x + extra_x, preferred_y + extra_y
    if math.hypot(sum_x, sum_y) <= limit:
        return sum_x, sum_y
    preferred = math.hypot(preferred_x, preferred_y)
    if preferred >= limit:
        return preferred_x / preferred * limit, preferred_y / preferred * limit
    if math.hypot(extra_x - preferred_x, extra_y - preferred_y) < 0.001:
        norm = math.hypot(sum_x, sum_y)
        return sum_x / norm * limit, sum_y / norm * limit
    extra = math.hypot(extra_x, extra_y)
    if extra < 0.001:
        return preferred_x, preferred_y
    # Preferred plus as much of the extra as reaches the limit: |p + s u| = limit.
    ux, uy = extra_x / extra, extra_y / extra
    along = ux * preferred_x + uy * preferred_y
    root = along * along - (preferred * preferred - limit * limit)
    scale = -along + math.sqrt(max(root, 0.0))
    return preferred_x + ux * scale, preferred_y + uy * scale


@njit(cache=True)
def _derivative(state: Any, velocity: np.ndarray, cutoff_hz: float, dt: float) -> None:
    """Low-passed derivative of the velocity."""
    b = 2.0 * math.pi * cutoff_hz * dt
    for i in range(3):
        if state.has_previous:
            raw = (velocity[i] - state.previous_velocity[i]) / dt
            share = b / (1.0 + b) if cutoff_hz > 0.0 else 1.0
            state.derivative[i] += share * (raw - state.derivative[i])
        state.previous_velocity[i] = velocity[i]
    state.has_previous = 1


@njit(cache=True)
def _velocity_setpoint(setpoint: Any, estimate: Any, gains: Any, limits: Any, out: np.ndarray) -> None:
    """Position loop; out: velocity setpoint, NaN on axes where neither position nor velocity is asked for."""
    towards = np.zeros(3)
    extra = np.zeros(3)
    asked = np.zeros(3, np.bool_)
    for i in range(3):
        if not math.isnan(setpoint.position[i]):
            towards[i] = gains.position_p[i] * (setpoint.position[i] - estimate.position[i])
            asked[i] = True
        if not math.isnan(setpoint.velocity[i]):
            extra[i] = setpoint.velocity[i]
            asked[i] = True
    x, y = _limit_xy(towards[0], towards[1], extra[0], extra[1], gains.speed_xy_max)
    out[0] = x if asked[0] else math.nan
    out[1] = y if asked[1] else math.nan
    z = towards[2] + extra[2]
    # Apply the upper bound first. At the start of the take-off ramp it lies beyond the lower one.
    z = -limits.speed_up if z < -limits.speed_up else min(z, max(limits.speed_down, -limits.speed_up))
    out[2] = z if asked[2] else math.nan


@njit(cache=True)
def _thrust_vector(
    acceleration: np.ndarray, hover_thrust: float, tilt_max: float, thrust_min: float, out: np.ndarray
) -> None:
    """Thrust (NED, normalised) for an acceleration; tilt limited, at least thrust_min."""
    x, y, z = -acceleration[0], -acceleration[1], GRAVITY_M_S2
    norm = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / norm, y / norm, z / norm
    tilt = math.acos(min(1.0, max(-1.0, z)))
    if tilt > tilt_max:
        horizontal = math.hypot(x, y)
        x, y, z = (
            x / horizontal * math.sin(tilt_max),
            y / horizontal * math.sin(tilt_max),
            math.cos(tilt_max),
        )
    # Hover thrust gives an acceleration of one gravity.
    collective = acceleration[2] * hover_thrust / GRAVITY_M_S2 - hover_thrust
    collective = min(collective / z, -thrust_min)
    out[0], out[1], out[2] = x * collective, y * collective, z * collective


@njit(cache=True)
def _attitude(thrust: np.ndarray, yaw: float, q: np.ndarray) -> None:
    """Attitude whose -z axis points along the thrust (NED) and whose x axis heads towards yaw."""
    norm = math.sqrt(thrust[0] ** 2 + thrust[1] ** 2 + thrust[2] ** 2)
    bz = (0.0, 0.0, 1.0)
    if norm > 1e-9:
        bz = (-thrust[0] / norm, -thrust[1] / norm, -thrust[2] / norm)
    # y axis of the heading in the world's plane; the tilt limit keeps bz[2] above zero.
    yc = (-math.sin(yaw), math.cos(yaw), 0.0)
    bx = (yc[1] * bz[2] - yc[2] * bz[1], yc[2] * bz[0] - yc[0] * bz[2], yc[0] * bz[1] - yc[1] * bz[0])
    length = math.sqrt(bx[0] ** 2 + bx[1] ** 2 + bx[2] ** 2)
    bx = (bx[0] / length, bx[1] / length, bx[2] / length)
    by = (bz[1] * bx[2] - bz[2] * bx[1], bz[2] * bx[0] - bz[0] * bx[2], bz[0] * bx[1] - bz[1] * bx[0])
    trace = bx[0] + by[1] + bz[2]
    if trace > 0.0:
        s = 2.0 * math.sqrt(trace + 1.0)
        q[0], q[1], q[2], q[3] = 0.25 * s, (by[2] - bz[1]) / s, (bz[0] - bx[2]) / s, (bx[1] - by[0]) / s
    elif bx[0] >= by[1] and bx[0] >= bz[2]:
        s = 2.0 * math.sqrt(1.0 + bx[0] - by[1] - bz[2])
        q[0], q[1], q[2], q[3] = (by[2] - bz[1]) / s, 0.25 * s, (by[0] + bx[1]) / s, (bz[0] + bx[2]) / s
    elif by[1] >= bz[2]:
        s = 2.0 * math.sqrt(1.0 + by[1] - bx[0] - bz[2])
        q[0], q[1], q[2], q[3] = (bz[0] - bx[2]) / s, (by[0] + bx[1]) / s, 0.25 * s, (bz[1] + by[2]) / s
    else:
        s = 2.0 * math.sqrt(1.0 + bz[2] - bx[0] - by[1])
        q[0], q[1], q[2], q[3] = (bx[1] - by[0]) / s, (bz[0] + bx[2]) / s, (bz[1] + by[2]) / s, 0.25 * s


@njit(cache=True)
def _update(
    setpoints: np.ndarray,
    estimates: np.ndarray,
    gain_records: np.ndarray,
    limit_records: np.ndarray,
    states: np.ndarray,
    dt: float,
    outputs: np.ndarray,
) -> None:
    """One step of the whole chain; fills outputs[0]."""
    setpoint, estimate, gains = setpoints[0], estimates[0], gain_records[0]
    limits, state, out = limit_records[0], states[0], outputs[0]
    _derivative(state, estimate.velocity, gains.derivative_cutoff_hz, dt)
    _velocity_setpoint(setpoint, estimate, gains, limits, out.velocity)

    error = np.zeros(3)
    for i in range(3):
        feed_forward = setpoint.acceleration[i]
        if math.isnan(out.velocity[i]):
            out.acceleration[i] = 0.0 if math.isnan(feed_forward) else feed_forward
            continue
        error[i] = out.velocity[i] - estimate.velocity[i]
        out.acceleration[i] = (
            gains.velocity_p[i] * error[i] + state.integral[i] - gains.velocity_d[i] * state.derivative[i]
        )
        if not math.isnan(feed_forward):
            out.acceleration[i] += feed_forward

    thrust = out.thrust_vector
    _thrust_vector(out.acceleration, state.hover_thrust, limits.tilt, limits.thrust_min, thrust)

    # Vertical anti-windup: stop integrating at either limit of the thrust.
    if (thrust[2] >= -limits.thrust_min and error[2] >= 0.0) or (
        thrust[2] <= -gains.thrust_max and error[2] <= 0.0
    ):
        error[2] = 0.0
    # Vertical thrust first; the horizontal gets what is left.
    thrust[2] = max(thrust[2], -gains.thrust_max)
    left = math.sqrt(max(gains.thrust_max**2 - thrust[2] ** 2, 0.0))
    horizontal = math.hypot(thrust[0], thrust[1])
    if horizontal > left:
        thrust[0] *= left / horizontal
        thrust[1] *= left / horizontal
    # Horizontal anti-windup by tracking (Rundqwist, 1990): the integrator follows the possible thrust.
    for i in range(2):
        if not math.isnan(out.velocity[i]):
            had = thrust[i] * GRAVITY_M_S2 / state.hover_thrust
            error[i] -= 2.0 / gains.velocity_p[0] * (out.acceleration[i] - had)
    for i in range(3):
        state.integral[i] += gains.velocity_i[i] * error[i] * dt
    state.integral[2] = min(max(state.integral[2], -GRAVITY_M_S2), GRAVITY_M_S2)

    out.yaw = estimate.yaw if math.isnan(setpoint.yaw) else setpoint.yaw
    out.yaw_rate = 0.0 if math.isnan(setpoint.yaw_rate) else setpoint.yaw_rate
    out.thrust = math.sqrt(thrust[0] ** 2 + thrust[1] ** 2 + thrust[2] ** 2)
    _attitude(thrust, out.yaw, out.attitude)


class PositionControl:
    """Position and velocity control with its integrators. Every argument is a record array of shape (1,)."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self._gains = np.zeros(1, GAINS_DTYPE)
        self._state = np.zeros(1, STATE_DTYPE)
        self.limits = np.zeros(1, LIMITS_DTYPE)
        self.output = np.zeros(1, ATTITUDE_SETPOINT_DTYPE)
        self._take_views()
        self.load_parameters()
        self.reset()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Become a copy, with views of its own records."""
        vars(self).update(state)
        self._take_views()

    def _take_views(self) -> None:
        """Look up the fields that change in flight once."""
        self._integral, self._hover_thrust = self._state["integral"][0], self._state["hover_thrust"]
        self._acceleration = self.output["acceleration"][0]

    def load_parameters(self) -> None:
        """Take the gains from the parameters again."""
        p, gains = self._parameters, self._gains
        gains["position_p"] = (p["MPC_XY_P"], p["MPC_XY_P"], p["MPC_Z_P"])
        for term in "PID":
            horizontal = p[f"MPC_XY_VEL_{term}_ACC"]
            gains[f"velocity_{term.lower()}"] = (horizontal, horizontal, p[f"MPC_Z_VEL_{term}_ACC"])
        gains["derivative_cutoff_hz"] = p["MPC_VELD_LP"]
        gains["speed_xy_max"] = p["MPC_XY_VEL_MAX"]
        gains["thrust_max"] = p["MPC_THR_MAX"]

    def reset(self) -> None:
        """Forget everything, as at power-on."""
        self._state[:] = np.zeros(1, STATE_DTYPE)
        self.output[:] = np.zeros(1, ATTITUDE_SETPOINT_DTYPE)
        self.output["attitude"][0, 0] = 1.0
        self.set_hover_thrust(self._parameters["MPC_THR_HOVER"])

    def reset_integral(self) -> None:
        """Reset the velocity integrators, because they would wind up on the ground."""
        self._integral[:] = 0.0

    @property
    def hover_thrust(self) -> float:
        """The assumed hover thrust, 0..1."""
        return self._hover_thrust.item()

    def set_hover_thrust(self, hover_thrust: float) -> None:
        """Set the hover thrust before the flight."""
        self._hover_thrust[0] = min(max(hover_thrust, 0.1), 0.9)

    def update_hover_thrust(self, hover_thrust: float) -> None:
        """Change the hover thrust in flight. The integrator compensates, so thrust does not jump."""
        old, new = self.hover_thrust, min(max(hover_thrust, 0.1), 0.9)
        wanted = self._acceleration.item(2)
        self._integral[2] += (wanted - GRAVITY_M_S2) * old / new + GRAVITY_M_S2 - wanted
        self._hover_thrust[0] = new

    def update(self, setpoint: np.ndarray, estimate: np.ndarray, dt_s: float) -> np.ndarray:
        """Return the attitude setpoint (the same record each time); `limits` must have been set."""
        _update(setpoint, estimate, self._gains, self.limits, self._state, dt_s, self.output)
        return self.output
