"""The items of a plan: what PX4 takes from MAVLink's mission items, and what it keeps of them."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Sequence

from simulation_tools.geodesy import GeodeticOrigin


class PlanError(Exception):
    """An item that PX4 does not take. `result` is MAVLink's MAV_MISSION_RESULT."""

    def __init__(self, result: int) -> None:
        super().__init__(f"MAV_MISSION_RESULT {result}")
        self.result = result


UNSUPPORTED_FRAME, UNSUPPORTED = 2, 3
_INVALID_PARAM1, _INVALID_X, _INVALID_Y, _INVALID_Z = 6, 10, 11, 12
_INT32 = 2.0**31


class Command(enum.IntEnum):
    """MAV_CMD of the items that mean something here."""

    WAYPOINT = 16
    LOITER_UNLIMITED = 17
    LOITER_TIME = 19
    RETURN_TO_LAUNCH = 20
    LAND = 21
    TAKEOFF = 22
    LOITER_TO_ALTITUDE = 31
    NAV_ROI = 80
    DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    JUMP = 177
    CHANGE_SPEED = 178
    SET_HOME = 179
    LAND_START = 189
    SET_ROI_LOCATION = 195
    SET_ROI_NONE = 197
    SET_ROI = 201
    FENCE_RETURN_POINT = 5000
    FENCE_POLYGON_INCLUSION = 5001
    FENCE_POLYGON_EXCLUSION = 5002
    FENCE_CIRCLE_INCLUSION = 5003
    FENCE_CIRCLE_EXCLUSION = 5004


# Cameras, gimbals, servos: PX4 passes these on to others, and there are none here.
PAYLOAD_COMMANDS = frozenset(
    (183, 200, 203, 204, 205, 206, 214, 260, 530, 531, 532, 1000, 1001, 2000, 2001, 2003, 2500, 2501)
)
WITH_POSITION = frozenset(
    (
        Command.WAYPOINT,
        Command.LOITER_UNLIMITED,
        Command.LOITER_TIME,
        Command.LAND,
        Command.TAKEOFF,
        Command.LOITER_TO_ALTITUDE,
    )
)
FENCE_COMMANDS = frozenset(range(Command.FENCE_RETURN_POINT, Command.FENCE_CIRCLE_EXCLUSION + 1))

# The parameters (1 to 4) that PX4 keeps of an item with a place. It gives back 0 for the others.
_KEPT: dict[int, tuple[int, ...]] = {
    Command.WAYPOINT: (1, 2, 4),
    Command.LOITER_UNLIMITED: (3, 4),
    Command.LOITER_TIME: (1, 2, 3, 4),
    Command.LAND: (2, 4),
    Command.TAKEOFF: (4,),
    Command.LOITER_TO_ALTITUDE: (1, 2, 4),
    Command.NAV_ROI: (1,),
    Command.SET_ROI: (1,),
    Command.SET_ROI_LOCATION: (),
    **dict.fromkeys(FENCE_COMMANDS, (1,)),
}
_WITH_YAW = (Command.WAYPOINT, Command.LOITER_UNLIMITED, Command.LOITER_TIME, Command.LAND, Command.TAKEOFF)
_WITHOUT_PLACE = frozenset(
    (
        Command.RETURN_TO_LAUNCH,
        Command.NAV_ROI,
        Command.DELAY,
        Command.CONDITION_DELAY,
        Command.CONDITION_DISTANCE,
        Command.JUMP,
        Command.CHANGE_SPEED,
        Command.SET_HOME,
        Command.LAND_START,
        Command.SET_ROI_NONE,
        Command.SET_ROI,
    )
)
_COUNTED = {Command.JUMP: (1, 2), **dict.fromkeys(FENCE_COMMANDS - {Command.FENCE_RETURN_POINT}, (1,))}
"""Parameters (1 to 4) that must be numbers: a count, an index or a radius. Another NaN asks for nothing."""
GLOBAL_FRAMES, RELATIVE_FRAMES, MISSION_FRAME = (0, 5), (3, 6), 2
_INT_FRAMES = (5, 6)
_ROI_COMMANDS, _ROI_NONE, _ROI_LOCATION = (Command.NAV_ROI, Command.SET_ROI), 0, 3


