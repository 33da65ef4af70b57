"""The velocity and the heading along a route, as PX4's flight task for automatic modes asks for them.

The vehicle slows down before a corner so far that it can round it within the acceptance radius. While it
turns, it steers to a point of the line ahead. Off the line it returns to the line first.
"""

from __future__ import annotations

import enum
import math
from typing import Sequence

import numpy as np

from simulation_tools.px4.control.trajectory import speed_that_stops_within
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.waypoints import Kind, Route, Waypoint

_TURNING_COSINE, _TURNING_SPEED_M_S = 0.98, 0.2
_LEAD_M = 5.0  # the least distance to the point of the line that a turning vehicle steers to
_SMALL_M_S = 0.5  # speeds below it are clamped axis by axis
_ALONG_SPEED_M_S, _ALONG_DISTANCE_M = 0.1, 2.0  # for a heading along the velocity


class _Side(enum.Enum):
    """Where the vehicle is, beside the line from the previous waypoint to the current one."""

    ON_LINE = 0
    PAST_TARGET = 1
    BEFORE_PREVIOUS = 2
    OFF_LINE = 3


class YawMode(enum.IntEnum):
    """The values of MPC_YAW_MODE."""

    TO_WAYPOINT = 0
    TO_HOME = 1
    FROM_HOME = 2
    ALONG = 3
    TO_WAYPOINT_FIRST = 4


