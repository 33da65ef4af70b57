"""AUTO.MISSION: from the uploaded items to the waypoint that is flown.

PX4 looks at its mission 20 times a second. It inserts what a plan leaves out: a take-off when the vehicle
stands on the ground or is too low, and the way to a landing site before the landing.
"""

from __future__ import annotations

import enum
import math
from typing import Callable, Sequence

import numpy as np

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Mode, Severity
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.arrival import Arrival
from simulation_tools.px4.plan.feasibility import FeasibilityCheck
from simulation_tools.px4.plan.items import Command, PlanItem
from simulation_tools.px4.plan.jumps import Reader
from simulation_tools.px4.plan.plan import Plan
from simulation_tools.px4.plan.waypoints import ActiveItem, Kind, Route, Vehicle, Waypoint

_PERIOD_S = 0.05
_ISSUED = (Command.RETURN_TO_LAUNCH, Command.CHANGE_SPEED, Command.SET_HOME)
_FIRST_RISE = (Command.TAKEOFF, Command.WAYPOINT, Command.LOITER_TIME, Command.LOITER_UNLIMITED)
_KINDS: dict[int, Kind] = {
    Command.TAKEOFF: Kind.TAKEOFF,
    Command.LAND: Kind.LAND,
    Command.LOITER_UNLIMITED: Kind.LOITER,
    Command.LOITER_TIME: Kind.LOITER,
    Command.LOITER_TO_ALTITUDE: Kind.LOITER,
}


class _Work(enum.Enum):
    """What is done for an item before the item itself."""

    NOTHING = 0
    TAKEOFF = 1
    MOVE_TO_LAND = 2


