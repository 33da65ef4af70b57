"""Setpoints of the automatic modes: hold, take-off, land and return.

Targets are approached along a reference point that is limited in speed, acceleration and jerk, as by PX4's
trajectory generator; it waits for a vehicle that falls behind.
"""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.px4.commander import Commander
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.position_control import SETPOINT_DTYPE
from simulation_tools.px4.trajectory import SmoothAxis, speed_that_stops_within


class Navigator:
    """Fills a setpoint record for the active automatic mode. Positions in NED."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
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
        self._waited_s = 0.0
        self._landing = False

    def set_cruise_speed(self, speed_m_s: float) -> None:
        """Fly at this speed instead of MPC_XY_CRUISE; NaN: no longer."""
        self._cruise_speed_m_s = speed_m_s

    def enter(self, commander: Commander, estimate: np.ndarray) -> None:
        """Start the commander's mode, with what it was asked for, from where the vehicle is."""
        mode, home = commander.mode, commander.home
        p = self._parameters
        took_off = self._mode is Mode.AUTO_TAKEOFF and self.finished
        self._mode = mode
        if took_off and mode is Mode.AUTO_LOITER:
            self.finished = False  # hold where the take-off leads to, not where it was cut short
            return
        for axis, position, velocity in zip(self._axes, *estimate[["position", "velocity"]][0].tolist()):
            axis.start(position, velocity)
        self._yaw = self._wanted_yaw = float(estimate["yaw"][0])
        self._waited_s = 0.0
        self.finished = False
        self._landing = mode is Mode.AUTO_LAND
        self._target = self._stopping_point()
        if mode is Mode.AUTO_TAKEOFF:
            height = (
                p["MIS_TAKEOFF_ALT"] if math.isnan(commander.takeoff_height_m) else commander.takeoff_height_m
            )
            position = estimate["position"][0]
            for axis, start in zip(self._axes, position.tolist()):
                axis.start(start)
            self._target = position.copy()
            self._target[2] = min(home[2] - height, position[2])
        elif mode is Mode.AUTO_RTL:
            near = self._distance_xy(home) < p["NAV_ACC_RAD"]
            height = p["RTL_DESCEND_ALT"] if near else p["RTL_RETURN_ALT"]
            self._target[2] = min(self._axes[2].position, home[2] - height)
        elif mode is Mode.AUTO_LOITER and commander.reposition_target is not None:
            asked = np.array(commander.reposition_target.position_ned_m)
            yaw = commander.reposition_target.yaw_rad
            self._target = np.where(np.isnan(asked), self._target, asked)
            self._wanted_yaw = self._yaw if math.isnan(yaw) else yaw

    def update(self, estimate: np.ndarray, home: np.ndarray, dt_s: float) -> np.ndarray:
        """Return the setpoint record, shape (1,), the same each time."""
        if self._mode is Mode.AUTO_RTL and not self._landing:
            self._return(home, dt_s)
        climb = self._parameters["MPC_TKO_SPEED"] if self._mode is Mode.AUTO_TAKEOFF else None
        self._advance(dt_s * self._stretch(estimate["position"][0]), climb)
        self._turn(dt_s)
        setpoint = self.setpoint[0]
        for name in ("position", "velocity", "acceleration"):
            setpoint[name] = [getattr(axis, name) for axis in self._axes]
        setpoint["yaw"], setpoint["yaw_rate"] = self._yaw, math.nan
        if self._landing:
            setpoint["position"][2] = setpoint["acceleration"][2] = math.nan
            setpoint["velocity"][2] = self._landing_speed(float(home[2] - estimate["position"][0, 2]))
        if self._mode is Mode.AUTO_TAKEOFF:
            self.finished = abs(self._target[2] - estimate["position"][0, 2]) < 0.2
        return self.setpoint

    def _return(self, home: np.ndarray, dt_s: float) -> None:
        """Climb, fly home, sink, wait, land: move the target when the last one is reached."""
        p = self._parameters
        at_height = abs(self._target[2] - self._axes[2].position) < 0.5
        if at_height:
            self._target[:2] = home[:2]
        if at_height and self._distance_xy(home) < 0.5:
            self._target[2] = max(self._target[2], home[2] - p["RTL_DESCEND_ALT"])
            if abs(self._target[2] - self._axes[2].position) < 0.5:
                self._waited_s += dt_s
                self._landing = 0.0 <= p["RTL_LAND_DELAY"] <= self._waited_s

    def _distance_xy(self, place: np.ndarray) -> float:
        """Return how far the reference point is from a place, metres over ground."""
        north, east, _ = self._axes
        return math.hypot(north.position - place[0], east.position - place[1])

    def _landing_speed(self, height_m: float) -> float:
        """Sinking speed by height over home: fast above ALT1, MPC_LAND_SPEED below ALT2, linear between."""
        p = self._parameters
        heights = (p["MPC_LAND_ALT2"], max(p["MPC_LAND_ALT1"], p["MPC_LAND_ALT2"] + 0.01))
        return float(np.interp(height_m, heights, (p["MPC_LAND_SPEED"], p["MPC_Z_VEL_MAX_DN"])))

    def _stopping_point(self) -> np.ndarray:
        """Where the reference comes to rest when it brakes at once."""
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
        """Return how fast the reference's time runs: slower, the farther the vehicle has fallen behind."""
        north, east, _ = self._axes
        behind = (north.position - position[0], east.position - position[1])
        if behind[0] * north.velocity + behind[1] * east.velocity <= 0.0:
            return 1.0  # it is ahead
        return 1.0 - min(math.hypot(*behind) / self._parameters["MPC_XY_ERR_MAX"], 1.0)

    def _turn(self, dt_s: float) -> None:
        """Turn the heading towards the wanted one, at most at MPC_YAWRAUTO_MAX."""
        most = math.radians(self._parameters["MPC_YAWRAUTO_MAX"]) * dt_s
        gap = math.remainder(self._wanted_yaw - self._yaw, 2.0 * math.pi)
        self._yaw = math.remainder(self._yaw + min(max(gap, -most), most), 2.0 * math.pi)

    def _advance(self, dt_s: float, climb_speed_m_s: float | None) -> None:
        """Move the reference point towards the target for dt_s."""
        p = self._parameters
        jerk, acceleration = p["MPC_JERK_AUTO"], p["MPC_ACC_HOR"]
        north, east, down = (target - axis.position for target, axis in zip(self._target, self._axes))
        distance = math.hypot(north, east)
        cruise = p["MPC_XY_CRUISE"] if math.isnan(self._cruise_speed_m_s) else self._cruise_speed_m_s
        speed = min(cruise, p["MPC_XY_VEL_MAX"], speed_that_stops_within(distance, acceleration, jerk))
        share = speed / distance if distance > 1e-6 else 0.0
        self._axes[0].advance(share * north, acceleration, jerk, dt_s)
        self._axes[1].advance(share * east, acceleration, jerk, dt_s)

        up = p["MPC_Z_VEL_MAX_UP"] if climb_speed_m_s is None else climb_speed_m_s
        limit, acceleration = (
            (up, p["MPC_ACC_UP_MAX"]) if down < 0.0 else (p["MPC_Z_VEL_MAX_DN"], p["MPC_ACC_DOWN_MAX"])
        )
        speed = min(limit, speed_that_stops_within(abs(down), acceleration, jerk))
        self._axes[2].advance(math.copysign(speed, down), acceleration, jerk, dt_s)
