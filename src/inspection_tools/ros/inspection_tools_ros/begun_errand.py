"""What a node that dies in flight must know to go on: the goal that it flies, its home, and when it began."""

from __future__ import annotations

from typing import Any, Sequence

import rospy


class BegunErrand:
    """Keeps one errand in the node's parameter ~begun, which outlives the node.

    The goal of the action is latched, so a node that starts again gets it again.
    """

    def __init__(self) -> None:
        self._kept: dict[str, Any] = rospy.get_param("~begun", {})

    def begin(self, goal: str, home_m: Sequence[float], began_s: float) -> None:
        """Keep what is flown. goal: its id. home_m: (x, y, z) in the map's frame."""
        self._keep({"goal": goal, "home": [float(v) for v in home_m], "began": began_s, "has_ended": False})

    def end(self) -> None:
        """Keep that the errand has ended."""
        self._keep({**self._kept, "has_ended": True})

    def is_flown(self, goal: str) -> bool:
        """Whether a goal was begun and has not ended."""
        return self._kept.get("goal") == goal and not self._kept["has_ended"]

    def has_ended(self, goal: str) -> bool:
        """Whether a goal was begun and has ended."""
        return self._kept.get("goal") == goal and bool(self._kept["has_ended"])

    @property
    def home_m(self) -> tuple[float, float, float]:
        """Of the errand that was begun last."""
        x, y, z = self._kept["home"]
        return x, y, z

    @property
    def began_s(self) -> float:
        """When it began, s."""
        return float(self._kept["began"])

    def _keep(self, kept: dict[str, Any]) -> None:
        self._kept = kept
        rospy.set_param("~begun", kept)
