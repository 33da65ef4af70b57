"""The point at which the UAV is to hover, and whether it does."""

from __future__ import annotations

import math

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.publisher.history import History
from simulation_tools.publisher.interface import PublisherParameters, SendPosition

_NS = 1e-9
_SPEED_WINDOW_S = 0.2  # poses this far apart tell the speed


class Hover:
    """Holds a point and a heading, or nothing; judges by the poses that have surely arrived.

    `point`: position (ENU, m) and heading (rad from east); None: nothing is held.
    """

    def __init__(self, poses: History) -> None:
        self._poses = poses
        self.release()

    def release(self) -> None:
        """Hold nothing from now on."""
        self.point: tuple[Vector3, float] | None = None
        self._aims_above = False
        self._reached_ns: int | None = None

    def hold(self, pose: Pose) -> None:
        """Hold the position of a pose from now on."""
        self.release()
        self.point = (pose.position_m, pose.yaw_rad)

    def climb_over(self, pose: Pose, least_z_m: float) -> None:
        """Hold the place of a pose from now on, no lower than a height; to be flown as a take-off is."""
        self.release()
        x, y, z = pose.position_m
        self.point = ((x, y, max(z, least_z_m)), pose.yaw_rad)
        self._aims_above = True

    def setpoint(self, now_ns: int, stamp_ns: int, p: PublisherParameters) -> SendPosition:
        """Return the point; after a climb, above it by a multiple of what is missing to it."""
        (x, y, z), yaw = self.point
        if self._aims_above:
            missing_m = z - self._poses.at(now_ns - p.decision_delay_s / _NS).position_m[2]
            z += min(max(p.climb_gain * missing_m, 0.0), p.hover_height_m)
        return SendPosition(stamp_ns, (x, y, z), yaw)

    def reached(self, now_ns: int, p: PublisherParameters) -> bool:
        """Tell whether the UAV has been at the point and slow for `ready_time_s`."""
        here = self._poses.at(now_ns - p.decision_delay_s / _NS)
        near = math.dist(here.position_m, self.point[0]) <= p.ready_distance_m
        if not (near and self.speed_m_s(now_ns, p) <= p.ready_speed_m_s):
            self._reached_ns = None
        elif self._reached_ns is None:
            self._reached_ns = now_ns
        return self._reached_ns is not None and (now_ns - self._reached_ns) * _NS >= p.ready_time_s

    def speed_m_s(self, now_ns: int, p: PublisherParameters) -> float:
        """Return the UAV's mean speed of late; infinity when it is not known."""
        then_ns = now_ns - p.decision_delay_s / _NS
        here, before = self._poses.at(then_ns), self._poses.at(then_ns - _SPEED_WINDOW_S / _NS)
        if before is None:
            return math.inf
        return math.dist(here.position_m, before.position_m) / _SPEED_WINDOW_S
