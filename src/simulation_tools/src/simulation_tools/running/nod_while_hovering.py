"""Decides when a lidar nods: only while the UAV hovers, so that avoidance sees all around while it flies."""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from enum import Enum

from flight_basics.checks import check_limits, limited
from simulation_tools.values import ParameterError

FASTEST_M_S, PUSHED_M_S = 0.1, 0.3
"""The UAV hovers below the first speed. Above the second one it is pushed, and a nod ends."""


class Order(Enum):
    """What the gimbal is to do."""

    NOD = "nod"
    LEVEL = "level"


@dataclass(frozen=True)
class NodTiming:
    """settle_s: the UAV hovers for this time before its lidar nods. duration_s: of the nodding.

    Raises:
        ParameterError: a time is not above 0.
    """

    duration_s: float = limited(MISSING, above=0.0)
    settle_s: float = limited(0.3, above=0.0)

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "The {} of a nod")


class NodWhileHovering:
    """One nod at each place that the UAV was sent to. It ends at once when the UAV is sent on or pushed."""

    def __init__(self, timing: NodTiming) -> None:
        self._timing = timing
        self.restart()

    def restart(self) -> None:
        """Begin anew, as after a clock that jumped back."""
        self._is_done = False
        self._hovers_since_s: float | None = None
        self._nods_since_s: float | None = None

    def update(self, stamp_s: float, speed_m_s: float, is_at_goal: bool) -> Order | None:
        """Take in how the UAV moves; return what the gimbal is to do, None: go on.

        Args:
            stamp_s: time of the speed.
            speed_m_s: of the UAV.
            is_at_goal: whether the position controller has reached its setpoint.
        """
        if not is_at_goal:
            self._is_done = False
        if self._nods_since_s is not None:
            return self._while_nodding(stamp_s, speed_m_s, is_at_goal)
        if self._is_done or not is_at_goal or not speed_m_s <= FASTEST_M_S:
            self._hovers_since_s = None
            return None
        if self._hovers_since_s is None:
            self._hovers_since_s = stamp_s
        if stamp_s - self._hovers_since_s < self._timing.settle_s:
            return None
        self._nods_since_s = stamp_s
        return Order.NOD

    def _while_nodding(self, stamp_s: float, speed_m_s: float, is_at_goal: bool) -> Order | None:
        assert self._nods_since_s is not None
        if is_at_goal and speed_m_s <= PUSHED_M_S:
            if stamp_s - self._nods_since_s < self._timing.duration_s:
                return None
            self._is_done = True
        self._hovers_since_s = self._nods_since_s = None
        return Order.LEVEL
