"""Carries out each MAV_CMD and gives PX4's answer.

The link answers commands about messages and intervals (`message_commands.py`).
"""

from __future__ import annotations

import math
from typing import Callable, Sequence

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.commander import FORCE_MAGIC, Commander, Reposition
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Mode, Result, Severity
from simulation_tools.px4.plan.plan import Plan
from simulation_tools.px4.safety.geofence import Geofence

Parameters = Sequence[float]
"""The seven parameters of a command; NaN: not given."""

NAV_RETURN_TO_LAUNCH, NAV_LAND, NAV_TAKEOFF = 20, 21, 22
DO_SET_MODE, DO_CHANGE_SPEED, DO_SET_HOME, DO_REPOSITION = 176, 178, 179, 192
DO_FLIGHTTERMINATION, MISSION_START, COMPONENT_ARM_DISARM = 185, 300, 400
_CUSTOM_MODE_ENABLED, _AUTO, _MANUAL_INPUT, _GUIDED, _STABILIZED = 1, 4, 64, 8, 16
_CHANGE_MODE = 1  # flag of DO_REPOSITION
_ALTITUDE_MAX_M = 1e5


class Commands:
    """Carries out commands. It refuses numbers that make no sense."""

    def __init__(
        self,
        commander: Commander,
        origin: Callable[[], GeodeticOrigin],
        say: Say,
        set_cruise_speed: Callable[[float], None],
        plan: Plan,
        fence: Geofence,
    ) -> None:
        """origin: returns the local frame's origin on earth.

        set_cruise_speed: sets the speed of the automatic modes, m/s; NaN: the parameter's.
        """
        self._commander = commander
        self._get_origin = origin
        self._say = say
        self._set_cruise_speed = set_cruise_speed
        self._plan = plan
        self._fence = fence
        self._handlers: dict[int, Callable[[Parameters], Result]] = {
            COMPONENT_ARM_DISARM: self._arm_or_disarm,
            DO_SET_MODE: self._set_mode,
            DO_SET_HOME: self._set_home,
            DO_REPOSITION: self._reposition,
            DO_CHANGE_SPEED: self._change_speed,
            DO_FLIGHTTERMINATION: self._terminate,
            NAV_TAKEOFF: self._take_off,
            NAV_LAND: self._land,
            NAV_RETURN_TO_LAUNCH: self._return_home,
            MISSION_START: self._start_mission,
        }

    def handle(self, command: int, params: Parameters) -> Result:
        """Carry out a command and return PX4's answer."""
        handler = self._handlers.get(command)
        return Result.UNSUPPORTED if handler is None else handler(params)

    @property
    def _origin(self) -> GeodeticOrigin:
        return self._get_origin()

    def _enter(self, mode: Mode) -> Result:
        return self._commander.request_mode(*mode.value)

    def _arm_or_disarm(self, params: Parameters) -> Result:
        action, force = params[0], params[1] == FORCE_MAGIC
        if action not in (0.0, 1.0):
            self._say(Severity.CRITICAL, f"Unsupported ARM_DISARM param: {action:.3f}")
            return Result.UNSUPPORTED
        return self._commander.request_arm(force) if action else self._commander.request_disarm(force)

    def _set_mode(self, params: Parameters) -> Result:
        if not all(map(math.isfinite, params[:3])):
            return Result.DENIED
        base, main, sub = (int(value) for value in params[:3])
        if base & _CUSTOM_MODE_ENABLED:
            return self._commander.request_mode(main, sub)
        if base & _AUTO:
            return self._enter(Mode.AUTO_MISSION)
        if not base & _MANUAL_INPUT:
            return Result.ACCEPTED  # PX4 accepts this and changes nothing
        if base & _GUIDED:
            return self._enter(Mode.POSCTL)
        return self._enter(Mode.STABILIZED if base & _STABILIZED else Mode.MANUAL)

    def _take_off(self, params: Parameters) -> Result:
        """The altitude is above mean sea level."""
        altitude = params[6]
        if not (math.isnan(altitude) or abs(altitude) <= _ALTITUDE_MAX_M):
            return Result.DENIED
        return self._commander.request_takeoff(altitude - self._origin.altitude_m)

    def _land(self, params: Parameters) -> Result:
        result = self._enter(Mode.AUTO_LAND)
        if result is Result.ACCEPTED:
            self._say(Severity.INFO, "Landing at current position")
        return result

    def _return_home(self, params: Parameters) -> Result:
        """PX4 refuses this command (but not the mode) while it is already returning."""
        if self._commander.wanted_mode is Mode.AUTO_RTL:
            result = Result.TEMPORARILY_REJECTED
        else:
            result = self._enter(Mode.AUTO_RTL)
        accepted = result is Result.ACCEPTED
        self._say(
            Severity.INFO if accepted else Severity.CRITICAL,
            "Returning to launch" if accepted else "Return to launch denied",
        )
        return result

    def _reposition(self, params: Parameters) -> Result:
        """Go to a latitude, longitude and altitude, NaN for where it is; a flag changes the mode first."""
        speed, flags, _, yaw, latitude, longitude, altitude = params
        north, east = math.nan, math.nan
        if self._is_place(latitude, longitude):
            north, east = self._origin.to_local(latitude, longitude)
        elif not (math.isnan(latitude) or math.isnan(longitude)):
            return Result.DENIED
        if not (math.isnan(altitude) or abs(altitude) <= _ALTITUDE_MAX_M):
            return Result.DENIED
        down = self._origin.altitude_m - altitude
        if math.isfinite(flags) and int(flags) & _CHANGE_MODE:
            result = self._enter(Mode.AUTO_LOITER)
            if result is not Result.ACCEPTED:
                self._say(Severity.CRITICAL, "Reposition command rejected")
                return result
        if not (math.isnan(north) or math.isnan(east)) and self._fence.forbids((north, east, down)):
            self._say(Severity.CRITICAL, "Reposition is outside geofence")
            return Result.ACCEPTED
        self._set_cruise_speed(speed if speed > 0.0 and math.isfinite(speed) else math.nan)
        self._commander.reposition(Reposition((north, east, down), yaw if math.isfinite(yaw) else math.nan))
        return Result.ACCEPTED

    def _change_speed(self, params: Parameters) -> Result:
        speed = params[1]
        self._set_cruise_speed(speed if speed > 0.0 and math.isfinite(speed) else math.nan)
        return Result.ACCEPTED

    def _terminate(self, params: Parameters) -> Result:
        """1: stop the rotors; 2: and disarm; 0: go on."""
        how = params[0]
        if how > 0.5:
            self._commander.terminate(lock=how > 1.5)
        else:
            self._commander.end_termination()
        return Result.ACCEPTED

    def _set_home(self, params: Parameters) -> Result:
        latitude, longitude, altitude = params[4:7]
        if params[0] == 1.0:
            return self._commander.request_home(None)
        if not (self._is_place(latitude, longitude) and abs(altitude) <= _ALTITUDE_MAX_M):
            return Result.DENIED
        north, east = self._origin.to_local(latitude, longitude)
        return self._commander.request_home((north, east, self._origin.altitude_m - altitude))

    def _start_mission(self, params: Parameters) -> Result:
        """Fly the mission from an item on; -1: from the current one."""
        if not self._commander.mission_is_valid:
            self._say(Severity.CRITICAL, "Mission start denied! No valid mission")
            return Result.DENIED
        first = params[0]
        if not -1.0 <= first < len(self._plan.mission):
            return Result.DENIED
        if self._commander.start_mission() is not Result.ACCEPTED:
            self._say(Severity.CRITICAL, "Mission start denied")
            return Result.TEMPORARILY_REJECTED
        if first >= 0.0 and int(first) != self._plan.current:
            self._plan.choose(int(first))
        return Result.ACCEPTED

    @staticmethod
    def _is_place(latitude: float, longitude: float) -> bool:
        return abs(latitude) <= 90.0 and abs(longitude) <= 180.0
