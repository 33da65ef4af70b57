"""The goal of an action that a node flies, and what people ordered: what it must know to go on if it dies."""

from __future__ import annotations

from typing import Any, Mapping, NamedTuple, Protocol


class Kept(Protocol):
    """Outlives the node; as `node_tools.restarts.kept_parameter.KeptParameter`. values: what is kept."""

    values: dict[str, Any]

    def keep(self, values: Mapping[str, Any]) -> None:
        """Keep these in place of what was kept."""


class Order(NamedTuple):
    """What people want of a goal. ended: who has ended it, in a sentence; empty: nobody."""

    ended: str = ""
    is_paused: bool = False


class BegunGoal:
    """Keeps one flight: the goal that began last, and the order of each goal that has not ended.

    The goal is latched, so a node that starts again gets it again. A goal of another launch, or of a node
    that was told to end by a signal, belongs to nobody any more, and is not found.
    """

    def __init__(self, kept: Kept) -> None:
        self._kept = kept
        self._ended_before = kept.values["goal"] if kept.values.get("has_ended") else ""

    def begin(self, identity: str, known: Mapping[str, Any]) -> None:
        """Keep what is flown. identity: of the goal. known: what to find again, as `home` and `began`."""
        orders = [each for each in self._orders if each[0] == identity]
        self._kept.keep({"goal": identity, "has_ended": False, "orders": orders, **known})

    def keep(self, known: Mapping[str, Any]) -> None:
        """Keep something new of the goal that is flown."""
        self._kept.keep({**self._kept.values, **known})

    def end(self) -> None:
        """Keep that the goal has ended."""
        if self._kept.values:
            self.keep({"has_ended": True, "orders": []})

    @property
    def flown(self) -> str:
        """The identity of the goal that was begun and has not ended; empty: there is none."""
        return "" if self._kept.values.get("has_ended", True) else str(self._kept.values["goal"])

    def had_ended(self, identity: str) -> bool:
        """Whether a goal had ended before the node started again. It comes again, because it is latched."""
        return identity == self._ended_before

    @property
    def known(self) -> Mapping[str, Any]:
        """What is known of the goal that was begun last."""
        return self._kept.values

    @property
    def _orders(self) -> list[list[Any]]:
        return list(self._kept.values.get("orders", ()))

    def is_of_this_flight(self, identity: str) -> bool:
        """Whether a goal is flown, or came while the goal before it was."""
        return bool(self.flown) and identity in (self.flown, *(each[0] for each in self._orders))

    def expect(self, identity: str) -> None:
        """A goal has come. It is of the flight that is flown. Another one that was expected has ended."""
        orders = [each for each in self._orders if each[0] in (self.flown, identity)]
        if self.flown not in ("", identity) and identity not in [each[0] for each in orders]:
            orders.append([identity, *Order()])
        if orders != self._orders:
            self.keep({"orders": orders})

    def order(self, identity: str) -> Order:
        """Return what people want of a goal."""
        return next((Order(*each[1:]) for each in self._orders if each[0] == identity), Order())

    def give(self, identity: str, order: Order) -> None:
        """Keep what people want of a goal that is flown, or is to be."""
        others = [each for each in self._orders if each[0] != identity]
        self.keep({"orders": [*others, [identity, *order]]})
