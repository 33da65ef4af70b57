"""Whether SLAM's pose is sure enough to photograph and to fly by.

After a loop closure, SLAM's correction reaches the pose slowly (`SlowCorrection`), so the UAV is not where it
seems to be for some seconds. And SLAM itself tells whether it tracks the UAV. While the pose is not sure,
what would be photographed is another place than the planned one, and is recorded at the wrong place.
"""

from __future__ import annotations

import math
from enum import IntEnum

UNCERTAIN, LOST = "uncertain", "lost"
"""Words of SLAM's state; any other one is that of a pose that is tracked."""
SETTLED_M, SETTLED_RAD = 0.05, math.radians(1.0)
"""A pose that lacks no more of SLAM's correction is sure."""
UNSURE_M = 1.0
"""Standard deviation of a place while SLAM is not sure of it. Nobody knows it: this is far beyond what a
photograph may have."""
HOVER_S = 1.0
"""A pose that is not sure for so long makes the UAV hover. Most corrections are over sooner."""
LOST_S = 20.0
"""A UAV that is lost for so long comes home: SLAM finds most places again within seconds, or never."""
UNSURE_S = 60.0
"""And one whose pose is not sure for so long, for another reason."""


class Trust(IntEnum):
    """What the pose is good for; the higher, the less."""

    SURE = 0
    UNSURE = 1
    """No photograph is taken; the UAV flies on."""
    HOVER = 2
    COME_HOME = 3


class PoseTrust:
    """Follows SLAM's state, and how much of its correction the pose still lacks.

    Odometry goes on when SLAM is lost. So the UAV can still hover, come home by what SLAM knew last, and
    land.

    Args:
        photographs: places must be right to centimetres. Else only a UAV that is lost counts.

    Attributes:
        reason: why the pose is not sure, in a sentence; empty: it is.
    """

    def __init__(self, photographs: bool) -> None:
        self._photographs = photographs
        self._state, self._off_m, self.reason = "", 0.0, ""
        self._unsure_s: float | None = None
        self._lost_s: float | None = None

    def begin(self) -> None:
        """Begin a flight: for how long the pose was not sure before does not count."""
        self._unsure_s = self._lost_s = None

    def on_state(self, state: str) -> None:
        """Take SLAM's state, in its word."""
        self._state = state

    @property
    def deviation_m(self) -> float:
        """Standard deviation of the place beside the pose's own covariance."""
        return UNSURE_M if self._state in (UNCERTAIN, LOST) else self._off_m

    def at(self, time_s: float, off_m: float = 0.0, off_rad: float = 0.0) -> Trust:
        """Return what the pose is good for at a steady time. off_m, off_rad: that the correction lacks."""
        self._off_m, self.reason = off_m, self._why_unsure(off_m, off_rad)
        self._unsure_s = _since(self._unsure_s, bool(self.reason), time_s)
        self._lost_s = _since(self._lost_s, self._state == LOST, time_s)
        if self._unsure_s is None:
            return Trust.SURE
        is_lost = self._lost_s is not None and time_s - self._lost_s >= LOST_S
        if is_lost or time_s - self._unsure_s >= UNSURE_S:
            return Trust.COME_HOME
        return Trust.HOVER if time_s - self._unsure_s >= HOVER_S else Trust.UNSURE

    def _why_unsure(self, off_m: float, off_rad: float) -> str:
        if self._state == LOST:
            return "SLAM is lost."
        if not self._photographs:
            return ""
        if self._state == UNCERTAIN:
            return "SLAM is not sure where the UAV is."
        if off_m > SETTLED_M or abs(off_rad) > SETTLED_RAD:
            return f"SLAM has moved the pose, which is still {off_m:.2f} m off."
        return ""


def _since(before_s: float | None, holds: bool, time_s: float) -> float | None:
    """Return since when something holds; None: it does not."""
    if not holds:
        return None
    return time_s if before_s is None else before_s
