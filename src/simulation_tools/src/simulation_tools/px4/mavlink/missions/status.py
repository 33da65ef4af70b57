"""What a ground station hears of a mission in flight: MISSION_CURRENT and MISSION_ITEM_REACHED."""

from __future__ import annotations

from typing import Iterator

from pymavlink.dialects.v20 import common

from simulation_tools.px4.plan.mission import Mission
from simulation_tools.px4.plan.plan import Plan

_STATUS_PERIOD_US = 100_000
_REACHED_REPEATS = 10


class MissionStatus:
    """MISSION_CURRENT and MISSION_ITEM_REACHED: on each change, and ten times a second."""

    def __init__(self, plan: Plan, mission: Mission) -> None:
        self._plan = plan
        self._mission = mission
        self.reset()

    def reset(self) -> None:
        """Begin again, as simulation time does."""
        self._due_us = 0
        self._current: int | None = None
        self._reached = -1
        self._repeats = 0

    def due(self, time_us: int) -> Iterator[common.MAVLink_message]:
        """Yield what is to be sent now; nothing without a mission."""
        last = len(self._plan.mission) - 1
        if last < 0:
            return
        current, reached = min(self._plan.current, last), self._mission.reached
        is_new = reached != self._reached and reached >= 0
        if reached != self._reached:
            self._reached, self._repeats = reached, _REACHED_REPEATS
        if time_us < self._due_us and current == self._current and not is_new:
            return
        self._due_us, self._current = time_us + _STATUS_PERIOD_US, current
        if is_new or (reached >= 0 and self._repeats > 0):
            self._repeats -= 1
            yield common.MAVLink_mission_item_reached_message(reached)
        yield common.MAVLink_mission_current_message(current)
