"""PX4's flight modes and their places in MAVLink's heartbeat."""

from __future__ import annotations

import enum
from typing import Mapping


class Mode(enum.Enum):
    """A flight mode; the value is PX4's (main mode, sub mode) of `custom_mode`."""

    MANUAL = (1, 0)
    ALTCTL = (2, 0)
    POSCTL = (3, 0)
    AUTO_TAKEOFF = (4, 2)
    AUTO_LOITER = (4, 3)
    AUTO_MISSION = (4, 4)
    AUTO_RTL = (4, 5)
    AUTO_LAND = (4, 6)
    ACRO = (5, 0)
    OFFBOARD = (6, 0)
    STABILIZED = (7, 0)

    def __init__(self, main: int, sub: int) -> None:
        self.is_auto = main == 4
        """Whether the vehicle flies by itself."""
        self.is_manual = main in (1, 2, 3, 5, 7)
        """Whether a pilot's sticks are needed."""
        self.needs_position = (self.is_auto and sub != 6) or main == 3
        """Whether it cannot go on without a local position; AUTO.LAND can, and OFFBOARD counts setpoints."""

    @property
    def custom_mode(self) -> int:
        """The number in MAVLink's heartbeat."""
        main, sub = self.value
        return main << 16 | sub << 24

    @property
    def label(self) -> str:
        """The name as MAVROS writes it, e.g. ``AUTO.LAND``."""
        return self.name.replace("AUTO_", "AUTO.")

    @property
    def base_mode(self) -> int:
        """Return the flags of MAVLink's heartbeat, without the one for armed."""
        if self.is_auto:
            return 29  # custom, auto, guided, stabilised
        if self is Mode.OFFBOARD:
            return 17  # custom, stabilised
        return 65 if self is Mode.ACRO else 81  # custom, manual input; all but ACRO stabilised


ARMED_FLAG = 128
STABILISED_FLAG = 16
MODE_OF: Mapping[tuple[int, int], Mode] = {mode.value: mode for mode in Mode}
"""By main mode and sub mode."""
MAIN_MODES = frozenset(main for main, _ in MODE_OF)


class Result(enum.IntEnum):
    """MAVLink's MAV_RESULT of a command."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4


class Severity(enum.IntEnum):
    """MAVLink's MAV_SEVERITY of a status text, as far as it is used."""

    EMERGENCY = 0
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    INFO = 6


class LandedState(enum.IntEnum):
    """MAVLink's MAV_LANDED_STATE."""

    ON_GROUND = 1
    IN_AIR = 2
    TAKEOFF = 3
    LANDING = 4
