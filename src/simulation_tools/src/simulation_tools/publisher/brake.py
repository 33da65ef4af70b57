"""Stops a UAV that has lost its external pose: plans its way to a standstill, and commands what flies it.

PX4's velocity controller alone stops slowly: its response to a step takes a second. A command against the
motion is faster. But the UAV rights itself as slowly as it leans, so such a command swings it back if it
lasts until the UAV stands.

So the plan ends at rest and level. Its velocity is the cubic with the least jerk, and the command is the one
that makes PX4 fly it. With v, a and j, the planned velocity, acceleration and jerk, PX4 leans for

    q = P (command - v) + I - D a

after a delay and a lag. So the command looks ahead by the delay, and asks for a + lag j. PX4's poses go on
for some seconds by its IMU. They tell how far the UAV is off its plan.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from simulation_tools.geometry import Pose, Vector3, rotate
from simulation_tools.publisher.history import History
from simulation_tools.publisher.interface import PublisherParameters

_NS = 1e-9
_GRAVITY_M_S2 = 9.81
_P_1_S, _D = 1.8, 0.2
"""PX4's MPC_XY_VEL_P_ACC and MPC_XY_VEL_D_ACC."""
_DELAY_S, _LAG_S = 0.085, 0.11
"""From a command to the lean. Chosen with the next two and brake_time_s in flights of the stand-in."""
_DRAG_1_S = 0.28
"""The integral I holds this acceleration for each m/s, against the air, and keeps it while the UAV stops."""
_FEEDBACK = 0.9
_LASTS_S = 1.0
"""After this the command is zero, whatever the UAV does."""
_WINDOW_S = 0.06
"""Time between the two poses that give the velocity."""
_OLDEST_S = 0.2
"""The newer one must not be older."""
_TURN_S = 0.05
"""So long the UAV turns on as before."""
STANDSTILL: Vector3 = (0.0, 0.0, 0.0)


class Brake:
    """Commands the velocities of one stop, in the levelled body frame (FLU).

    now_ns: time at which the loss was noticed. poses: of the flight controller, they go on. Without two of
    them the UAV is taken to stand.
    """

    def __init__(self, now_ns: int, poses: History, p: PublisherParameters) -> None:
        self._poses, self._p, self._began_ns = poses, p, now_ns
        self._stops: tuple[_Stop, ...] = ()
        motion = self._motion(now_ns)
        velocity_m_s = motion.velocity_at(now_ns) if motion else (0.0, 0.0)
        speed_m_s = math.hypot(*velocity_m_s)
        if motion and speed_m_s > p.hold_speed_m_s:
            lasts_s = max(p.brake_time_s, 1.5 * speed_m_s / p.brake_acceleration_m_s2)
            pairs = zip(velocity_m_s, motion.lean_m_s2)
            self._stops = tuple(_Stop(v, lean - _DRAG_1_S * v, lasts_s) for v, lean in pairs)

    def velocity(self, now_ns: int) -> Vector3:
        """Return the velocity to command."""
        since_s = (now_ns - self._began_ns) * _NS
        motion = self._motion(now_ns) if self._stops and since_s < _LASTS_S else None
        if motion is None:
            return STANDSTILL
        x, y = (stop.command(since_s, v) for stop, v in zip(self._stops, motion.velocity_at(now_ns)))
        share = min(1.0, self._p.brake_speed_m_s / max(math.hypot(x, y), 1e-9))
        yaw_rad = motion.yaw_at(now_ns + _TURN_S / _NS)
        cos, sin = share * math.cos(yaw_rad), share * math.sin(yaw_rad)
        return (cos * x + sin * y, cos * y - sin * x, 0.0)

    def _motion(self, now_ns: int) -> _Motion | None:
        newest_ns = self._poses.stamp_at(now_ns - self._p.brake_pose_age_s / _NS)
        if newest_ns is None or (now_ns - newest_ns) * _NS > _OLDEST_S:
            return None
        found = self._poses.at_each((newest_ns - _WINDOW_S / _NS, newest_ns))
        return _Motion(*found) if len(found) == 2 else None


class _Stop(NamedTuple):
    """The plan of one horizontal axis: from a velocity and an acceleration to zero of both."""

    velocity_m_s: float
    acceleration_m_s2: float
    lasts_s: float

    def at(self, since_s: float) -> tuple[float, float, float]:
        """Return velocity, acceleration and jerk."""
        v, a, end = self.velocity_m_s, self.acceleration_m_s2, self.lasts_s
        if since_s >= end:
            return 0.0, 0.0, 0.0
        t, c2, c3 = since_s, -(3 * v + 2 * a * end) / end**2, (2 * v + a * end) / end**3
        return v + a * t + c2 * t**2 + c3 * t**3, a + 2 * c2 * t + 3 * c3 * t**2, 2 * c2 + 6 * c3 * t

    def command(self, since_s: float, measured_m_s: float) -> float:
        """Return the velocity to command in m/s."""
        v, a, j = self.at(since_s + _DELAY_S)
        unheld = _DRAG_1_S * (v - self.velocity_m_s)  # the integral holds what the first velocity needed
        off_m_s = self.at(since_s)[0] - measured_m_s
        return v + (a + _LAG_S * j + unheld + _D * a) / _P_1_S + _FEEDBACK * off_m_s


class _Motion(NamedTuple):
    """What two stamped poses of the flight controller tell."""

    before: tuple[int, Pose]
    here: tuple[int, Pose]

    @property
    def lean_m_s2(self) -> tuple[float, float]:
        """The horizontal acceleration by the lean, while the thrust carries the weight."""
        x, y, z = rotate(self.here[1].orientation_xyzw, (0.0, 0.0, 1.0))
        pull_m_s2 = _GRAVITY_M_S2 / max(z, 0.5)
        return pull_m_s2 * x, pull_m_s2 * y

    def velocity_at(self, at_ns: float) -> tuple[float, float]:
        """Return the horizontal velocity in m/s at a time, if the lean stays."""
        (before_ns, before), (here_ns, here) = self
        lasted_s, since_s = (here_ns - before_ns) * _NS, (at_ns - 0.5 * (before_ns + here_ns)) * _NS
        moved = zip(before.position_m, here.position_m, self.lean_m_s2)
        x, y = ((b - a) / lasted_s + since_s * lean for a, b, lean in moved)
        return x, y

    def yaw_at(self, at_ns: float) -> float:
        """Return the heading in rad at a time, if the turn goes on."""
        (before_ns, before), (here_ns, here) = self
        turned_rad = math.remainder(here.yaw_rad - before.yaw_rad, 2.0 * math.pi)
        return here.yaw_rad + turned_rad * (at_ns - here_ns) / (here_ns - before_ns)
