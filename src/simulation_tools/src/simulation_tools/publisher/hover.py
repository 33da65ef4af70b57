"""The hover point, and whether the UAV hovers there."""

from __future__ import annotations

import math

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.publisher.brake import Brake
from simulation_tools.publisher.history import History
from simulation_tools.publisher.interface import PublisherError, PublisherParameters, SendPosition

_NS = 1e-9
_SPEED_WINDOW_S = 0.2  # time between the two poses that give the speed


class _Lasting:
    """Measures how long a condition has been true."""

    def __init__(self) -> None:
        self._since_ns: int | None = None

    def lasts_s(self, now_ns: int, is_so: bool) -> float:
        """Take in whether it is true now. Return how long it has been true; negative: it is false."""
        if not is_so:
            self._since_ns = None
            return -1.0
        if self._since_ns is None:
            self._since_ns = now_ns
        return (now_ns - self._since_ns) * _NS


class Hover:
    """Holds a point and a heading, or nothing. It uses only poses that have surely arrived.

    `point`: position (ENU, m) and heading (rad from east); None: there is no hover point.
    """

    def __init__(self, poses: History) -> None:
        self._poses = poses
        self._hold_nothing()

    def _hold_nothing(self) -> None:
        self.point: tuple[Vector3, float] | None = None
        self._aims_above = False
        self._close, self._settled = _Lasting(), _Lasting()

    def release(self) -> None:
        """Give up the hover point."""
        if self.point is not None:  # each command to fly comes here
            self._hold_nothing()

    def hold(self, pose: Pose) -> None:
        """Hold the position of a pose from now on."""
        self.release()
        self.point = (pose.position_m, pose.yaw_rad)

    @property
    def _held(self) -> tuple[Vector3, float]:
        if self.point is None:
            raise PublisherError("the publisher holds no hover point")
        return self.point

    def climb_over(self, pose: Pose, least_z_m: float) -> None:
        """Hold the place of a pose, no lower than a height, and climb there as in a take-off."""
        self.release()
        x, y, z = pose.position_m
        self.point = ((x, y, max(z, least_z_m)), pose.yaw_rad)
        self._aims_above = True

    def setpoint(self, now_ns: int, stamp_ns: int, p: PublisherParameters) -> SendPosition:
        """Return the setpoint for the point.

        During a climb it lies above the point by a multiple of the missing height.
        """
        (x, y, z), yaw = self._held
        if self._aims_above:
            missing_m = z - self._here(now_ns, p).position_m[2]
            z += min(max(p.climb_gain * missing_m, 0.0), p.hover_height_m)
        return SendPosition(stamp_ns, (x, y, z), yaw)

    def reached(self, now_ns: int, p: PublisherParameters) -> bool:
        """Return whether the UAV hovers: close to the point for a moment, or near it for longer."""
        slow = self.speed_m_s(now_ns, p) <= p.ready_speed_m_s
        distance_m = self.distance_m(now_ns, p)
        close_s = self._close.lasts_s(now_ns, slow and distance_m <= p.ready_distance_m)
        settled_s = self._settled.lasts_s(now_ns, slow and distance_m <= p.settled_distance_m)
        return close_s >= p.ready_time_s or settled_s >= p.settled_time_s

    def distance_m(self, now_ns: int, p: PublisherParameters) -> float:
        """Return the UAV's distance from the point."""
        return math.dist(self._here(now_ns, p).position_m, self._held[0])

    def brake(self, now_ns: int, p: PublisherParameters) -> Brake:
        """Return how to stop without an external pose from now on."""
        return Brake(now_ns, self._poses, p)

    def speed_m_s(self, now_ns: int, p: PublisherParameters) -> float:
        """Return the UAV's mean speed over the last 0.2 s; infinity if it is unknown."""
        before = self._poses.at(now_ns - (p.decision_delay_s + _SPEED_WINDOW_S) / _NS)
        if before is None:
            return math.inf
        return math.dist(self._here(now_ns, p).position_m, before.position_m) / _SPEED_WINDOW_S

    def _here(self, now_ns: int, p: PublisherParameters) -> Pose:
        """Return the pose by which is decided. A late command may tell a time before the first pose."""
        return self._poses.at_or_oldest(now_ns - p.decision_delay_s / _NS)
