"""What people order, and which goals it concerns: each one that was sent before it, whatever its state is."""

from __future__ import annotations

from collections import deque
from typing import Iterable

from flight_basics.errand.begun import BegunGoal, Order
from flight_basics.errand.messages import Cancel, Command, Goal

CALLED = "Somebody ended the {} by the service ~abort."
CANCELLED = "Somebody cancelled the goal of the {}."
REMEMBERED = 50
"""Orders that a goal may still meet whose sender the master is asked for."""


class Orders:
    """Takes orders and goals in any order: both tell when they came.

    Args:
        begun: keeps each goal's order, so that it outlives the node. name: of the errand, in sentences.
    """

    def __init__(self, begun: BegunGoal, name: str) -> None:
        self._begun, self._name = begun, name
        self._given: deque[Command | Cancel] = deque(maxlen=REMEMBERED)

    def give(self, order: Command | Cancel, goals: Iterable[Goal | None], flown: str = "") -> None:
        """Take an order. goals: that have come and not ended. flown: identity of what else it concerns."""
        self._given.append(order)
        for goal in goals:
            if goal is not None and _concerns(order, goal):
                self._obey(order, goal.identity)
        if flown:
            self._obey(order, flown)

    def take(self, goal: Goal) -> None:
        """Take a goal. An order that came after it may have been taken before."""
        self._begun.expect(goal.identity)
        for order in self._given:
            if _concerns(order, goal):
                self._obey(order, goal.identity)

    def of(self, goal: Goal) -> Order:
        """Return what people want of a goal."""
        return self._begun.order(goal.identity)

    def _obey(self, order: Command | Cancel, identity: str) -> None:
        before = self._begun.order(identity)
        if isinstance(order, Cancel) or order.name == "abort":
            who = CANCELLED if isinstance(order, Cancel) else CALLED
            now = Order(before.ended or who.format(self._name))
        else:
            now = before._replace(is_paused=order.name == "pause")
        if now != before:
            self._begun.give(identity, now)


def _concerns(order: Command | Cancel, goal: Goal) -> bool:
    is_meant = isinstance(order, Command) or order.name == goal.name
    return is_meant and order.came_ns >= goal.came_ns
