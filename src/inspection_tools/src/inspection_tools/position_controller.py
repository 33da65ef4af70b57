"""Velocity towards a position setpoint, limited in speed and acceleration (thesis, 5.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from flight_basics.bounds import FARTHEST_M, MAX_TIME_STEP_S
from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError, PoseError
from flight_basics.geometry import Vector3
from inspection_tools.leg import Leg


@dataclass(frozen=True)
class PositionControllerParameters:
    """Limits and gains of the position controller.

    Far from the setpoint the UAV flies at the speed limit. Nearer to it the speed falls with constant
    `braking_deceleration`, and in the end in proportion to the distance (`gain`). Both parts meet without a
    kink at the distance braking_deceleration / gain^2. The vertical axis works in the same way,
    independently.

    Raises:
        ParameterError: a value out of range, or braking harder than `max_acceleration`.
    """

    max_speed: float = limited(2.0, 0.0, 15.0)
    """Horizontal speed limit, m/s."""
    max_acceleration: float = limited(2.0, 0.1, 10.0)
    """Limit of every change of the horizontal velocity, m/s^2."""
    braking_deceleration: float = limited(1.0, 0.1, 10.0)
    """Deceleration of the approach, m/s^2; at most `max_acceleration`, so that this limit never delays the
    braking.
    """
    gain: float = limited(1.25, 0.1, 5.0)
    """Speed per distance near the setpoint, 1/s."""
    max_vertical_speed: float = limited(1.0, 0.0, 5.0)
    """Vertical speed limit, m/s."""
    max_vertical_acceleration: float = limited(1.0, 0.1, 10.0)
    """Limit of every change of the vertical velocity, m/s^2. The approach decelerates at half of it."""
    vertical_gain: float = limited(1.0, 0.1, 5.0)
    """Vertical speed per distance near the setpoint, 1/s."""
    goal_tolerance: float = limited(0.2, 0.01, 10.0)
    """The goal is reached if it is nearer than this (in space), m."""
    goal_hysteresis: float = limited(0.1, 0.0, 10.0)
    """The goal stays reached until the distance exceeds the tolerance by this, m."""
    lookahead: float = limited(0.0, 0.0, 10.0)
    """0: the UAV flies straight to the setpoint. Else it follows the straight leg from the last setpoint to
    this one, and aims at the place on it that is as far ahead as it flies in this time at `max_speed`, s.
    Times below the flight controller's lag make it swing.
    """
    lag: float = limited(0.0, 0.0, 5.0)
    """The velocity, vertical too, follows a command with this time constant, s. The UAV then brakes so much
    earlier, and does not overshoot. 0: as if it followed at once.
    """

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.braking_deceleration > self.max_acceleration:
            raise ParameterError(
                f"braking_deceleration is {self.braking_deceleration} m/s^2, above max_acceleration "
                f"({self.max_acceleration} m/s^2); lower the one or raise the other."
            )


@dataclass(frozen=True)
class PositionCommand:
    """Answer to one pose.

    Attributes:
        velocity_m_s: (x, y, z) in the levelled body frame: rotated from the pose's frame by yaw only.
        goal_reached: Whether the setpoint is reached (False without one).
    """

    velocity_m_s: Vector3
    goal_reached: bool


TRUST_S = 0.3
"""A measured velocity counts fully after this time. Single ones are noisy: poses come often."""

STOP = PositionCommand((0.0, 0.0, 0.0), goal_reached=False)


class VelocityObserver:
    """Follows the commands with the UAV's lag, and is drawn to what the poses tell (Luenberger)."""

    def __init__(self) -> None:
        self._velocity_m_s: Vector3 = (0.0, 0.0, 0.0)
        self._position_m: Sequence[float] | None = None

    def update(
        self, position_m: Sequence[float], commanded_m_s: Vector3, step_s: float, lag_s: float
    ) -> Vector3:
        """Return the velocity at a pose, x, y, z in m/s.

        commanded_m_s: since the last pose, step_s ago. lag_s: with which the UAV follows commands.
        """
        before_m, self._position_m = self._position_m, tuple(position_m)
        if before_m is None or step_s <= 0.0:
            return self._velocity_m_s
        follows, believes = (1.0 - math.exp(-step_s / time_s) for time_s in (lag_s, TRUST_S))
        speeds = []
        for axis in range(3):
            speed = self._velocity_m_s[axis]
            speed += follows * (commanded_m_s[axis] - speed)
            measured = (position_m[axis] - before_m[axis]) / step_s
            speeds.append(speed + believes * (measured - speed))
        self._velocity_m_s = speeds[0], speeds[1], speeds[2]
        return self._velocity_m_s


