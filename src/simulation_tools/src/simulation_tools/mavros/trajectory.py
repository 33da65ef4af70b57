"""MAVROS's trajectories of setpoints: which point is sent when."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.geometry import Quaternion, Vector3, yaw_from_quaternion
from simulation_tools.mavros.conversions import (
    IGNORE_ACCELERATION,
    IGNORE_POSITION,
    IGNORE_VELOCITY,
    IGNORE_YAW,
    IGNORE_YAW_RATE,
    Target,
    position_target,
    require_finite,
)

_ZERO: Vector3 = (0.0, 0.0, 0.0)


class TrajectoryPoint(NamedTuple):
    """One setpoint in ENU, or FLU for the body frames. None: not given, so PX4 ignores it.

    wait_ms: see `TrajectoryClock`. yaw_rate: rad/s.
    """

    wait_ms: int
    position: Vector3 | None = None
    orientation_xyzw: Quaternion | None = None
    velocity: Vector3 | None = None
    yaw_rate: float = 0.0
    acceleration: Vector3 | None = None


def trajectory_target(
    target: Target, time_boot_ms: int, frame: int, point: TrajectoryPoint
) -> common.MAVLink_message:
    """Build SET_POSITION_TARGET_LOCAL_NED from a point; raises ValueError as `position_target` does.

    MAVROS does not turn the yaw rate to NED: a positive one turns clockwise.
    """
    mask, yaw = 0, 0.0
    if point.position is None or point.orientation_xyzw is None:
        mask |= IGNORE_POSITION | IGNORE_YAW
    else:
        require_finite(point.orientation_xyzw)
        yaw = yaw_from_quaternion(point.orientation_xyzw)
    if point.velocity is None:
        mask |= IGNORE_VELOCITY | IGNORE_YAW_RATE
    if point.acceleration is None:
        mask |= IGNORE_ACCELERATION
    return position_target(
        target,
        time_boot_ms,
        frame,
        mask,
        point.position or _ZERO,
        point.velocity or _ZERO,
        point.acceleration or _ZERO,
        yaw,
        -point.yaw_rate,
    )


class TrajectoryClock:
    """Says which points of a trajectory are due. Times are the flight controller's, ms.

    MAVROS reads each point's time_from_start as a waiting time. It waits for that of the first point before
    the first one goes out. Then it waits for a point's time before the point after it goes out.
    """

    def __init__(self) -> None:
        self._points: deque[TrajectoryPoint] = deque()
        self._due_ms: int | None = None  # of the first of them; None: not counted yet

    @property
    def is_running(self) -> bool:
        """Whether a point is still to be sent."""
        return bool(self._points)

    def start(self, points: Sequence[TrajectoryPoint]) -> None:
        """Begin a trajectory in the place of the present one. Time counts from the next call of `due`."""
        self._points = deque(points)
        self._due_ms = None

    def stop(self) -> None:
        """Forget what is not sent yet."""
        self._points.clear()

    def due(self, now_ms: int) -> list[TrajectoryPoint]:
        """Return the points that are to be sent now, in their order."""
        found: list[TrajectoryPoint] = []
        if self._points and self._due_ms is None:
            self._due_ms = now_ms + self._points[0].wait_ms
        while self._points and self._due_ms is not None and now_ms >= self._due_ms:
            found.append(self._points.popleft())
            self._due_ms += found[-1].wait_ms
        return found
