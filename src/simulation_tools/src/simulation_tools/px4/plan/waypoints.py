"""What the navigator flies: where from, where to and where next."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

import numpy as np


class Kind(enum.Enum):
    """What the vehicle does at a waypoint."""

    IDLE = "stay on the ground"
    TAKEOFF = "take off"
    POSITION = "fly through"
    LOITER = "stop there"
    LAND = "sink until landed"


@dataclass(frozen=True)
class Waypoint:
    """A place in NED, (3,); yaw clockwise from north, NaN: where MPC_YAW_MODE points."""

    kind: Kind
    place: np.ndarray
    yaw_rad: float
    radius_m: float

    def equals(self, other: Waypoint | None) -> bool:
        """Whether both are the same."""
        if other is None or self.kind is not other.kind or self.radius_m != other.radius_m:
            return False
        both_free = math.isnan(self.yaw_rad) and math.isnan(other.yaw_rad)
        return bool((self.place == other.place).all()) and (both_free or self.yaw_rad == other.yaw_rad)


@dataclass(frozen=True)
class Route:
    """The waypoint that is flown to, and the places before and after it, NED (3,), if there are any."""

    current: Waypoint
    previous: np.ndarray | None = None
    next: np.ndarray | None = None


@dataclass(frozen=True)
class Vehicle:
    """What a mission needs to know of the vehicle. NED; time in s of simulation."""

    time_s: float
    position: np.ndarray
    yaw_rad: float
    home: np.ndarray
    landed: bool
    maybe_landed: bool


@dataclass
class ActiveItem:
    """The item that is flown, changed by what PX4 inserts. Place in NED.

    then_z: the height to go to over the place.
    """

    command: int
    place: np.ndarray = field(default_factory=lambda: np.zeros(3))
    yaw_rad: float = math.nan
    stay_s: float = 0.0
    radius_m: float = 0.0
    autocontinue: bool = True
    then_z: float | None = None
