"""A part of an itinerary: another node flies it, and is asked by an action."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Flown:
    """One flight, from the goal to its result. began_s, ended_s: s. Charges of the battery: 0 to 1."""

    began_s: float
    ended_s: float
    battery_start: float
    battery_end: float

    @property
    def time_s(self) -> float:
        """How long it took."""
        return self.ended_s - self.began_s


class Part(ABC):
    """A part of an itinerary.

    Attributes:
        action: name of the action. result_class: of its result, with `end`, `is_home` and `reason`.
        listens: further topics, each with its class and what takes its messages.
    """

    action: str
    result_class: Any
    listens: tuple[tuple[str, Any, Any], ...] = ()

    @property
    def node(self) -> str:
        """Name of the node that flies it."""
        return self.action.rpartition("/")[0]

    def prepare(self) -> None:  # noqa: B027
        """Prepare it on the ground, if another part was flown before; raises an error of the libraries."""

    def wait(self) -> bool:
        """Wait until it can go on, if it ended to wait on the ground. Return whether it goes on."""
        return True

    @abstractmethod
    def send_goal(self) -> None:
        """Ask for it, or ask to go on with it."""

    @abstractmethod
    def note(self, result: Any, flown: Flown) -> None:
        """Take the result of a flight."""
