"""The goals of an errand: which one is flown, which one waits for its answer, and how each is ended, once."""

from __future__ import annotations

import math

from flight_basics.errand.leader import Outcome
from flight_basics.errand.messages import Goal
from flight_basics.errand.outputs import End, Finish

REPLACED = "This goal was canceled because another one came."


class GoalDesk:
    """Takes goals, and returns what ends in their place.

    Attributes:
        new: the newest goal, which is not answered yet.
        flown: the goal of the flight; None: there is no flight, or its goal was replaced.
    """

    def __init__(self) -> None:
        self.new: Goal | None = None
        self.flown: Goal | None = None
        self._until_s = self._newest_stamp_s = -math.inf

    def take(self, goal: Goal, until_s: float) -> list[Finish]:
        """Take a goal that was accepted. until_s: wall time until which it may wait for what is missing.

        An older goal than the newest one is ended at once: a latched one of before, which a restart hears.
        """
        if goal.stamp_s < self._newest_stamp_s:
            return [Finish(goal, End.CANCELED, REPLACED)]
        before = [each for each in (self.new, self.flown) if each is not None]
        self.new, self.flown = goal, None
        self._until_s, self._newest_stamp_s = until_s, goal.stamp_s
        return [Finish(each, End.CANCELED, REPLACED) for each in before]

    def note_clock_set_back(self) -> None:
        """Let the next goal be the newest one, whatever its stamp."""
        self._newest_stamp_s = -math.inf

    def is_due(self, missing: str, longer_s: float, now_s: float) -> bool:
        """Return whether the new goal is to be answered. missing: what it waits for; longer_s: if need be."""
        return self.new is not None and (not missing or now_s >= self._until_s + longer_s)

    def refuse(self, why: str) -> Finish:
        """End the new goal."""
        assert self.new is not None
        refused, self.new = self.new, None
        return Finish(refused, End.ABORTED, why)

    def begin(self) -> None:
        """The new goal is flown now."""
        self.flown, self.new = self.new, None

    def end(self, outcome: Outcome) -> list[Finish]:
        """The flight is over."""
        flown, self.flown = self.flown, None
        return [] if flown is None else [Finish(flown, End(outcome.end), outcome.words, has_result=True)]
