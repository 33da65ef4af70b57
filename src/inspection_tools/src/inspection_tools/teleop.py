"""Reference velocities from a pilot: keys of a terminal, or the sticks of a joystick.

Both are dead man's switches: when no key is pressed or the joystick is silent, the UAV hovers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError

HOVER = (0.0, 0.0, 0.0)
FASTEST_M_S = 5.0
KEYS = """\
    u  i  o        ahead left   ahead   ahead right
    j  k  l        left         stop    right
    m  ,  .        back left    back    back right
    t / b          up / down            q / z   faster / slower"""

_DIAGONAL = math.sqrt(0.5)
_DIRECTIONS = {  # ahead, left, up
    "u": (_DIAGONAL, _DIAGONAL, 0.0),
    "i": (1.0, 0.0, 0.0),
    "o": (_DIAGONAL, -_DIAGONAL, 0.0),
    "j": (0.0, 1.0, 0.0),
    "k": HOVER,
    "l": (0.0, -1.0, 0.0),
    "m": (-_DIAGONAL, _DIAGONAL, 0.0),
    ",": (-1.0, 0.0, 0.0),
    ".": (-_DIAGONAL, -_DIAGONAL, 0.0),
    "t": (0.0, 0.0, 1.0),
    "b": (0.0, 0.0, -1.0),
}
_FACTORS = {"q": 1.1, "z": 1.0 / 1.1}


@dataclass(frozen=True)
class TeleopParameters:
    """Converts keys and sticks to velocities.

    Raises:
        ParameterError: a value out of range, or one axis for two directions.
    """

    speed: float = limited(1.0, 0.0, FASTEST_M_S)
    """Horizontal speed of a key or a full stick, m/s."""
    climb_speed: float = limited(0.5, 0.0, 2.0)
    """Vertical speed of a key or a full stick, m/s."""
    hold_time: float = limited(0.6, 0.05, 2.0)
    """A key counts as pressed for this long, s. This must be longer than the keyboard's delay before it
    repeats a held key. A joystick that is silent for longer counts as released.
    """
    axis_ahead: int = limited(1, 0, 31)
    """Axis of the joystick, positive ahead."""
    axis_left: int = limited(0, 0, 31)
    """Axis of the joystick, positive to the left."""
    axis_up: int = limited(4, 0, 31)
    """Axis of the joystick, positive up."""
    dead_zone: float = limited(0.1, 0.0, 0.9)
    """A stick moved by less than this share counts as released."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if len({self.axis_ahead, self.axis_left, self.axis_up}) < 3:
            raise ParameterError("axis_ahead, axis_left and axis_up must be three different axes.")


class KeyboardPilot:
    """Converts keys to velocities. Times are seconds of any monotonic clock."""

    def __init__(self, parameters: TeleopParameters | None = None):
        self._parameters = parameters or TeleopParameters()
        self._factor = 1.0
        self._direction = HOVER
        self._until_s = -math.inf

    @property
    def speed_m_s(self) -> float:
        """The horizontal speed of a key."""
        return min(self._factor * self._parameters.speed, FASTEST_M_S)

    def press(self, key: str, now_s: float) -> bool:
        """Take one key.

        For a key without a meaning stop the UAV and return False, because the pilot may panic.
        """
        if key in _FACTORS:
            self._factor = min(max(self._factor * _FACTORS[key], 0.05), 10.0)
            return True
        self._direction = _DIRECTIONS.get(key, HOVER)
        self._until_s = now_s + self._parameters.hold_time
        return key in _DIRECTIONS

    def velocity(self, now_s: float) -> tuple[float, float, float]:
        """Return the reference velocity (ahead, left, up), m/s."""
        if now_s > self._until_s:
            return HOVER
        ahead, left, up = self._direction
        return (self.speed_m_s * ahead, self.speed_m_s * left, self._parameters.climb_speed * up)


class JoystickPilot:
    """Converts sticks to velocities. Times are seconds of any monotonic clock."""

    def __init__(self, parameters: TeleopParameters | None = None):
        self._parameters = parameters or TeleopParameters()
        self._axes: Sequence[float] = ()
        self._until_s = -math.inf

    def move(self, axes: Sequence[float], now_s: float) -> None:
        """Take the sticks' positions, each -1 to 1.

        Raises:
            ParameterError: the joystick lacks an axis of the parameters. Its last positions are forgotten.
        """
        p = self._parameters
        self._until_s = -math.inf
        wanted = max(p.axis_ahead, p.axis_left, p.axis_up)
        if len(axes) <= wanted:
            raise ParameterError(
                f"The joystick has {len(axes)} axes, but axis {wanted} is wanted; change axis_ahead, "
                "axis_left or axis_up."
            )
        self._axes = axes
        self._until_s = now_s + p.hold_time

    def velocity(self, now_s: float) -> tuple[float, float, float]:
        """Return the reference velocity (ahead, left, up), m/s; horizontally at most `speed` in all."""
        if now_s > self._until_s:
            return HOVER
        p = self._parameters
        ahead, left, up = (self._moved(axis) for axis in (p.axis_ahead, p.axis_left, p.axis_up))
        share = p.speed / max(math.hypot(ahead, left), 1.0)
        return (share * ahead, share * left, p.climb_speed * up)

    def _moved(self, axis: int) -> float:
        """Return a stick's position beyond the dead zone, -1 to 1; 0 if it is NaN."""
        value, dead = self._axes[axis], self._parameters.dead_zone
        if not math.isfinite(value) or abs(value) <= dead:
            return 0.0
        return math.copysign((min(abs(value), 1.0) - dead) / (1.0 - dead), value)
