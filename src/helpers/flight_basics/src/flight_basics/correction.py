"""SLAM's correction (`odom` in `map`), followed slowly, so that a loop closure moves goals and not the UAV.

SLAM may move `odom` in `map` by metres in an instant. If the pose in `map` jumped with it, the commanded
velocity would jump, too. So the pose that a controller sees moves towards the corrected one at a limited
speed. To the UAV this looks as if its goal moved at that speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_basics.bounds import MAX_TIME_STEP_S
from flight_basics.checks import check_parameters, limited
from flight_basics.geometry import Quaternion, Vector3, yaw_of


@dataclass(frozen=True)
class CorrectionParameters:
    """How fast a change of the correction reaches the pose.

    Raises:
        ParameterError: a value out of range.
    """

    correction_speed: float = limited(0.15, 0.0, 10.0)
    """Speed at which a correction moves the UAV's position in the map, m/s. 0: the correction counts at once.
    """
    correction_turn_rate: float = limited(0.08, 1e-3, 10.0)
    """Rate at which a correction turns its heading, rad/s. Above 0."""

    def __post_init__(self) -> None:
        check_parameters(self)


class SlowCorrection:
    """Takes poses from `odom` to `map` by a correction that never jumps, except at the first pose.

    Attributes:
        whole: the last pose (position, yaw) with the whole correction. off_m, off_rad: what the answer
        lacked.
    """

    def __init__(self, parameters: CorrectionParameters | None = None) -> None:
        self._parameters = parameters or CorrectionParameters()
        self.reset()

    def reset(self) -> None:
        """Take the next correction as it is."""
        self._stamp_s: float | None = None
        self._shift_m: Vector3 = (0.0, 0.0, 0.0)
        self._turn_rad = 0.0
        self.whole: tuple[Vector3, float] = ((0.0, 0.0, 0.0), 0.0)
        self.off_m = self.off_rad = 0.0

    def apply(
        self, stamp_s: float, pose: tuple[Vector3, float], shift_m: Vector3, turn: Quaternion
    ) -> tuple[Vector3, float]:
        """Return position (x, y, z) and yaw in `map` of a pose (position, yaw) in `odom`.

        shift_m, turn: newest pose of `odom` in `map`. Of the turn only the yaw counts.
        """
        position_m, yaw_rad = pose
        p = self._parameters
        if self._stamp_s is None or stamp_s < self._stamp_s or p.correction_speed == 0.0:
            self._shift_m, self._turn_rad = shift_m, yaw_of(turn)
        else:
            step_s = min(stamp_s - self._stamp_s, MAX_TIME_STEP_S)
            here_m = _moved(position_m, self._shift_m, self._turn_rad)
            there_m = _moved(position_m, shift_m, yaw_of(turn))
            missing_rad = math.remainder(yaw_of(turn) - self._turn_rad, 2.0 * math.pi)
            most_rad = p.correction_turn_rate * step_s
            self._turn_rad += min(max(missing_rad, -most_rad), most_rad)
            missing_m = math.dist(here_m, there_m)
            share = min(1.0, p.correction_speed * step_s / missing_m) if missing_m > 0.0 else 1.0
            turned_m = _moved(position_m, (0.0, 0.0, 0.0), self._turn_rad)
            x, y, z = (a + share * (b - a) - c for a, b, c in zip(here_m, there_m, turned_m))
            self._shift_m = (x, y, z)
        self._stamp_s = stamp_s
        whole_m, whole_rad = _moved(position_m, shift_m, yaw_of(turn)), yaw_rad + yaw_of(turn)
        here_m, here_rad = _moved(position_m, self._shift_m, self._turn_rad), yaw_rad + self._turn_rad
        self.whole = whole_m, math.remainder(whole_rad, 2.0 * math.pi)
        self.off_m = math.dist(here_m, whole_m)
        self.off_rad = math.remainder(whole_rad - here_rad, 2.0 * math.pi)
        return here_m, math.remainder(here_rad, 2.0 * math.pi)


def _moved(position_m: Vector3, shift_m: Vector3, turn_rad: float) -> Vector3:
    """Return a position turned about z, then shifted."""
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    x, y, z = position_m
    return (cos * x - sin * y + shift_m[0], sin * x + cos * y + shift_m[1], z + shift_m[2])
