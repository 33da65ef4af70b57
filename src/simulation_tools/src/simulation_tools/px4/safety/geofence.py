"""PX4's geofence: the greatest distances from home, and the areas that a ground station uploaded.

Five times a second PX4 looks whether the vehicle could still stop inside. It assumes that the vehicle
accelerates at MPC_ACC_HOR_MAX now and then brakes. So it reacts some 5 m before the fence even at low speed.
The fence needs a place on earth: without GNSS there is none.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Callable, Sequence

import numpy as np

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.commander import Commander, Reposition
from simulation_tools.px4.control.trajectory import SmoothAxis
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Mode, Severity
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.items import Command, PlanItem
from simulation_tools.px4.plan.plan import Plan

_CHECK_PERIOD_US = 200_000
_WARNING_PERIOD_US = 5_000_000
_PRECISION_M = 0.5  # of the search for the fence ahead


class FenceAction(enum.IntEnum):
    """The values of GF_ACTION."""

    NONE = 0
    WARN = 1
    HOLD = 2
    RETURN = 3
    TERMINATE = 4
    LAND = 5


_MODES = {
    FenceAction.HOLD: Mode.AUTO_LOITER,
    FenceAction.RETURN: Mode.AUTO_RTL,
    FenceAction.LAND: Mode.AUTO_LAND,
}


@dataclass(frozen=True)
class Area:
    """A polygon (vertices), or a circle (one vertex and a radius), north and east in m."""

    is_inclusion: bool
    vertices: np.ndarray  # n x 2
    radius_m: float | None = None

    def holds(self, north_m: float, east_m: float) -> bool:
        """Whether a point lies within. A polygon counts crossings of a ray (Shimrat, CACM 1962)."""
        north, east = self.vertices[:, 0], self.vertices[:, 1]
        if self.radius_m is not None:
            return math.hypot(north[0] - north_m, east[0] - east_m) < self.radius_m
        before_north, before_east = np.roll(north, 1), np.roll(east, 1)
        spans = (east >= east_m) != (before_east >= east_m)
        run = np.where(spans, before_east - east, 1.0)
        crossing = north + (before_north - north) * (east_m - east) / run
        return bool(np.count_nonzero(spans & (north_m <= crossing)) % 2)


def areas_of(items: Sequence[PlanItem], origin: GeodeticOrigin) -> list[Area]:
    """Return the areas of a fence's items. A polygon of n vertices is n items with n as first parameter."""
    areas, i = [], 0
    while i < len(items):
        item = items[i]
        place = np.array([origin.to_local(item.x, item.y)])
        i += 1
        if item.command in (Command.FENCE_CIRCLE_INCLUSION, Command.FENCE_CIRCLE_EXCLUSION):
            areas.append(Area(item.command == Command.FENCE_CIRCLE_INCLUSION, place, item.params[0]))
        elif item.command != Command.FENCE_RETURN_POINT:
            rest = items[i : i + int(item.params[0] + 0.5) - 1]
            vertices = np.array([place[0], *(origin.to_local(other.x, other.y) for other in rest)])
            areas.append(Area(item.command == Command.FENCE_POLYGON_INCLUSION, vertices))
            i += len(rest)
    return areas


def is_inside(areas: Sequence[Area], north_m: float, east_m: float) -> bool:
    """Whether a point lies in one of the inclusions, if there are any, and in no exclusion."""
    inclusions = [area.holds(north_m, east_m) for area in areas if area.is_inclusion]
    excluded = any(area.holds(north_m, east_m) for area in areas if not area.is_inclusion)
    return (any(inclusions) or not inclusions) and not excluded


def stopping_distance(speed_m_s: float, limit_m_s2: float, most_m_s2: float, jerk_m_s3: float) -> float:
    """Return how far a vehicle gets that accelerates at `most` now and then brakes within the limits."""
    axis = SmoothAxis()
    axis.start(0.0, speed_m_s, most_m_s2)
    axis.advance(0.0, limit_m_s2, jerk_m_s3, sum(axis.durations(0.0, limit_m_s2, jerk_m_s3)[1:]))
    return axis.position + 1e-6 * _CHECK_PERIOD_US * speed_m_s


@dataclass(frozen=True)
class _Breach:
    """Which part of the fence is ahead."""

    distance: bool
    altitude: bool
    area: bool

    def __bool__(self) -> bool:
        return self.distance or self.altitude or self.area


