"""Setpoints of the automatic modes: hold, take-off, land and return.

Targets are approached along a reference point that is limited in speed and acceleration, a simple form of
PX4's trajectory generator.
"""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.px4.commander import Commander
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.position_control import SETPOINT_DTYPE


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
        self._position = np.zeros(3)
        self._velocity = np.zeros(3)
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
        self._position = estimate["position"][0].copy()
        self._velocity = estimate["velocity"][0].copy()
        self._yaw = self._wanted_yaw = float(estimate["yaw"][0])
        self._waited_s = 0.0
        self.finished = False
        self._landing = mode is Mode.AUTO_LAND
        self._target = self._stopping_point()
        if mode is Mode.AUTO_TAKEOFF:
            height = (
                p["MIS_TAKEOFF_ALT"] if math.isnan(commander.takeoff_height_m) else commander.takeoff_height_m
            )
            self._velocity[:] = 0.0
            self._target = self._position.copy()
            self._target[2] = min(home[2] - height, self._position[2])
        elif mode is Mode.AUTO_RTL:
            near = np.hypot(*(self._position - home)[:2]) < p["NAV_ACC_RAD"]
            height = p["RTL_DESCEND_ALT"] if near else p["RTL_RETURN_ALT"]
            self._target[2] = min(self._position[2], home[2] - height)
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
        self._advance(dt_s, climb)
        self._turn(dt_s)
        setpoint = self.setpoint[0]
        setpoint["position"] = self._position
        setpoint["velocity"] = self._velocity
        setpoint["acceleration"] = math.nan
        setpoint["yaw"], setpoint["yaw_rate"] = self._yaw, math.nan
        if self._landing:
            setpoint["position"][2] = math.nan
            setpoint["velocity"][2] = self._landing_speed(float(home[2] - estimate["position"][0, 2]))
        if self._mode is Mode.AUTO_TAKEOFF:
            self.finished = abs(self._target[2] - estimate["position"][0, 2]) < 0.2
        return self.setpoint

    def _return(self, home: np.ndarray, dt_s: float) -> None:
        """Climb, fly home, sink, wait, land: move the target when the last one is reached."""
        p = self._parameters
        at_height = abs(self._target[2] - self._position[2]) < 0.5
        if at_height:
            self._target[:2] = home[:2]
        if at_height and np.hypot(*(self._position - home)[:2]) < 0.5:
            self._target[2] = max(self._target[2], home[2] - p["RTL_DESCEND_ALT"])
            if abs(self._target[2] - self._position[2]) < 0.5:
                self._waited_s += dt_s
                self._landing = 0.0 <= p["RTL_LAND_DELAY"] <= self._waited_s

    def _landing_speed(self, height_m: float) -> float:
        """Sinking speed by height over home: fast above ALT1, MPC_LAND_SPEED below ALT2, linear between."""
        p = self._parameters
        heights = (p["MPC_LAND_ALT2"], max(p["MPC_LAND_ALT1"], p["MPC_LAND_ALT2"] + 0.01))
        return float(np.interp(height_m, heights, (p["MPC_LAND_SPEED"], p["MPC_Z_VEL_MAX_DN"])))

    def _stopping_point(self) -> np.ndarray:
        """Where the reference comes to rest when it brakes at once."""
        p = self._parameters
        v = self._velocity
        point = self._position.copy()
        speed = math.hypot(v[0], v[1])
        point[:2] += v[:2] * speed / (2.0 * p["MPC_ACC_HOR"])
        limit = p["MPC_ACC_DOWN_MAX"] if v[2] < 0.0 else p["MPC_ACC_UP_MAX"]
        point[2] += v[2] * abs(v[2]) / (2.0 * limit)
        return point

    def _turn(self, dt_s: float) -> None:
        """Turn the heading towards the wanted one, at most at MPC_YAWRAUTO_MAX."""
        most = math.radians(self._parameters["MPC_YAWRAUTO_MAX"]) * dt_s
        gap = math.remainder(self._wanted_yaw - self._yaw, 2.0 * math.pi)
        self._yaw = math.remainder(self._yaw + min(max(gap, -most), most), 2.0 * math.pi)

    def _advance(self, dt_s: float, climb_speed_m_s: float | None) -> None:
        """Move the reference point towards the target for dt_s."""
        p = self._parameters
        gap = self._target - self._position
        acceleration = p["MPC_ACC_HOR"]
        cruise = p["MPC_XY_CRUISE"] if math.isnan(self._cruise_speed_m_s) else self._cruise_speed_m_s
        distance = math.hypot(gap[0], gap[1])
        wanted = np.zeros(3)
        if distance > 1e-6:
            speed = min(cruise, p["MPC_XY_VEL_MAX"], math.sqrt(2.0 * acceleration * distance), distance / 0.3)
            wanted[:2] = gap[:2] / distance * speed
        up = p["MPC_Z_VEL_MAX_UP"] if climb_speed_m_s is None else climb_speed_m_s
        limit = up if gap[2] < 0.0 else p["MPC_Z_VEL_MAX_DN"]
        brake = p["MPC_ACC_DOWN_MAX"]
        speed = min(limit, math.sqrt(2.0 * brake * abs(gap[2])), abs(gap[2]) / 0.3)
        wanted[2] = math.copysign(speed, gap[2])

        change = wanted - self._velocity
        horizontal = math.hypot(change[0], change[1])
        if horizontal > acceleration * dt_s:
            change[:2] *= acceleration * dt_s / horizontal
        change[2] = min(max(change[2], -p["MPC_ACC_UP_MAX"] * dt_s), brake * dt_s)
        self._velocity += change
        self._position += self._velocity * dt_s