class Mission:
    """Flies the plan. `reached` is the newest item that was reached."""

    def __init__(
        self,
        parameters: Px4Parameters,
        plan: Plan,
        origin: Callable[[], GeodeticOrigin],
        issue: Callable[[int, Sequence[float]], object],
        check: FeasibilityCheck,
        say: Say,
    ) -> None:
        """issue: carries out a command of an item, as if a client had sent it."""
        self._parameters = parameters
        self._plan = plan
        self._get_origin = origin
        self._issue = issue
        self._check = check
        self._arrival = Arrival(parameters)
        self._say = say
        self._reader = Reader(plan, say)
        self.is_valid = self._had_home = False
        self._changes = self._seen_changes = plan.mission_changes
        self.reset()

    def reset(self) -> None:
        """Go back to the first item, as after disarming."""
        self._plan.current = 0
        self._reader.reset()
        self.reached = -1
        self._route: Route | None = None
        self.roi: tuple[float, float] | None = None  # north, east: what to look at
        self._running = self._flown = False
        self._needs_takeoff = True
        self._work = _Work.NOTHING
        self._item = ActiveItem(Command.WAYPOINT)
        self._arrival.reset()
        self._due_s = 0.0

    # Between flights

    def watch(self, home: np.ndarray | None, landed: bool) -> None:
        """Judge a new plan, and the plan there is as soon as there is a home. home: NED, (3,)."""
        found_home = home is not None and not self._had_home
        if not found_home and self._plan.mission_changes == self._changes:
            return
        self._had_home, self._changes = home is not None, self._plan.mission_changes
        self._take_plan(self._check.passes(self._plan.mission, home, self._get_origin(), landed))

    def rest(self, mode: Mode, armed: bool, landed: bool) -> None:
        """Another mode flies. A take-off comes first again, unless that mode held the vehicle in the air."""
        if not armed and self._flown:
            self.reset()
        if landed or not mode.is_auto:
            self._needs_takeoff = True
        self._work = _Work.NOTHING
        self.reached = -1
        self._route = None

    def _take_plan(self, is_valid: bool) -> None:
        """Take in another plan, or another current item."""
        plan = self._plan
        self.is_valid = is_valid
        if plan.chosen is not None and plan.chosen < len(plan.mission):
            plan.current = plan.chosen
        elif plan.current >= len(plan.mission):
            plan.current = 0
        self.roi = None
        self._reader.reset()
        if not is_valid:
            plan.current = 0
            return
        self.reached = -1
        self._work = _Work.NOTHING
        if self._route is None:
            self._running = True

    # In flight

    def enter(self, vehicle: Vehicle) -> None:
        """Begin, or go on, with the current item."""
        self._route = None
        self._due_s = vehicle.time_s + _PERIOD_S
        self._flown = True
        self._seen_changes = self._changes
        self._set_item(vehicle)

    def update(self, vehicle: Vehicle) -> None:
        """Go on to the next item when the vehicle has done this one."""
        if self._seen_changes != self._changes:
            self._seen_changes = self._changes
            self._route = None
            self._set_item(vehicle)
        if vehicle.time_s < self._due_s:
            return
        self._due_s += _PERIOD_S
        self._rise_when_there(vehicle)
        if not (self._running and self._arrival.is_reached(self._item, vehicle)):
            return
        if self._work is not _Work.TAKEOFF:
            self.reached = self._plan.current
        self._arrival.reset()
        if self._item.autocontinue:
            if self._work is _Work.NOTHING:
                self._plan.current += 1
            self._set_item(vehicle)

    @property
    def route(self) -> Route:
        """What the navigator follows."""
        return self._route or Route(Waypoint(Kind.IDLE, np.zeros(3), math.nan, self._radius(0.0)))

    def yaw_rad(self, position: np.ndarray) -> float:
        """Return the heading that the item asks for, or the one to what it looks at; NaN: none."""
        if self.roi is not None and self._item.command != Command.LAND:
            north, east = self.roi[0] - position[0], self.roi[1] - position[1]
            if math.hypot(north, east) > self._parameters["NAV_ACC_RAD"]:
                return math.atan2(east, north)
        return self._route.current.yaw_rad if self._route else math.nan

    @property
    def is_taking_off(self) -> bool:
        """Whether the vehicle rises from the ground."""
        return self._route is not None and self._route.current.kind is Kind.TAKEOFF

    @property
    def is_landing(self) -> bool:
        """Whether the vehicle sinks to land."""
        return self._route is not None and self._route.current.kind is Kind.LAND

    def _set_item(self, vehicle: Vehicle) -> None:
        item = self._reader.read(for_real=True) if self.is_valid else None
        if item is None:
            self._finish(vehicle)
            return
        if not self._running:
            self._say(Severity.INFO, "Executing Mission")
            self._running = True
        following = self._reader.next_with_position()
        before = self._route.current if self._route else None
        work = _Work.NOTHING
        if item.has_position:
            work, following = self._insert(item, following, vehicle)
            self._steer_to(vehicle, before, following)
        else:
            self._item = ActiveItem(item.command, stay_s=item.stay_s, autocontinue=item.autocontinue)
            self._set_roi(item)
            if self._route is None:
                kind = Kind.IDLE if vehicle.landed else Kind.LOITER
                self._route = Route(Waypoint(kind, vehicle.position.copy(), math.nan, self._radius(0.0)))
        self._work = work
        if self._route is not None and self._route.current.kind in (Kind.LAND, Kind.IDLE):
            self._needs_takeoff = True
        self._arrival.reset()
        if item.command in _ISSUED:
            self._issue(item.command, (*item.params, item.x, item.y, item.z))

    def _insert(
        self, item: PlanItem, following: PlanItem | None, vehicle: Vehicle
    ) -> tuple[_Work, PlanItem | None]:
        """Set the active item: this one, or what must come before it."""
        place = np.array(item.position_ned_m(self._get_origin(), float(vehicle.home[2])))
        yaw_rad = item.yaw_rad
        if item.command in (Command.LAND, Command.TAKEOFF):
            yaw_rad = math.nan
        active = ActiveItem(item.command, place, yaw_rad, item.stay_s, item.radius_m, item.autocontinue)
        self._item = active
        if item.command == Command.LOITER_TO_ALTITUDE:
            active.then_z = float(place[2])
            place[2] = vehicle.position[2]
        if self._work is _Work.NOTHING and self._must_rise_first(item, place, vehicle):
            z = self._takeoff_z(place, vehicle)
            height_m = float(vehicle.home[2]) - z
            self._say(Severity.INFO, f"Takeoff to {height_m:.1f} meters above home")
            here = np.array([vehicle.position[0], vehicle.position[1], z])
            self._item = ActiveItem(Command.TAKEOFF, here, vehicle.yaw_rad)
            return _Work.TAKEOFF, item
        if item.command == Command.TAKEOFF:
            active.command = Command.WAYPOINT
        elif item.command == Command.LAND and self._work is _Work.NOTHING:
            aside_m = math.hypot(*(place - vehicle.position)[:2].tolist())
            if aside_m > self._parameters["NAV_ACC_RAD"]:
                current = self._route.current if self._route else None
                level = current.place if current and current.kind is Kind.POSITION else vehicle.position
                above = np.array([place[0], place[1], level[2]])
                self._item = ActiveItem(Command.WAYPOINT, above, item.yaw_rad)
                return _Work.MOVE_TO_LAND, item
        return _Work.NOTHING, following

    def _must_rise_first(self, item: PlanItem, place: np.ndarray, vehicle: Vehicle) -> bool:
        low_enough_z = self._takeoff_z(place, vehicle) + self._parameters["NAV_MC_ALT_RAD"]
        if vehicle.landed:
            self._needs_takeoff = True
        elif vehicle.position[2] < low_enough_z:
            self._needs_takeoff = False
        elif item.command == Command.TAKEOFF:
            self._needs_takeoff = True
        if self._needs_takeoff and item.command in _FIRST_RISE:
            self._needs_takeoff = False
            return True
        return False

    def _takeoff_z(self, place: np.ndarray, vehicle: Vehicle) -> float:
        ground_z = vehicle.position[2] if vehicle.landed else vehicle.home[2]
        return float(min(place[2], ground_z - self._parameters["MIS_TAKEOFF_ALT"]))

    def _steer_to(self, vehicle: Vehicle, before: Waypoint | None, following: PlanItem | None) -> None:
        """Set the route to the active item."""
        item = self._item
        on_ground = vehicle.landed or vehicle.maybe_landed
        kind = _KINDS.get(item.command, Kind.POSITION)
        if kind is Kind.TAKEOFF and not on_ground:
            kind = Kind.POSITION
        current = Waypoint(kind, item.place, item.yaw_rad, self._radius(item.radius_m))
        previous = self._route.previous if self._route else None
        if self._work is not _Work.MOVE_TO_LAND and not current.equals(before):
            previous = before.place if before else None
        after = None
        if item.autocontinue and item.stay_s <= 0.0 and following is not None and kind is not Kind.LOITER:
            after = np.array(following.position_ned_m(self._get_origin(), float(vehicle.home[2])))
        self._route = Route(current, previous, after)

    def _rise_when_there(self, vehicle: Vehicle) -> None:
        """Over the place of LOITER_TO_ALTITUDE, go to its height."""
        item = self._item
        if item.then_z is not None and self._arrival.is_near(item, vehicle):
            item.place = np.array([item.place[0], item.place[1], item.then_z])
            item.then_z = None
            self._route = Route(Waypoint(Kind.LOITER, item.place, item.yaw_rad, self._radius(0.0)))

    def _radius(self, asked_m: float) -> float:
        return asked_m if asked_m > 0.0 else self._parameters["NAV_ACC_RAD"]

    def _set_roi(self, item: PlanItem) -> None:
        if item.sets_roi:
            place = item.roi
            self.roi = None if place is None else self._get_origin().to_local(*place)

    def _finish(self, vehicle: Vehicle) -> None:
        """Hold at the last waypoint, or stay on the ground."""
        place = vehicle.position.copy()
        if self._running:
            end = "landed" if vehicle.landed else "loitering"
            self._say(Severity.INFO, f"Mission finished, {end}")
            if self._route is not None and not vehicle.landed:
                place = self._route.current.place
        else:
            what = "refusing takeoff" if vehicle.landed else "loitering"
            self._say(Severity.CRITICAL, f"No valid mission available, {what}")
            place[2] = min(place[2], vehicle.home[2] - self._parameters["MIS_TAKEOFF_ALT"])
        self._running = False
        self._item = ActiveItem(Command.LOITER_UNLIMITED, place, autocontinue=False)
        kind = Kind.IDLE if vehicle.landed else Kind.LOITER
        self._route = Route(Waypoint(kind, place, math.nan, self._radius(0.0)))
        self._needs_takeoff = self._needs_takeoff or vehicle.landed
