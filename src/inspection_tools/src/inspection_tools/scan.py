"""The directions of a planar scan's beams, and checks of a scan."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_basics.errors import ScanError

FULL_TURN_RAD = 2.0 * math.pi


@dataclass(frozen=True)
class ScanGeometry:
    """Directions of a scan's beams in the lidar's frame: beam i points to `angle_min + i * angle_increment`.

    The increment may be negative (a lidar that turns clockwise, or hangs upside down).

    Raises:
        ScanError: no beams, or angles that are not finite, or an increment of zero or of a turn or more.
    """

    beams: int
    angle_min_rad: float
    angle_increment_rad: float

    def __post_init__(self) -> None:
        if self.beams < 1:
            raise ScanError("The scan has no beams; check the lidar's driver.")
        if not math.isfinite(self.angle_min_rad):
            raise ScanError(f"The scan's angle_min is {self.angle_min_rad}; it must be finite.")
        increment = abs(self.angle_increment_rad)
        if not 0.0 < increment < FULL_TURN_RAD:  # NaN fails this test too
            raise ScanError(
                f"The scan's angle_increment is {self.angle_increment_rad}; "
                "it must be finite, not zero, and less than a turn."
            )

    @property
    def closes_circle(self) -> bool:
        """Whether the last beam and the first are neighbours (or the same direction).

        If a scan continues beyond a turn, they are not: its last beam points elsewhere.
        """
        gap_beams = FULL_TURN_RAD / abs(self.angle_increment_rad) - (self.beams - 1)
        return -0.5 < gap_beams < 1.5

    @property
    def beams_per_turn(self) -> int:
        """How many beams a full turn has at this increment.

        An increment need not divide 360 degrees. Then the step from the last beam to the first is up to half
        an increment shorter or longer than the others.
        """
        return max(round(FULL_TURN_RAD / abs(self.angle_increment_rad)), 1)


def check_range_limits(range_min_m: float, range_max_m: float) -> None:
    """Raise ScanError unless 0 <= range_min < range_max; range_max may be infinite."""
    if not (0.0 <= range_min_m < range_max_m):  # NaN fails this test too
        raise ScanError(
            f"The scan's range_min is {range_min_m} m and its range_max {range_max_m} m; "
            "they must be 0 <= range_min < range_max."
        )