class Geofence:
    """Watches the flight and, ahead of the fence, does what GF_ACTION says."""

    def __init__(
        self,
        parameters: Px4Parameters,
        plan: Plan,
        commander: Commander,
        origin: Callable[[], GeodeticOrigin],
        say: Say,
    ) -> None:
        """origin: returns where the local frame begins on earth."""
        self._parameters = parameters
        self._plan = plan
        self._commander = commander
        self._get_origin = origin
        self._say = say
        self._areas: list[Area] = []
        self._areas_key: object = None
        self.reset()

    def reset(self) -> None:
        """Forget what has been said and done."""
        self._now_us = self._checked_us = 0
        self._said_us: dict[str, int] = {}
        self._breached = self._warned = self._acted = False
        self._hold: Reposition | None = None

    @property
    def is_set(self) -> bool:
        """Whether there is any fence."""
        p = self._parameters
        return bool(self._plan.fence) or p["GF_MAX_HOR_DIST"] > 0.0 or p["GF_MAX_VER_DIST"] > 0.0

    def allows(self, position: Sequence[float]) -> bool:
        """Whether a place lies inside; NED, its height NaN for any."""
        north, east, down = position
        return not self._breach((north, east), down)

    def forbids(self, position: Sequence[float]) -> bool:
        """Whether the vehicle must not be sent to a place, NED."""
        return self._action not in (FenceAction.NONE, FenceAction.WARN) and not self.allows(position)

    def update(self, now_us: int, estimate: np.ndarray, battery_fails: bool) -> None:
        """Look ahead, and act when the fence comes near. estimate: record of ESTIMATE_DTYPE, shape (1,)."""
        self._now_us = now_us
        is_due = now_us - self._checked_us >= _CHECK_PERIOD_US
        if not (is_due or self._breached):
            self._acted = False
            return
        commander, action = self._commander, self._action
        if action is not FenceAction.NONE and is_due:
            self._checked_us = now_us
            self._check(estimate)
        if not commander.armed or action is FenceAction.NONE or battery_fails:
            self._acted = False
            return
        if self._breached and not self._acted:
            if action is FenceAction.TERMINATE and not commander.is_terminated:
                commander.terminate()
                self._say(Severity.CRITICAL, "Geofence violation! Flight terminated")
            elif action in _MODES:
                commander.take_over(_MODES[action], self._hold)
        self._acted = self._breached

    @property
    def _action(self) -> FenceAction:
        return FenceAction(int(self._parameters["GF_ACTION"]))

    def _check(self, estimate: np.ndarray) -> None:
        p = self._parameters
        if not self.is_set:
            self._breached = self._warned = False
            self._hold = None
            return
        position, velocity = estimate["position"][0].tolist(), estimate["velocity"][0].tolist()
        speed, climb = math.hypot(velocity[0], velocity[1]), -velocity[2]
        along = math.atan2(velocity[1], velocity[0])
        ahead_m = self._braking_m(speed)
        most = max(p["MPC_ACC_UP_MAX"], p["MPC_ACC_DOWN_MAX"])
        limit = p["MPC_ACC_DOWN_MAX" if climb > 0.0 else "MPC_ACC_UP_MAX"]
        rise_m = stopping_distance(abs(climb), limit, most, p["MPC_JERK_AUTO"])
        rise_m = math.copysign(rise_m, climb) if climb else 0.0
        ahead = _towards(position, along, ahead_m)
        breach = self._breach(ahead, position[2] - rise_m)
        self._breached = bool(breach)
        if not breach:
            self._warned, self._hold = False, None
        elif not self._warned and self._commander.armed:
            self._warned = True
            self._say(Severity.CRITICAL, "Approaching on Geofence")
            if self._action is FenceAction.HOLD:
                place = self._place_to_hold(breach, position, along, ahead_m, speed)
                down = position[2] - rise_m if breach.altitude else position[2]
                self._hold = Reposition((*place, down), float(estimate["yaw"][0]))

    def _braking_m(self, speed_m_s: float) -> float:
        p = self._parameters
        most = max(p["MPC_ACC_HOR"], p["MPC_ACC_HOR_MAX"])
        return stopping_distance(speed_m_s, p["MPC_ACC_HOR"], most, p["MPC_JERK_AUTO"])

    def _breach(self, ahead: tuple[float, float], down: float) -> _Breach:
        """Return what a point ahead (north, east) and a height (NED z) break, and say it."""
        p, home = self._parameters, self._commander.home
        far = high = False
        if home is not None:
            away_m = math.hypot(ahead[0] - home[0], ahead[1] - home[1])
            far = 0.0 < p["GF_MAX_HOR_DIST"] < away_m
            high = 0.0 < p["GF_MAX_VER_DIST"] < float(home[2]) - down
        for broken, what, name in (
            (far, "Maximum distance from home reached", "GF_MAX_HOR_DIST"),
            (high, "Maximum altitude above home reached", "GF_MAX_VER_DIST"),
        ):
            ago_us = self._now_us - self._said_us.get(name, -_WARNING_PERIOD_US)
            if broken and ago_us >= _WARNING_PERIOD_US:
                self._said_us[name] = self._now_us
                self._say(Severity.CRITICAL, f"{what} ({p[name]:.5f})")
        return _Breach(far, high, not is_inside(self._current_areas(), *ahead))

    def _current_areas(self) -> list[Area]:
        key = (self._plan.fence_changes, self._get_origin())
        if key != self._areas_key:
            self._areas, self._areas_key = areas_of(self._plan.fence, key[1]), key
        return self._areas

    def _place_to_hold(
        self, breach: _Breach, position: list[float], along: float, ahead_m: float, speed_m_s: float
    ) -> tuple[float, float]:
        """Return north and east: inside, with PX4's least distance to the fence."""
        least_m = 2.0 * self._braking_m(0.0)
        if breach.area:
            fence_m = self._distance_to_area(position, along, ahead_m)
            return _towards(position, along, min(ahead_m, fence_m - least_m))
        home = self._commander.home
        if breach.distance and home is not None:
            ahead = _towards(position, along, ahead_m)
            bearing = math.atan2(ahead[1] - home[1], ahead[0] - home[0])
            return _towards(home.tolist(), bearing, max(self._parameters["GF_MAX_HOR_DIST"] - least_m, 0.0))
        return _towards(position, along, ahead_m if speed_m_s > 0.5 else 0.0)

    def _distance_to_area(self, position: list[float], along: float, ahead_m: float) -> float:
        """Search by halving for the distance at which the fence lies in a direction."""
        areas, least_m, most_m = self._current_areas(), 0.0, ahead_m
        while most_m - least_m > _PRECISION_M:
            middle_m = 0.5 * (least_m + most_m)
            if is_inside(areas, *_towards(position, along, middle_m)):
                least_m = middle_m
            else:
                most_m = middle_m
        return 0.5 * (least_m + most_m)


def _towards(position: Sequence[float], bearing_rad: float, distance_m: float) -> tuple[float, float]:
    return (
        float(position[0]) + distance_m * math.cos(bearing_rad),
        float(position[1]) + distance_m * math.sin(bearing_rad),
    )
