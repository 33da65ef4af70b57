"""Reads a mission's items in the order in which they are flown: DO_JUMP goes back, so many times."""

from __future__ import annotations

from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Severity
from simulation_tools.px4.plan.items import Command, PlanItem
from simulation_tools.px4.plan.plan import Plan

_MOST_JUMPS = 10  # in a row; more is a circle


class Reader:
    """Reads from a plan's current item on."""

    def __init__(self, plan: Plan, say: Say) -> None:
        self._plan = plan
        self._say = say
        self._done: dict[int, int] = {}

    def reset(self) -> None:
        """Forget how often each jump was made."""
        self._done.clear()

    def read(self, for_real: bool) -> PlanItem | None:
        """Return the current item, past jumps; None at the end. for_real: jumps count, `current` moves."""
        index = self._resolve(self._plan.current, for_real)
        if index is None:
            return None
        if for_real:
            self._plan.current = index
        return self._plan.mission[index]

    def next_with_position(self) -> PlanItem | None:
        """Return the next item after the current one that the vehicle flies to."""
        index: int | None = self._plan.current
        for _ in self._plan.mission:
            index = None if index is None else self._resolve(index + 1, False)
            if index is None:
                return None
            if self._plan.mission[index].has_position:
                return self._plan.mission[index]
        return None

    def _resolve(self, index: int, for_real: bool) -> int | None:
        items = self._plan.mission
        for _ in range(_MOST_JUMPS):
            if not 0 <= index < len(items):
                return None
            item = items[index]
            if item.command != Command.JUMP:
                return index
            target, times = item.params[0], item.params[1]
            if self._done.get(index, 0) < times:
                if for_real:
                    self._done[index] = self._done.get(index, 0) + 1
                index = int(target)
            else:
                if for_real:
                    self._say(Severity.INFO, "DO JUMP repetitions completed.")
                index += 1
        self._say(Severity.CRITICAL, "DO JUMP is cycling, giving up.")
        return None
