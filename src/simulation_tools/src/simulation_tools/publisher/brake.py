"""Stops a UAV that has lost its external pose: a velocity against its motion, then a velocity of zero.

PX4's velocity controller alone stops slowly. Its response to a step takes a second, and its integrator still
holds the lean that the flight needed. A short command against the motion ends both sooner. But the UAV rights
itself as slowly as it leans: a command that lasts until it stands swings it back.

PX4 still knows its motion from its IMU, and its poses go on. So the brake looks ahead: to the velocity that
the UAV will have when it has righted itself, if it begins now. It commands against that velocity for as long
as it does not point back. A heavy UAV that leans slowly is so braked for longer. The integrator is left with
a push along the old motion; the brake works against that, too, but with less force.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from simulation_tools.geometry import Pose, Vector3, rotate
from simulation_tools.publisher.history import History
from simulation_tools.publisher.interface import PublisherParameters

_NS = 1e-9
_GRAVITY_M_S2 = 9.81
_WINDOW_S = 0.1
"""Time between the two poses that give the velocity."""
_OLDEST_S = 0.2
"""The newer one must not be older."""
_IN_TIME_S = 0.12
"""A brake that begins by then need not be harder."""
_TURN_S = 0.05
"""So long the UAV turns on as before."""
STANDSTILL: Vector3 = (0.0, 0.0, 0.0)


class _Motion(NamedTuple):
    """Horizontal, in the local frame: velocity at a time, acceleration, heading at the newest pose."""

    at_ns: float
    velocity_m_s: tuple[float, float]
    acceleration_m_s2: tuple[float, float]
    yaw_at: tuple[float, float, float]  # rad, rad/s, ns

    def velocity_at(self, at_ns: float) -> tuple[float, float]:
        since_s = (at_ns - self.at_ns) * _NS
        (x, y), (ax, ay) = self.velocity_m_s, self.acceleration_m_s2
        return x + since_s * ax, y + since_s * ay


class Brake:
    """Commands the velocities of one stop, in the levelled body frame (FLU).

    now_ns: time at which the loss was noticed. blind_s: for how long no external pose had come then; a late
    brake is a harder one. poses: of the flight controller, they go on. Without two of them the UAV is taken
    to stand.
    """

    def __init__(self, now_ns: int, blind_s: float, poses: History, p: PublisherParameters) -> None:
        self._poses, self._p = poses, p
        self._gain = p.brake_gain + p.late_gain_per_s * max(0.0, blind_s - _IN_TIME_S)
        self._ends_ns = now_ns + p.brake_time_s / _NS
        motion = self._motion(now_ns)
        x, y = motion.velocity_at(now_ns) if motion else (0.0, 0.0)
        speed_m_s = math.hypot(x, y)
        faster = max(1.0, speed_m_s)
        self._hard_until_ns = now_ns + p.hard_time_s * faster / _NS
        self._lead_ns = p.brake_lead_s / faster / _NS
        if speed_m_s <= p.hold_speed_m_s:
            self._ends_ns = float(now_ns)
        self._ahead = x / max(speed_m_s, 1e-9), y / max(speed_m_s, 1e-9)  # of the motion, a unit vector

    def velocity(self, now_ns: int) -> Vector3:
        """Return the velocity to command. Call it in the order of time."""
        motion = self._motion(now_ns) if now_ns < self._ends_ns else None
        if motion is None:
            return STANDSTILL
        p = self._p
        x, y = motion.velocity_at(now_ns + self._lead_ns)
        backwards_m_s = -(x * self._ahead[0] + y * self._ahead[1])
        if backwards_m_s >= 0.0:  # nothing to brake but what is sideways
            x, y = x + backwards_m_s * self._ahead[0], y + backwards_m_s * self._ahead[1]
        gain = self._gain if now_ns < self._hard_until_ns else p.rest_gain
        factor = -min(gain, p.brake_speed_m_s / max(math.hypot(x, y), 1e-9))
        yaw_rad, turn_rad_s, seen_ns = motion.yaw_at
        yaw_rad += turn_rad_s * ((now_ns - seen_ns) * _NS + _TURN_S)
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        return (factor * (cos * x + sin * y), factor * (cos * y - sin * x), 0.0)

    def _motion(self, now_ns: int) -> _Motion | None:
        newest_ns = self._poses.stamp_at(now_ns - self._p.brake_pose_age_s / _NS)
        if newest_ns is None or (now_ns - newest_ns) * _NS > _OLDEST_S:
            return None
        found = self._poses.at_each((newest_ns - _WINDOW_S / _NS, newest_ns))
        if len(found) < 2:
            return None
        return _motion_between(*found)


def _motion_between(before: tuple[int, Pose], here: tuple[int, Pose]) -> _Motion:
    lasted_s = (here[0] - before[0]) * _NS
    x, y = ((b - a) / lasted_s for a, b in zip(before[1].position_m[:2], here[1].position_m[:2]))
    up = rotate(here[1].orientation_xyzw, (0.0, 0.0, 1.0))
    pull = _GRAVITY_M_S2 / max(up[2], 0.5)  # the thrust carries the weight
    turned_rad = math.remainder(here[1].yaw_rad - before[1].yaw_rad, 2.0 * math.pi)
    yaw_at = (here[1].yaw_rad, turned_rad / lasted_s, here[0])
    return _Motion(0.5 * (before[0] + here[0]), (x, y), (pull * up[0], pull * up[1]), yaw_at)
