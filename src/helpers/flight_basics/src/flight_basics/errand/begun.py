"""The goal of an action that a node flies: what it must know to go on if it dies in flight."""

from __future__ import annotations

from typing import Any, Mapping, Protocol


class Kept(Protocol):
    """Outlives the node; as `node_tools.restarts.kept_parameter.KeptParameter`. values: what is kept."""

    values: dict[str, Any]

    def keep(self, values: Mapping[str, Any]) -> None:
        """Keep these in place of what was kept."""


class BegunGoal:
    """Keeps one goal.

    The goal is latched, so a node that starts again gets it again. A goal of another launch, or of a node
    that was told to end by a signal, belongs to nobody any more, and is not found.
    """

    def __init__(self, kept: Kept) -> None:
        self._kept = kept
        self._ended_before = kept.values["goal"] if kept.values.get("has_ended") else ""

    def begin(self, identity: str, known: Mapping[str, Any]) -> None:
        """Keep what is flown. identity: of the goal. known: what to find again, as `home` and `began`."""
        self._kept.keep({"goal": identity, "has_ended": False, **known})

    def keep(self, known: Mapping[str, Any]) -> None:
        """Keep something new of the goal that is flown."""
        self._kept.keep({**self._kept.values, **known})

    def end(self) -> None:
        """Keep that the goal has ended."""
        if self._kept.values:
            self._kept.keep({**self._kept.values, "has_ended": True})

    def is_flown(self, identity: str) -> bool:
        """Whether a goal was begun and has not ended."""
        return self._kept.values.get("goal") == identity and not self._kept.values["has_ended"]

    def had_ended(self, identity: str) -> bool:
        """Whether a goal had ended before the node started again. It comes again, because it is latched."""
        return identity == self._ended_before

    @property
    def known(self) -> Mapping[str, Any]:
        """What is known of the goal that was begun last."""
        return self._kept.values