@dataclass(frozen=True)
class PlanItem:
    """One item. x, y: degrees in a global frame; z: m over the sea, or over home in a relative frame."""

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: float
    y: float
    z: float
    autocontinue: bool = True

    @classmethod
    def accepted(
        cls,
        command: int,
        frame: int,
        params: Sequence[float],
        place: tuple[float, float, float],
        autocontinue: bool,
        is_int: bool,
    ) -> PlanItem:
        """Return the item as PX4 keeps it; raises PlanError, also for numbers by which nobody can fly.

        is_int: it came as MISSION_ITEM_INT; only then PX4 takes the frames 5 and 6.
        """
        p1, p2, p3, p4 = params
        _refuse_nonsense(command, params)
        if frame == MISSION_FRAME:
            if command not in _WITHOUT_PLACE and command not in PAYLOAD_COMMANDS:
                raise PlanError(UNSUPPORTED)
            if command in _ROI_COMMANDS and p1 != _ROI_NONE:
                raise PlanError(_INVALID_PARAM1)
            return cls(command, frame, (p1, p2, p3, p4), *_unused(place), autocontinue)
        if frame not in GLOBAL_FRAMES + RELATIVE_FRAMES or (frame in _INT_FRAMES and not is_int):
            raise PlanError(UNSUPPORTED_FRAME)
        if command not in _KEPT:
            raise PlanError(UNSUPPORTED)
        if command in _ROI_COMMANDS and p1 not in (_ROI_NONE, _ROI_LOCATION):
            raise PlanError(_INVALID_PARAM1)
        for value, most, result in zip(place, (90.0, 180.0, 1e5), (_INVALID_X, _INVALID_Y, _INVALID_Z)):
            if not abs(value) <= most:  # true for NaN, too
                raise PlanError(result)
        if command in _WITH_YAW and math.isfinite(p4):
            p4 %= 360.0
        given = (p1, p2, p3, p4)
        p1, p2, p3, p4 = (given[i] if i + 1 in _KEPT[command] else 0.0 for i in range(4))
        return cls(command, frame, (p1, p2, p3, p4), *place, autocontinue)

    @property
    def has_position(self) -> bool:
        """Whether the vehicle flies to it."""
        return self.command in WITH_POSITION

    @property
    def has_place(self) -> bool:
        """Whether x and y are a latitude and a longitude."""
        return self.frame != MISSION_FRAME

    @property
    def is_relative(self) -> bool:
        """Whether its altitude is over home."""
        return self.frame in RELATIVE_FRAMES

    @property
    def roi(self) -> tuple[float, float] | None:
        """The place to look at, of an item that sets one: latitude and longitude. None: nothing any more."""
        is_place = self.command == Command.SET_ROI_LOCATION or self.params[0] == _ROI_LOCATION
        return (self.x, self.y) if self.has_place and is_place else None

    @property
    def sets_roi(self) -> bool:
        """Whether it says what to look at."""
        return self.command in (*_ROI_COMMANDS, Command.SET_ROI_LOCATION, Command.SET_ROI_NONE)

    @property
    def yaw_rad(self) -> float:
        """Heading clockwise from north; NaN: none asked for."""
        return math.radians(self.params[3]) if self.command in _WITH_YAW else math.nan

    @property
    def stay_s(self) -> float:
        """How long the vehicle stays, s."""
        stays = self.command in (Command.WAYPOINT, Command.LOITER_TIME, Command.DELAY)
        return max(self.params[0], 0.0) if stays and math.isfinite(self.params[0]) else 0.0

    @property
    def radius_m(self) -> float:
        """The acceptance radius that it asks for; 0: none."""
        radius = self.params[1] if self.command == Command.WAYPOINT else 0.0
        return radius if math.isfinite(radius) and radius > 0.0 else 0.0

    def position_ned_m(self, origin: GeodeticOrigin, home_z: float) -> tuple[float, float, float]:
        """Return its place in NED. home_z: NED z of home."""
        north, east = origin.to_local(self.x, self.y)
        return north, east, home_z - self.z if self.is_relative else origin.altitude_m - self.z


def _refuse_nonsense(command: int, params: Sequence[float]) -> None:
    """Raise PlanError if a parameter is infinite, or is NaN where a number is needed."""
    for number, value in enumerate(params, 1):
        if math.isinf(value) or (math.isnan(value) and number in _COUNTED.get(command, ())):
            raise PlanError(_INVALID_PARAM1 + number - 1)


def _unused(place: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the fields x, y and z of an item without a place, which may be NaN; raises PlanError.

    x and y travel as whole numbers.
    """
    x, y = (0.0 if math.isnan(value) else value for value in place[:2])
    for value, result in ((x, _INVALID_X), (y, _INVALID_Y)):
        if not abs(value) < _INT32:
            raise PlanError(result)
    if math.isinf(place[2]):
        raise PlanError(_INVALID_Z)
    return x, y, place[2]
