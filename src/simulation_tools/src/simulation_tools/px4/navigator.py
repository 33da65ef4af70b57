"""Setpoints of the automatic modes: hold, take-off, land, return and mission.

A reference point moves towards the target with limited speed, acceleration and jerk, like PX4's trajectory
generator. It waits for a vehicle that falls behind.
"""

from __future__ import annotations

import math
from typing import Callable

import numpy as np

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.commander import Commander
from simulation_tools.px4.control.records import SETPOINT_DTYPE
from simulation_tools.px4.control.trajectory import SmoothAxis, speed_that_stops_within
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Mode, Severity
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.mission import Mission
from simulation_tools.px4.plan.path import PathFollower, YawMode
from simulation_tools.px4.plan.waypoints import Kind, Route, Vehicle, Waypoint
from simulation_tools.px4.return_home import ReturnHome

_TAKEOFF_SLACK_M = 0.1  # PX4 sends no text if an altitude is too low by less than this
_STANDING_SPEED_M_S = 0.7  # downwards; a climb starts from this speed, so that it begins without a step


class Navigator:
    """Fills a setpoint record for the active automatic mode. Positions in NED."""

    def __init__(
        self, parameters: Px4Parameters, mission: Mission, origin: Callable[[], GeodeticOrigin], say: Say
    ) -> None:
        """origin: returns where the local frame begins on earth, for status texts."""
        self._parameters = parameters
        self._mission = mission
        self._path = PathFollower(parameters)
        self._say = say
        self._return_home = ReturnHome(parameters, origin, say)
        self.setpoint = np.zeros(1, SETPOINT_DTYPE)
        self.reset()

    def reset(self) -> None:
        """Forget mode and target, as at power-on."""
        self.finished = False  # a take-off has reached its height
        self._mode: Mode | None = None
        self._axes = (SmoothAxis(), SmoothAxis(), SmoothAxis())
        self._target = np.zeros(3)
        self._yaw = self._wanted_yaw = 0.0
        self._cruise_speed_m_s = math.nan
        self._idle = True
        self._heading: Route | None = None  # a place to fly to and to look at

    def set_cruise_speed(self, speed_m_s: float) -> None:
        """Fly at this speed instead of MPC_XY_CRUISE; NaN: at MPC_XY_CRUISE again."""
        self._cruise_speed_m_s = speed_m_s

    def enter(self, commander: Commander, estimate: np.ndarray, landed: bool, vehicle: Vehicle) -> None:
        """Start the commander's mode and its request, from the vehicle's place."""
        mode = commander.mode
        took_off = self._mode is Mode.AUTO_TAKEOFF and self.finished
        if Mode.AUTO_MISSION in (mode, self._mode):
            self._cruise_speed_m_s = math.nan  # a mission's speed ends with it
        self._mode = mode
        self._heading = None
        self.finished = False
        self._idle = landed and mode is not Mode.AUTO_TAKEOFF
        if took_off and mode is Mode.AUTO_LOITER:
            return  # hold at the take-off's target, not at the place where the take-off ended
        for axis, position, velocity in zip(self._axes, *estimate[["position", "velocity"]][0].tolist()):
            axis.start(position, velocity)
        self._yaw = self._wanted_yaw = float(estimate["yaw"][0])
        self._target = self._stopping_point()
        if mode is Mode.AUTO_TAKEOFF:
            self._take_off(commander.takeoff_altitude_m, estimate["position"][0])
        elif mode is Mode.AUTO_MISSION:
            self._path.start()
            self._mission.enter(vehicle)
        elif mode is Mode.AUTO_RTL and commander.home is not None:
            self._return_home.start(
                estimate["position"][0], self._yaw, commander.home, commander.home_yaw_rad, landed
            )
        elif mode is Mode.AUTO_LOITER and commander.reposition_target is not None:
            self._idle = False
            asked = np.array(commander.reposition_target.position_ned_m)
            yaw = commander.reposition_target.yaw_rad
            self._target = np.where(np.isnan(asked), self._target, asked)
            self._wanted_yaw = self._yaw if math.isnan(yaw) else yaw
            if math.isnan(yaw) and not np.isnan(asked).all():
                radius_m = self._parameters["NAV_ACC_RAD"]
                self._heading = Route(Waypoint(Kind.LOITER, self._target, math.nan, radius_m))
                self._path.start()

    def _take_off(self, altitude_m: float, position: np.ndarray) -> None:
        """Rise to an altitude over the local frame's origin, but at least by MIS_TAKEOFF_ALT from here."""
        least_m = self._parameters["MIS_TAKEOFF_ALT"]
        lowest_m = least_m - float(position[2])
        if not altitude_m >= lowest_m - _TAKEOFF_SLACK_M:
            severity = Severity.INFO if math.isnan(altitude_m) else Severity.CRITICAL
            self._say(severity, f"Using minimum takeoff altitude: {least_m:.2f} m")
        self._target = position.copy()
        self._target[2] = -(altitude_m if altitude_m > lowest_m else lowest_m)

    def stand(self, position: np.ndarray) -> None:
        """Begin a take-off's climb at this position (3,). Call it until the vehicle may leave the ground."""
        for axis, start in zip(self._axes, position.tolist()):
            axis.start(start)
        self._axes[2].velocity = _STANDING_SPEED_M_S

    def update(
        self, estimate: np.ndarray, home: np.ndarray, landed: bool, dt_s: float, vehicle: Vehicle
    ) -> np.ndarray | None:
        """Return the setpoint record, shape (1,), always the same object; None: stay on the ground."""
        position = estimate["position"][0]
        if self._mode is Mode.AUTO_RTL:
            self._follow_return(estimate, landed, dt_s)
        elif self._mode is Mode.AUTO_LAND:
            self._idle = self._idle or landed
        elif self._mode is Mode.AUTO_MISSION:
            self._follow_mission(vehicle)
        if self._idle:
            return None
        limits = self._vertical_limits(float(home[2] - position[2]))
        if self._mode is Mode.AUTO_MISSION:
            sinking = self._landing_speed(float(home[2] - position[2])) if self.is_landing else None
            self._advance_along_path(dt_s * self._stretch(position), limits, sinking)
        else:
            self._advance(dt_s * self._stretch(position), *limits)
        self._look(estimate, home)
        yaw_rate = self._turn(dt_s)
        setpoint = self.setpoint[0]
        for name in ("position", "velocity", "acceleration"):
            setpoint[name] = [getattr(axis, name) for axis in self._axes]
        setpoint["yaw"], setpoint["yaw_rate"] = self._yaw, yaw_rate
        if self.is_landing:
            setpoint["position"][2] = setpoint["acceleration"][2] = math.nan
            eases_in = self._mode is Mode.AUTO_MISSION
            landing = self._landing_speed(float(home[2] - position[2]))
            setpoint["velocity"][2] = self._axes[2].velocity if eases_in else landing
        if self.is_taking_off:
            reached = abs(self._target[2] - position[2]) <= self._parameters["NAV_MC_ALT_RAD"]
            self.finished = reached and self._mode is Mode.AUTO_TAKEOFF
            # The climb follows a velocity only, which grows from zero. At first no height is missing.
            if home[2] - position[2] < self._parameters["MPC_LAND_ALT1"]:
                self._axes[2].position = float(position[2])
        return self.setpoint

    def _follow_return(self, estimate: np.ndarray, landed: bool, dt_s: float) -> None:
        leg = self._return_home
        leg.update(estimate["position"][0], float(estimate["yaw"][0]), landed, dt_s)
        self._idle = leg.is_landed
        self._target, self._wanted_yaw = leg.target, leg.yaw_rad

    def _follow_mission(self, vehicle: Vehicle) -> None:
        self._mission.update(vehicle)
        route = self._mission.route
        waypoint = route.current
        self._idle = waypoint.kind is Kind.IDLE or (waypoint.kind is Kind.LAND and vehicle.landed)
        self._target = waypoint.place
        self._path.follow(route, vehicle.position)

    def _look(self, estimate: np.ndarray, home: np.ndarray) -> None:
        """Set the heading of a mission, and of a place that was ordered without a heading."""
        position, yaw = estimate["position"][0], float(estimate["yaw"][0])
        route = self._heading
        if self._mode is Mode.AUTO_MISSION:
            route = self._mission.route
            asked = self._mission.yaw_rad(position)
            if not math.isnan(asked) and route.current.kind is not Kind.TAKEOFF:
                self._wanted_yaw = asked
                return
        elif route is not None:
            self._path.follow(route, position)
        if route is not None:
            velocity = [axis.velocity for axis in self._axes]
            wanted = self._path.yaw_rad(yaw, position, home, velocity)
            self._wanted_yaw = self._wanted_yaw if math.isnan(wanted) else wanted

    @property
    def is_taking_off(self) -> bool:
        """Whether it rises from the ground."""
        return self._mode is Mode.AUTO_TAKEOFF or (
            self._mode is Mode.AUTO_MISSION and self._mission.is_taking_off
        )

    @property
    def is_landing(self) -> bool:
        """Whether it sinks to land."""
        if self._idle:
            return False
        if self._mode is Mode.AUTO_MISSION:
            return self._mission.is_landing
        returning = self._mode is Mode.AUTO_RTL and self._return_home.is_landing
        return self._mode is Mode.AUTO_LAND or returning

    def _landing_speed(self, height_m: float) -> float:
        """Sinking speed by height over home: fast above ALT1, MPC_LAND_SPEED below ALT2, linear between."""
        p = self._parameters
        heights = (p["MPC_LAND_ALT2"], max(p["MPC_LAND_ALT1"], p["MPC_LAND_ALT2"] + 0.01))
        return float(np.interp(height_m, heights, (p["MPC_LAND_SPEED"], p["MPC_Z_VEL_MAX_DN"])))

    def _stopping_point(self) -> np.ndarray:
        """The place where the reference would stop if it braked now."""
        p = self._parameters
        velocity = [axis.velocity for axis in self._axes]
        vertical = p["MPC_ACC_DOWN_MAX" if velocity[2] < 0.0 else "MPC_ACC_UP_MAX"]
        speeds = (math.hypot(velocity[0], velocity[1]),) * 2 + (abs(velocity[2]),)
        point = [
            axis.position + axis.velocity * (speed / (2.0 * limit) + limit / p["MPC_JERK_AUTO"])
            for axis, speed, limit in zip(self._axes, speeds, (p["MPC_ACC_HOR"],) * 2 + (vertical,))
        ]
        return np.array(point)

    def _stretch(self, position: np.ndarray) -> float:
        """Return the rate of the reference's time: the farther the vehicle is behind, the slower."""
        north, east, _ = self._axes
        behind = (north.position - position[0], east.position - position[1])
        if behind[0] * north.velocity + behind[1] * east.velocity <= 0.0:
            return 1.0  # the vehicle is ahead
        return 1.0 - min(math.hypot(*behind) / self._parameters["MPC_XY_ERR_MAX"], 1.0)

    def _turn(self, dt_s: float) -> float:
        """Turn the heading towards the wanted one, at most at MPC_YAWRAUTO_MAX; returns the rate, rad/s."""
        most = math.radians(self._parameters["MPC_YAWRAUTO_MAX"]) * dt_s
        gap = math.remainder(self._wanted_yaw - self._yaw, 2.0 * math.pi)
        turn = min(max(gap, -most), most)
        self._yaw = math.remainder(self._yaw + turn, 2.0 * math.pi)
        return turn / dt_s

    def _vertical_limits(self, height_m: float) -> tuple[float, float]:
        """Return the greatest speed and acceleration towards the target's height; height_m: over home."""
        p = self._parameters
        if self._target[2] >= self._axes[2].position:
            return p["MPC_Z_VEL_MAX_DN"], p["MPC_ACC_DOWN_MAX"]
        if self.is_taking_off and height_m < p["MPC_LAND_ALT1"]:
            speed = p["MPC_TKO_SPEED"]
            # No faster than the ramp of thrust allows.
            return speed, min(p["MPC_ACC_UP_MAX"], speed / max(p["MPC_TKO_RAMP_T"], 0.01))
        return p["MPC_Z_VEL_MAX_UP"], p["MPC_ACC_UP_MAX"]

    def _advance_along_path(self, dt_s: float, climb: tuple[float, float], sinking_m_s: float | None) -> None:
        """Move the reference point along the mission's path for dt_s.

        climb: greatest vertical speed and acceleration. sinking_m_s: of a landing.
        """
        p = self._parameters
        point = np.array([axis.position for axis in self._axes])
        velocity = np.array([axis.velocity for axis in self._axes])
        wanted = self._path.velocity(point, velocity, self._cruise_m_s, climb)
        if p["MPC_YAW_MODE"] == YawMode.TO_WAYPOINT_FIRST and not self._yaw_is_aligned:
            wanted = np.zeros(3)
        if sinking_m_s is not None:
            wanted[2], climb = sinking_m_s, (sinking_m_s, p["MPC_ACC_DOWN_MAX"])
        accelerations = (p["MPC_ACC_HOR"], p["MPC_ACC_HOR"], climb[1])
        for axis, speed, acceleration in zip(self._axes, wanted.tolist(), accelerations):
            axis.advance(speed, acceleration, p["MPC_JERK_AUTO"], dt_s)

    @property
    def _yaw_is_aligned(self) -> bool:
        gap = math.remainder(self._wanted_yaw - self._yaw, 2.0 * math.pi)
        return abs(gap) < math.radians(self._parameters["MIS_YAW_ERR"])

    @property
    def _cruise_m_s(self) -> float:
        p, asked = self._parameters, self._cruise_speed_m_s
        return min(p["MPC_XY_CRUISE"] if math.isnan(asked) else asked, p["MPC_XY_VEL_MAX"])

    def _advance(self, dt_s: float, vertical_speed_m_s: float, vertical_acceleration_m_s2: float) -> None:
        """Move the reference point towards the target for dt_s."""
        p = self._parameters
        jerk, acceleration = p["MPC_JERK_AUTO"], p["MPC_ACC_HOR"]
        north, east, down = (target - axis.position for target, axis in zip(self._target, self._axes))
        distance = math.hypot(north, east)
        speed = min(self._cruise_m_s, speed_that_stops_within(distance, acceleration, jerk))
        share = speed / distance if distance > 1e-6 else 0.0
        self._axes[0].advance(share * north, acceleration, jerk, dt_s)
        self._axes[1].advance(share * east, acceleration, jerk, dt_s)

        limit = speed_that_stops_within(abs(down), vertical_acceleration_m_s2, jerk)
        speed = math.copysign(min(vertical_speed_m_s, limit), down)
        self._axes[2].advance(speed, vertical_acceleration_m_s2, jerk, dt_s)
