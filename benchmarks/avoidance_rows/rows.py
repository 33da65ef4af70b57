"""The rows of the table and what each is to reach."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

JUDGED, COMPARED = "dynamic", "improved"
"""The algorithm that has goals, and the one whose time it must not exceed where a goal says so."""


@dataclass(frozen=True)
class Goal:
    """What the flights of a row at some speeds are to reach; none of them may touch anything.

    clearance_m: the least of all flights. reached: share. time_ratio: mean time over that of the straight
    way, of the flights that arrived. no_slower: than `COMPARED`, in the places where both arrived.
    """

    speeds_m_s: tuple[float, ...]
    reached: float = 0.0
    clearance_m: float | None = None
    time_ratio: float | None = None
    no_slower: bool = False


@dataclass(frozen=True)
class Row:
    """A row. campaign: its file in config/campaigns. p99_ms: most computation time of 99 % of the answers."""

    name: str
    what: str
    goals: tuple[Goal, ...]
    p99_ms: float = 5.0

    @property
    def campaign(self) -> str:
        """The name of the campaign's file."""
        return f"avoidance_{self.name}"

    def places(self, trials: pd.DataFrame) -> pd.Series:
        """Return the place of each trial, as the keys name it: its world."""
        return trials["world"].rename("place")

    def goal(self, speed_m_s: float) -> Goal | None:
        """Return the goal at a speed, or None."""
        return next((goal for goal in self.goals if speed_m_s in goal.speeds_m_s), None)


SPACED = Row(
    "spaced",
    "forests, trunks 2 m apart",
    (
        Goal((4.0,), reached=0.95, clearance_m=0.05, time_ratio=2.3),
        Goal((2.0, 3.0), reached=0.98, no_slower=True),
    ),
)

REAL_TIME = Row("ros", "forests, trunks 2 m apart, through all ROS nodes in real time", (Goal((4.0,)),))

ROWS = (
    SPACED,
    Row(
        "thick",
        "thick forests",
        (
            Goal((2.0,), reached=0.95, clearance_m=0.05),
            Goal((3.0,), reached=0.92, clearance_m=0.05),
            Goal((4.0,), reached=0.90, clearance_m=0.05),
        ),
    ),
    Row("dead_ends", "dead ends and offices", (Goal((2.0,), reached=0.90),)),
    Row("moving", "something crosses or comes head-on", (Goal((2.0, 4.0), reached=0.95),)),
    Row("overhead", "over and under things, Puck", (Goal((2.0, 4.0), reached=0.95),), p99_ms=10.0),
    REAL_TIME,
)