class PathFollower:
    """Follows a route with the reference point of the navigator. Positions in NED, (3,)."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.start()

    def start(self) -> None:
        """Forget the route."""
        self._route = Route(Waypoint(Kind.IDLE, np.zeros(3), math.nan, 0.0))
        self._side = _Side.ON_LINE
        self._previous = self._target = self._next = np.zeros(3)
        self._started_at = np.zeros(3)
        self._speed_before_turn_m_s = 0.0
        self._locked_yaw_rad: float | None = None

    def follow(self, route: Route, position: np.ndarray) -> None:
        """Take in the route and where the vehicle is."""
        is_new = route is not self._route
        if is_new:
            self._route = route
            self._started_at = position.copy()
        side = self._side_of(route, position)
        if is_new or side is not self._side or side is _Side.OFF_LINE:
            self._side = side
            self._locked_yaw_rad = None
            self._aim(route, position)

    def velocity(
        self, reference: np.ndarray, velocity: np.ndarray, cruise_m_s: float, climb: tuple[float, float]
    ) -> np.ndarray:
        """Return the wanted velocity of the reference point, which moves with `velocity`.

        climb: greatest speed and acceleration towards the target's height.
        """
        p, route = self._parameters, self._route
        speed = self._speed_to_target(reference, cruise_m_s)
        gap = self._target - reference
        is_turning = self._is_turning(gap, velocity, route.current.radius_m)
        if is_turning:
            speed = min(self._speed_before_turn_m_s, speed)
            ahead = self._point_ahead(reference, route.current.radius_m)
            gap = np.array([ahead[0] - reference[0], ahead[1] - reference[1], gap[2]])
        else:
            self._speed_before_turn_m_s = speed
        if route.current.kind is Kind.LAND:
            gap[2] = 0.0
        rise = speed_that_stops_within(abs(self._target[2] - reference[2]), climb[1], p["MPC_JERK_AUTO"])
        rise = min(rise, climb[0])
        length = float(np.linalg.norm(gap))
        if length < 1e-6:
            return np.zeros(3)
        wanted = gap / length * math.hypot(speed, rise)
        _clamp(wanted, slice(0, 2), speed)
        _clamp(wanted, slice(2, 3), rise)
        return wanted

    def yaw_rad(
        self, yaw_rad: float, position: np.ndarray, home: np.ndarray, velocity: Sequence[float]
    ) -> float:
        """Return the heading to turn to: MPC_YAW_MODE's; within the acceptance radius the present one.

        yaw_rad: the present heading; velocity: of the reference point.
        """
        mode = YawMode(int(self._parameters["MPC_YAW_MODE"]))
        if mode is YawMode.ALONG:
            far = math.hypot(*(self._target - position)[:2].tolist()) > _ALONG_DISTANCE_M
            moves = math.hypot(velocity[0], velocity[1]) > _ALONG_SPEED_M_S
            return math.atan2(velocity[1], velocity[0]) if far and moves else math.nan
        towards = {YawMode.TO_HOME: home - position, YawMode.FROM_HOME: position - home}.get(
            mode, self._target - position
        )
        north, east = towards[:2].tolist()
        if self._locked_yaw_rad is None:
            if math.hypot(north, east) >= self._route.current.radius_m:
                return math.atan2(east, north)
            self._locked_yaw_rad = yaw_rad
        return self._locked_yaw_rad

    def _side_of(self, route: Route, position: np.ndarray) -> _Side:
        start, target = self._line(route)
        line, so_far = _unit(target - start), position[:2] - start
        if line @ (target - position[:2]) < 0.0:
            return _Side.PAST_TARGET
        radius_m = route.current.radius_m
        if line @ so_far < 0.0 and np.linalg.norm(so_far) > radius_m:
            return _Side.BEFORE_PREVIOUS
        aside = so_far - line * (line @ so_far)
        return _Side.OFF_LINE if np.linalg.norm(aside) > radius_m else _Side.ON_LINE

    def _line(self, route: Route) -> tuple[np.ndarray, np.ndarray]:
        start = self._started_at if route.previous is None else route.previous
        return start[:2], route.current.place[:2]

    def _aim(self, route: Route, position: np.ndarray) -> None:
        """Set the target, and the places before and after it."""
        target = route.current.place
        previous = self._started_at if route.previous is None else route.previous
        after = target if route.next is None else route.next
        if self._side is _Side.ON_LINE:
            self._previous, self._target, self._next = previous, target, after
        elif self._side is _Side.PAST_TARGET:
            self._previous, self._target, self._next = position.copy(), target, after
        elif self._side is _Side.BEFORE_PREVIOUS:
            self._previous, self._target, self._next = position.copy(), previous, target
        else:
            start, _ = self._line(route)
            line = _unit(target[:2] - start)
            closest = start + line * (line @ (position[:2] - start))
            self._previous, self._next = position.copy(), target
            self._target = np.array([*closest, target[2]])

    @staticmethod
    def _is_turning(gap: np.ndarray, velocity: np.ndarray, radius_m: float) -> bool:
        speed, distance = np.linalg.norm(velocity[:2]), np.linalg.norm(gap[:2])
        if speed <= _TURNING_SPEED_M_S or distance <= radius_m:
            return False
        return bool(velocity[:2] @ gap[:2] < _TURNING_COSINE * speed * distance)

    def _point_ahead(self, reference: np.ndarray, radius_m: float) -> np.ndarray:
        """Return the point of the line that lies a lead away, north and east."""
        start = self._previous[:2]
        line = _unit(self._target[:2] - start)
        closest = start + line * (line @ (reference[:2] - start))
        lead_m, aside_m = max(radius_m, _LEAD_M), float(np.linalg.norm(closest - reference[:2]))
        return closest + math.sqrt(max(lead_m**2 - aside_m**2, 0.0)) * line

    def _speed_to_target(self, reference: np.ndarray, cruise_m_s: float) -> float:
        """Return the speed that lets the vehicle round the target and still stop at the place after it."""
        exit_speed = self._speed_to(self._target, self._next, self._next, 0.0, cruise_m_s)
        return self._speed_to(reference, self._target, self._next, exit_speed, cruise_m_s)

    def _speed_to(
        self,
        start: np.ndarray,
        target: np.ndarray,
        after: np.ndarray,
        exit_speed_m_s: float,
        cruise_m_s: float,
    ) -> float:
        p = self._parameters
        radius_m = self._route.current.radius_m
        acceleration, level_m = p["MPC_ACC_HOR"], p["NAV_MC_ALT_RAD"]
        leg_m = float(np.linalg.norm((after - target)[:2]))
        is_level = abs(target[2] - start[2]) < level_m and abs(after[2] - target[2]) < level_m
        at_target = 0.0
        if leg_m > 0.001 and leg_m >= radius_m and is_level:
            cosine = float(_unit((target - start)[:2]) @ _unit((target - after)[:2]))
            opening = math.acos(min(max(cosine, -1.0), 1.0))
            tangent = math.tan(0.5 * min(opening, math.pi - 1e-6))
            # Around a circle that touches both legs at a radius from the corner.
            in_turn = math.sqrt(p["MPC_XY_TRAJ_P"] * acceleration * radius_m * tangent)
            at_target = min(in_turn, exit_speed_m_s, cruise_m_s)
        distance_m = float(np.linalg.norm((start - target)[:2]))
        most = speed_that_stops_within(distance_m, acceleration, p["MPC_JERK_AUTO"], at_target)
        return min(cruise_m_s, most)


def _unit(vector: np.ndarray) -> np.ndarray:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-6 else np.zeros_like(vector)


def _clamp(vector: np.ndarray, axes: slice, most: float) -> None:
    """Shorten a vector so that its part along some axes is at most as long; small parts alone."""
    part = float(np.linalg.norm(vector[axes]))
    if part <= most:
        return
    if part < _SMALL_M_S and most < _SMALL_M_S:
        vector[axes] *= most / part
    else:
        vector *= most / part