class PositionController:
    """Answers each pose with one command. The time step comes from the stamps of the poses.

    The commanded velocity starts at zero. Its acceleration is limited. Without `lag` the controller ignores
    the UAV's own velocity. Without a setpoint the velocity is zero: hover.
    """

    def __init__(self, parameters: PositionControllerParameters | None = None):
        self.parameters = parameters or PositionControllerParameters()
        self.setpoint_m: Vector3 | None = None
        """The (x, y, z) to go to, in the poses' frame, or None."""
        self._last_setpoint_m: Vector3 | None = None
        self._leg: Leg | None = None
        self.reset()

    def set_setpoint(self, position_m: Sequence[float]) -> None:
        """Go to `position_m` (x, y, z) in the poses' frame.

        Raises:
            PoseError: a coordinate is not finite, or beyond all reason; the old setpoint stays.
        """
        x, y, z = map(float, position_m)
        setpoint_m = (x, y, z)
        if not all(math.isfinite(coordinate) for coordinate in setpoint_m):
            raise PoseError("The position setpoint has a coordinate that is not finite; it is ignored.")
        if max(map(abs, setpoint_m)) > FARTHEST_M:
            raise PoseError(
                f"The position setpoint has a coordinate beyond {FARTHEST_M:.0e} m; it is ignored."
            )
        if setpoint_m != self.setpoint_m:
            self._last_setpoint_m, self.setpoint_m = self.setpoint_m, setpoint_m
            self._leg = None
            self._goal_reached = False

    def hover(self) -> None:
        """Obey no setpoint any more."""
        self._last_setpoint_m = self.setpoint_m = self._leg = None
        self._goal_reached = False

    def reset(self) -> None:
        """Start anew from rest, as after a clock that jumped back. The setpoint stays."""
        self._stamp_s: float | None = None
        self._velocity_m_s = (0.0, 0.0, 0.0)  # in the poses' frame
        self._observer = VelocityObserver()
        self._goal_reached = False

    def update(self, stamp_s: float, position_m: Sequence[float], yaw_rad: float) -> PositionCommand:
        """Return the command for a pose. A pose that is older than the last one starts anew from rest.

        Args:
            stamp_s: The pose's time.
            position_m: (x, y, z) in the setpoint's frame.
            yaw_rad: Heading in that frame.

        Raises:
            PoseError: a value is not finite; the state is then as before.
        """
        if not all(map(math.isfinite, (stamp_s, yaw_rad, *position_m))):
            raise PoseError("The pose has a value that is not finite.")
        if self._stamp_s is not None and stamp_s < self._stamp_s:
            self.reset()
        step_s = 0.0 if self._stamp_s is None else min(stamp_s - self._stamp_s, MAX_TIME_STEP_S)
        self._stamp_s = stamp_s
        if self.setpoint_m is None:
            self._velocity_m_s = (0.0, 0.0, 0.0)
        else:
            stop_m = self._rest_m(position_m, step_s)
            self._velocity_m_s = self._step_towards(self._error_m(stop_m), stop_m, step_s)
            self._goal_reached = self._is_reached(self._error_m(position_m))
        return PositionCommand(_level(self._velocity_m_s, yaw_rad), self._goal_reached)

    def _rest_m(self, position_m: Sequence[float], step_s: float) -> Sequence[float]:
        """Return where the UAV would come to rest if zero were commanded from now on."""
        lag_s = self.parameters.lag
        if lag_s <= 0.0:
            return position_m
        flown_m_s = self._observer.update(position_m, self._velocity_m_s, step_s, lag_s)
        return [here + lag_s * speed for here, speed in zip(position_m, flown_m_s)]

    def _error_m(self, position_m: Sequence[float]) -> Vector3:
        assert self.setpoint_m is not None
        (goal_x, goal_y, goal_z), (x, y, z) = self.setpoint_m, position_m
        return goal_x - x, goal_y - y, goal_z - z

    def _step_towards(self, error_m: Vector3, position_m: Sequence[float], step_s: float) -> Vector3:
        """Velocity after this step: the approach's velocity within the acceleration limits."""
        p = self.parameters
        distance_m = math.hypot(error_m[0], error_m[1])
        speed = approach_speed(distance_m, p.max_speed, p.braking_deceleration, p.gain)
        if p.lookahead > 0.0:
            velocity_x, velocity_y = self._along_leg(position_m, speed)
        else:
            scale = speed / distance_m if distance_m > 0.0 else 0.0
            velocity_x, velocity_y = error_m[0] * scale, error_m[1] * scale
        change_x = velocity_x - self._velocity_m_s[0]
        change_y = velocity_y - self._velocity_m_s[1]
        change = math.hypot(change_x, change_y)
        allowed = p.max_acceleration * step_s
        share = 1.0 if change <= allowed else allowed / change

        climb = approach_speed(
            abs(error_m[2]), p.max_vertical_speed, 0.5 * p.max_vertical_acceleration, p.vertical_gain
        )
        change_z = math.copysign(climb, error_m[2]) - self._velocity_m_s[2]
        allowed_z = p.max_vertical_acceleration * step_s
        return (
            self._velocity_m_s[0] + share * change_x,
            self._velocity_m_s[1] + share * change_y,
            self._velocity_m_s[2] + min(max(change_z, -allowed_z), allowed_z),
        )

    def _along_leg(self, position_m: Sequence[float], speed_m_s: float) -> tuple[float, float]:
        """Velocity (x, y) towards the place to aim at on the leg; slower while it still has to turn there."""
        assert self.setpoint_m is not None  # without one it hovers
        if self._leg is None:
            self._leg = Leg.of(self._last_setpoint_m, position_m, self.setpoint_m)
        way_x, way_y = self._leg.way(position_m, self.parameters.lookahead * self.parameters.max_speed)
        way_m = math.hypot(way_x, way_y)
        if way_m == 0.0:
            return 0.0, 0.0
        ahead_x, ahead_y = way_x / way_m, way_y / way_m
        velocity_x, velocity_y, _ = self._velocity_m_s
        flown_m_s = math.hypot(velocity_x, velocity_y)
        if flown_m_s > 0.0:
            speed_m_s *= max((velocity_x * ahead_x + velocity_y * ahead_y) / flown_m_s, 0.0)
        return speed_m_s * ahead_x, speed_m_s * ahead_y

    def _is_reached(self, error_m: Vector3) -> bool:
        (x, y, z), p = error_m, self.parameters
        distance_m = math.sqrt(x * x + y * y + z * z)
        margin_m = p.goal_hysteresis if self._goal_reached else 0.0
        return distance_m <= p.goal_tolerance + margin_m


def approach_speed(distance_m: float, max_speed_m_s: float, deceleration_m_s2: float, gain: float) -> float:
    """Speed at `distance_m` from the goal: proportional, then constant deceleration, then the limit.

    From a speed v beyond the proportional part, the distance to the goal is v^2 / (2 a) + a / (2 gain^2).
    """
    joint_m = deceleration_m_s2 / gain**2
    if distance_m <= joint_m:
        return min(gain * distance_m, max_speed_m_s)
    return min(math.sqrt(2.0 * deceleration_m_s2 * (distance_m - 0.5 * joint_m)), max_speed_m_s)


def _level(velocity_m_s: Vector3, yaw_rad: float) -> Vector3:
    """Turn a vector of the poses' frame into the levelled body frame."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y, z = velocity_m_s
    return (cos * x + sin * y, cos * y - sin * x, z)
