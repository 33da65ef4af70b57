"""AUTO.RTL: climb to the return altitude, fly home, sink, wait if required, land.

Near home the return altitude is lower: within RTL_MIN_DIST it follows a cone (RTL_CONE_ANG), and over home
the vehicle hardly climbs. A vehicle that stands on the ground stays there.
"""

from __future__ import annotations

import enum
import math
from typing import Callable

import numpy as np

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Severity
from simulation_tools.px4.parameters import Px4Parameters

_NO_DELAY_S = 0.01


class Leg(enum.Enum):
    """The legs of the way home."""

    CLIMB = "climb"
    RETURN = "return"
    DESCEND = "descend"
    LOITER = "loiter"
    LAND = "land"
    LANDED = "landed"


class ReturnHome:
    """Sets a target, leg by leg. Positions in NED, (3,); yaw clockwise from north."""

    def __init__(self, parameters: Px4Parameters, origin: Callable[[], GeodeticOrigin], say: Say) -> None:
        """origin: returns where the local frame begins on earth, for status texts."""
        self._parameters = parameters
        self._origin = origin
        self._say = say
        self._leg = Leg.LANDED
        self._home = self.target = np.zeros(3)
        self._home_yaw_rad = self.yaw_rad = 0.0
        self._return_z = 0.0
        self._waited_s = 0.0

    @property
    def is_landing(self) -> bool:
        """Whether it sinks to land."""
        return self._leg is Leg.LAND

    @property
    def is_landed(self) -> bool:
        """Whether it has landed."""
        return self._leg is Leg.LANDED

    def start(
        self, position: np.ndarray, yaw_rad: float, home: np.ndarray, home_yaw_rad: float, landed: bool
    ) -> None:
        """Begin at a position."""
        p = self._parameters
        self._home, self._home_yaw_rad = home.copy(), home_yaw_rad
        self._inform("RTL HOME activated")
        self._inform("RTL: landing at home position.")
        self._return_z = return_z(position, home, p)
        if landed:
            self._leg = Leg.LANDED
        elif position[2] > home[2] - p["RTL_RETURN_ALT"]:
            self._enter(Leg.CLIMB, position, yaw_rad)
        else:
            self._enter(Leg.RETURN, position, yaw_rad)

    def update(self, position: np.ndarray, yaw_rad: float, landed: bool, dt_s: float) -> None:
        """Go on to the next leg when the vehicle has done this one."""
        if self._leg is Leg.LAND:
            self._leg = Leg.LANDED if landed else Leg.LAND
        elif self._leg is not Leg.LANDED and self._reached(position, yaw_rad, dt_s):
            self._enter(self._next(), position, yaw_rad)

    def _reached(self, position: np.ndarray, yaw_rad: float, dt_s: float) -> bool:
        """Whether position, heading and, for a loiter, time have reached the target."""
        p = self._parameters
        aside_m = math.hypot(*(self.target - position)[:2])
        near = aside_m <= p["NAV_ACC_RAD"] and abs(self.target[2] - position[2]) <= p["NAV_MC_ALT_RAD"]
        turn = abs(math.remainder(self.yaw_rad - yaw_rad, 2.0 * math.pi))
        if not (near and turn < math.radians(p["MIS_YAW_ERR"])):
            return False
        if self._leg is not Leg.LOITER:
            return True
        self._waited_s += dt_s
        return 0.0 <= p["RTL_LAND_DELAY"] <= self._waited_s

    def _next(self) -> Leg:
        waits = abs(self._parameters["RTL_LAND_DELAY"]) > _NO_DELAY_S
        after_return = Leg.DESCEND if waits else Leg.LAND
        return {Leg.CLIMB: Leg.RETURN, Leg.RETURN: after_return, Leg.DESCEND: Leg.LOITER}.get(
            self._leg, Leg.LAND
        )

    def _enter(self, leg: Leg, position: np.ndarray, yaw_rad: float) -> None:
        """Set the target of a leg, and send a status text."""
        p, home = self._parameters, self._home
        self._leg = leg
        self._waited_s = 0.0
        if leg is Leg.CLIMB:
            self._aim(position, self._return_z, yaw_rad)
        elif leg is Leg.RETURN:
            north, east = (home - position)[:2]
            far = math.hypot(north, east) >= p["RTL_MIN_DIST"]
            self._aim(home, self._return_z, math.atan2(east, north) if far else self._home_yaw_rad)
        else:
            waiting_z = max(home[2] - p["RTL_DESCEND_ALT"], position[2], self._return_z)
            self._aim(home, home[2] if leg is Leg.LAND else waiting_z, self._home_yaw_rad)
        self._tell_leg()

    def _aim(self, place: np.ndarray, z: float, yaw_rad: float) -> None:
        self.target = np.array([place[0], place[1], z])
        self.yaw_rad = yaw_rad

    def _tell_leg(self) -> None:
        over_sea_m = math.ceil(self._origin().altitude_m - self.target[2])
        over_home_m = math.ceil(self._home[2] - self.target[2])
        delay_s = self._parameters["RTL_LAND_DELAY"]
        height = f"{over_sea_m} m ({over_home_m} m above destination)"
        self._inform(
            {
                Leg.CLIMB: f"RTL: climb to {height}",
                Leg.RETURN: f"RTL: return at {height}",
                Leg.DESCEND: f"RTL: descend to {height}",
                Leg.LOITER: f"RTL: loiter {delay_s:.1f}s" if delay_s > 0.0 else "RTL: completed, loitering",
                Leg.LAND: "RTL: land at destination",
            }[self._leg]
        )

    def _inform(self, text: str) -> None:
        self._say(Severity.INFO, text)


def return_z(position: np.ndarray, home: np.ndarray, parameters: Px4Parameters) -> float:
    """Return the height at which to fly home, NED z; never below the vehicle.

    Within NAV_ACC_RAD of home the height is twice the distance. Farther away it is at least twice
    NAV_ACC_RAD. Up to RTL_MIN_DIST it is the cone's height at this distance, if that is less than
    RTL_RETURN_ALT.
    """
    p = parameters
    distance_m = math.hypot(*(home - position)[:2])
    if distance_m <= p["NAV_ACC_RAD"]:
        height_m = 2.0 * distance_m
    else:
        height_m = p["RTL_RETURN_ALT"]
        if p["RTL_CONE_ANG"] > 0 and distance_m <= p["RTL_MIN_DIST"]:
            half_angle_deg = min(max(p["RTL_CONE_ANG"], 1.0), 89.0)
            height_m = min(distance_m / math.tan(math.radians(half_angle_deg)), height_m)
        height_m = max(height_m, 2.0 * p["NAV_ACC_RAD"])
    return float(min(home[2] - height_m, position[2]))
