"""The rows of the table and what each is to reach."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Mapping

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
    """A row. p99_ms: the most computation time of 99 % of the answers.

    worse: places that differ by a condition instead of a world: the column and the value of each.
    """

    name: str
    what: str
    goals: tuple[Goal, ...]
    p99_ms: float = 5.0
    worse: Mapping[str, tuple[str, Any]] = field(default_factory=dict)

    @property
    def campaign(self) -> str:
        """The name of the campaign's file in config/campaigns."""
        return f"avoidance_{self.name}"

    def places(self, trials: pd.DataFrame) -> pd.Series:
        """Return the place of each trial, as the keys name it."""
        places = trials["world"].rename("place")
        for name, (column, value) in self.worse.items():
            places = places.mask(trials[column] == value, name)
        return places

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
    Row("abreast", "two to eight people abreast come head-on", (Goal((2.0, 4.0), reached=0.90),)),
    Row(
        "sinking",
        "a load comes down; range finders",
        (Goal((1.0,), reached=0.90),),
        worse={lidar: ("lidar", lidar) for lidar in ("ust", "puck", "qt64")},
    ),
    Row("small_uav", "a small UAV from any quarter, Puck", (Goal((2.0,), reached=0.95),), p99_ms=10.0),
    Row("keep_out", "forests with keep-out boxes", (Goal((2.0, 4.0), reached=0.90),)),
    Row("overhead", "over and under things, Puck", (Goal((2.0, 4.0), reached=0.95),), p99_ms=10.0),
    Row(
        "adverse",
        "forests, trunks 2 m apart, in worse conditions",
        (Goal((2.0, 4.0), reached=0.90),),
        worse={
            "urg": ("lidar", "urg"),
            "noise": ("lidar_noise_factor", 3.0),
            "lost_scans": ("scan_loss", 0.2),
            "late_odometry": ("odometry_delay_s", 0.15),
            "wind": ("wind_m_s", 5.0),
        },
    ),
    Row(
        "flicker",
        "what a lidar hardly sees",
        (Goal((2.0,), reached=0.90),),
        worse={"glass_30_deg": ("glass_deg", 30.0), "lost_view": ("lost_view", 0.2)},
    ),
    Row(
        "rain",
        "forests, trunks 2 m apart, in rain",
        (Goal((2.0,), reached=0.95),),
        worse={"rain_2": ("rain", 0.02), "rain_5": ("rain", 0.05)},
    ),
    Row(
        "deep_dead_ends",
        "dead ends deeper than the lidar sees",
        (Goal((2.0,), reached=0.95),),
        worse={f"deep_{depth}_m": ("depth_m", float(depth)) for depth in (12, 15, 20)},
    ),
    Row(
        "doors",
        "rooms one after the other, with narrow doors",
        (Goal((2.0,), reached=0.95),),
        worse={f"doors_{door:g}_m": ("door_m", door) for door in (0.9, 1.0, 1.2)},
    ),
    Row(
        "bug_traps",
        "a U, two lips, a spiral, a wall with a gap",
        (Goal((2.0,), reached=0.95),),
        worse={f"trap_{trap}": ("trap", trap) for trap in ("u", "double_lip", "spiral", "gap")},
    ),
    Row(
        "manholes",
        "manholes of 0.6 x 0.8 m, the small airframe, QT64; something may be behind the first one",
        (Goal((0.8,), reached=1.0),),
        worse={"person_behind": ("behind", "person"), "hose_behind": ("behind", "hose")},
    ),
    REAL_TIME,
    Row("clear", "nothing is near", (Goal((2.0, 4.0), reached=1.0),), p99_ms=0.05),
    Row(
        "without_window",
        "thick forests, no ways out",
        (Goal((2.0, 4.0)),),
        p99_ms=2.0,
        worse={"without_window": ("cepa.window_m", 0.0)},
    ),
)
