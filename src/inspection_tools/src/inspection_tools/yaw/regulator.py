"""Yaw rate that turns the front of the UAV towards its direction of travel (thesis, 5.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError, VelocityError

NO_VELOCITY = (0.0, 0.0)


@dataclass(frozen=True)
class YawRegulatorParameters:
    """Gain, limit and thresholds of the yaw regulator.

    Raises:
        ParameterError: a value out of range, or thresholds the wrong way round.
    """

    gain: float = limited(1.5, 0.0, 5.0)
    """Yaw rate per angle to the direction of travel, 1/s; 0 switches the regulator off."""
    front_gain: float = limited(2.5, 0.0, 5.0)
    """Yaw rate per angle where the front is to point to a given direction (`turn_to`), 1/s."""
    max_yaw_rate: float = limited(1.0, 0.0, 5.0)
    """Limit of the yaw rate, rad/s."""
    max_yaw_acceleration: float = limited(0.0, 0.0, 50.0)
    """Limit of every change of the yaw rate, rad/s^2; 0: none. Before an obstacle the direction of travel may
    change its side with each scan. Where a heavy multirotor followed with its yaw rate at once, its rotors
    had too little thrust left to carry it.
    """
    speed_on: float = limited(0.25, 0.01, 5.0)
    """The regulator switches on above this horizontal speed, m/s."""
    speed_off: float = limited(0.15, 0.0, 5.0)
    """The regulator switches off below this horizontal speed, m/s; less than `speed_on`."""
    turn_margin: float = limited(0.5, 0.0, 1.5)
    """The UAV keeps its sense of turn until the direction is this angle past the exact rear, rad. Otherwise
    noise would turn the UAV to and fro.
    """
    reference_max_age: float = limited(0.5, 0.0, 10.0)
    """An older reference velocity counts as none, s."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.speed_off >= self.speed_on:
            raise ParameterError(
                f"speed_off is {self.speed_off} m/s; it must be below speed_on ({self.speed_on} m/s)."
            )


class YawRegulator:
    """P-regulator of the angle between the UAV's front and its direction of travel.

    Its state consists of hystereses: moving or not, reference wanted or not, and the sense of turn.
    """

    def __init__(self, parameters: YawRegulatorParameters | None = None):
        self.parameters = parameters or YawRegulatorParameters()
        self.reset()

    def reset(self) -> None:
        """Forget the hystereses, as after a clock that jumped back."""
        self._moving = False
        self._looking = False
        self._sense = 0.0  # +1 turning left, -1 right, 0 not turning

    def update(self, velocity_m_s: Sequence[float], reference_m_s: Sequence[float] = NO_VELOCITY) -> float:
        """Return the yaw rate in rad/s, positive to the left.

        Args:
            velocity_m_s: (x, y) of the velocity that will be flown, levelled body frame.
            reference_m_s: (x, y) of the wanted velocity, same frame. If only the flown velocity is zero, the
                UAV turns on the spot towards the wanted one. The lidar may then see a free path.

        Raises:
            VelocityError: a component is not finite; the state is then as before.
        """
        if not all(map(math.isfinite, (*velocity_m_s, *reference_m_s))):
            raise VelocityError("The velocity has a component that is not finite.")
        self._moving = self._passes(math.hypot(*velocity_m_s), self._moving)
        self._looking = self._passes(math.hypot(*reference_m_s), self._looking)
        if self._moving:
            return self._turn_towards(velocity_m_s, self.parameters.gain)
        if self._looking:
            return self._turn_towards(reference_m_s, self.parameters.gain)
        self._sense = 0.0
        return 0.0

    def turn_to(self, direction: Sequence[float]) -> float:
        """Return the yaw rate in rad/s towards a direction (x, y), levelled body frame, at any velocity.

        Raises:
            VelocityError: a component is not finite; the state is then as before.
        """
        if not all(math.isfinite(value) for value in direction):
            raise VelocityError("The direction of the front has a component that is not finite.")
        self._moving = self._looking = False
        return self._turn_towards(direction, self.parameters.front_gain)

    def _passes(self, speed_m_s: float, was_on: bool) -> bool:
        return speed_m_s > (self.parameters.speed_off if was_on else self.parameters.speed_on)

    def _turn_towards(self, direction: Sequence[float], gain: float) -> float:
        p = self.parameters
        error_rad = math.atan2(direction[1], direction[0])
        if error_rad == -math.pi:  # atan2(-0.0, -1): at the exact rear turn left
            error_rad = math.pi
        past_rear = abs(error_rad) > math.pi - p.turn_margin and error_rad * self._sense < 0.0
        if past_rear:
            error_rad += 2.0 * math.pi * self._sense
        self._sense = math.copysign(1.0, error_rad)
        return min(max(gain * error_rad, -p.max_yaw_rate), p.max_yaw_rate)
