"""Stops a UAV that has lost its pose: first a velocity against its own, then a velocity of zero.

PX4's velocity controller alone stops slowly. Its response to a step takes a second, and its integrator still
holds the lean that the flight needed. A short command against the motion ends both sooner.

The last known poses are older than the command, and in a curve the velocity and the heading of that time are
not those of now. So the brake predicts both: with the acceleration between the last three poses, and with
the turn between the last two.
"""

from __future__ import annotations

import math
from typing import Sequence, Tuple

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.publisher.interface import PublisherParameters

_NS = 1e-9
_RESPONSE_S = 0.05
"""After a command PX4 first has to lean. So long the UAV flies and turns on as before."""
_ACCELERATION_MAX_M_S2 = 3.0
"""More is a jump of the estimate, not a curve."""
STANDSTILL: Vector3 = (0.0, 0.0, 0.0)
StampedPose = Tuple[int, Pose]


class Brake:
    """Commands the velocities of one stop, in the levelled body frame (FLU).

    now_ns: time of the loss. poses: up to three known ones with their stamps, the newest last. With two the
    UAV is taken to fly straight on, with fewer to stand.
    """

    def __init__(self, now_ns: int, poses: Sequence[StampedPose], p: PublisherParameters) -> None:
        self._ends_ns = float(now_ns)
        self._against = STANDSTILL
        if len(poses) < 2:
            return
        brakes_ns = now_ns + _RESPONSE_S / _NS
        x, y = _velocity(poses, brakes_ns)
        speed_m_s = math.hypot(x, y)
        if speed_m_s <= p.hold_speed_m_s:
            return
        share = min(1.0, p.brake_speed_m_s / (p.brake_gain * speed_m_s))
        self._ends_ns += p.brake_time_s * math.sqrt(min(1.0, speed_m_s)) / share / _NS
        factor = -p.brake_gain * share
        yaw_rad = _heading(poses, brakes_ns)
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        self._against = (factor * (cos * x + sin * y), factor * (cos * y - sin * x), 0.0)

    def velocity(self, now_ns: int) -> Vector3:
        """Return the velocity to command."""
        return self._against if now_ns < self._ends_ns else STANDSTILL


def _velocity(poses: Sequence[StampedPose], at_ns: float) -> tuple[float, float]:
    """Return the horizontal velocity in m/s at a time, if the acceleration between the poses goes on."""
    x, y = _mean_velocity(poses[0], poses[-1])
    if len(poses) < 3:
        return x, y
    before, after = _mean_velocity(*poses[:2]), _mean_velocity(*poses[1:])
    apart_s = 0.5 * (poses[2][0] - poses[0][0]) * _NS
    ax, ay = ((b - a) / apart_s for a, b in zip(before, after))
    since_s = (at_ns - 0.5 * (poses[0][0] + poses[2][0])) * _NS
    since_s *= min(1.0, _ACCELERATION_MAX_M_S2 / max(math.hypot(ax, ay), 1e-9))
    return x + ax * since_s, y + ay * since_s


def _mean_velocity(first: StampedPose, second: StampedPose) -> tuple[float, float]:
    lasted_s = (second[0] - first[0]) * _NS
    x, y = ((b - a) / lasted_s for a, b in zip(first[1].position_m[:2], second[1].position_m[:2]))
    return x, y


def _heading(poses: Sequence[StampedPose], at_ns: float) -> float:
    """Return the heading in rad at a time, if the turn between the last two poses goes on."""
    (before_ns, before), (here_ns, here) = poses[-2:]
    turned_rad = math.remainder(here.yaw_rad - before.yaw_rad, 2.0 * math.pi)
    return here.yaw_rad + turned_rad * (at_ns - here_ns) / (here_ns - before_ns)
