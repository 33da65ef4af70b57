"""Stops a UAV that has lost its pose: first a velocity against its own, then a velocity of zero.

PX4's velocity controller alone stops slowly. Its response to a step takes a second, and its integrator still
holds the lean that the flight needed. A short command against the motion ends both sooner.
"""

from __future__ import annotations

import math

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.publisher.interface import PublisherParameters

_NS = 1e-9
STANDSTILL: Vector3 = (0.0, 0.0, 0.0)


class Brake:
    """Commands the velocities of one stop, in the levelled body frame (FLU).

    now_ns: time of the loss. before, here: the last two known poses, lasted_s apart. The last one is older by
    decision_delay_s, in which a UAV that turns has turned on.
    """

    def __init__(
        self, now_ns: int, before: Pose | None, here: Pose, lasted_s: float, p: PublisherParameters
    ) -> None:
        self._ends_ns = float(now_ns)
        self._against = STANDSTILL
        if before is None:
            return
        x, y = ((a - b) / lasted_s for a, b in zip(here.position_m[:2], before.position_m[:2]))
        speed_m_s = math.hypot(x, y)
        if speed_m_s <= p.hold_speed_m_s:
            return
        share = min(1.0, p.brake_speed_m_s / (p.brake_gain * speed_m_s))
        self._ends_ns += p.brake_time_s / share / _NS
        factor = -p.brake_gain * share
        turned_rad = math.remainder(here.yaw_rad - before.yaw_rad, 2.0 * math.pi)
        yaw_rad = here.yaw_rad + turned_rad * p.decision_delay_s / lasted_s
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        self._against = (factor * (cos * x + sin * y), factor * (cos * y - sin * x), 0.0)

    def velocity(self, now_ns: int) -> Vector3:
        """Return the velocity to command."""
        return self._against if now_ns < self._ends_ns else STANDSTILL
