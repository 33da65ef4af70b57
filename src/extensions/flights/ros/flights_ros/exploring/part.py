"""The exploration as a part of an itinerary: the node `explore` flies it."""

from __future__ import annotations

import math
import uuid
from dataclasses import dataclass, field
from typing import Any

import rospy
from nav_msgs.msg import Odometry

from exploration.msg import ExploreActionFeedback, ExploreActionGoal, ExploreActionResult, ExploreResult
from flights.flight.monitor import Monitor
from flights_ros.drivers.part import Flown, Part
from flights_ros.drivers.progress import FlightProgress
from node_tools.conversions import xyz

COLUMNS = ("t_s", "known_m3", "home_way_m", "home_time_s", "home_energy_wh", "charge")
"""Of the rows of `ExplorationRecord.known`, in exploration.csv."""

Z_VARIANCE = 14
"""In the covariance of nav_msgs/Odometry, row by row."""
TOLD_M2 = 1e4
"""Drivers that do not know a variance tell a greater one."""


@dataclass
class ExplorationRecord:
    """What the action told. flights: that explored. known: rows of `COLUMNS`.

    height_uncertain_m: the greatest standard deviation of odometry's height meanwhile; None: it told none.
    """

    result: ExploreResult | None = None
    flights: list[Flown] = field(default_factory=list)
    known: list[tuple[float, ...]] = field(default_factory=list)
    height_uncertain_m: float | None = None


class ExplorationPart(Part):
    """Lets the node `explore` explore to the end.

    Listens: /explore/explore/feedback (exploration/ExploreActionFeedback), odometry (nav_msgs/Odometry).
    Publishes: /explore/explore/goal (exploration/ExploreActionGoal, latched).

    Args:
        monitor: tells the time. time_s: after it the UAV comes home.

    Attributes:
        explored: what was told.
    """

    action, result_class = "/explore/explore", ExploreActionResult

    def __init__(self, monitor: Monitor, time_s: float) -> None:
        self._monitor, self._time_s, self.explored = monitor, time_s, ExplorationRecord()
        self._progress, self._began_s = FlightProgress(), monitor.now_s
        self._goal = rospy.Publisher(f"{self.action}/goal", ExploreActionGoal, queue_size=1, latch=True)
        self.listens = (
            (f"{self.action}/feedback", ExploreActionFeedback, self._on_feedback),
            ("odometry", Odometry, self._on_odometry),
        )

    def send_goal(self) -> None:
        """Begin to explore, or go on."""
        goal = ExploreActionGoal()
        goal.goal_id.id = f"the exploration {uuid.uuid4()}"
        goal.goal.time_max = self._time_s
        self._goal.publish(goal)
        self._began_s = self._monitor.now_s
        rospy.loginfo("The UAV hovers and begins to explore.")

    def note(self, result: ExploreResult, flown: Flown) -> None:
        """Take the result."""
        self.explored.result = result
        self.explored.flights.append(flown)

    def _on_odometry(self, odometry: Odometry) -> None:
        explored, variance_m2 = self.explored, odometry.pose.covariance[Z_VARIANCE]
        if explored.known and explored.result is None and 0.0 <= variance_m2 < TOLD_M2:
            explored.height_uncertain_m = max(explored.height_uncertain_m or 0.0, math.sqrt(variance_m2))

    def _on_feedback(self, message: ExploreActionFeedback) -> None:
        told = message.feedback
        row = (self._monitor.now_s, told.known, told.home_way, told.home_time, told.home_energy, told.charge)
        self.explored.known.append(row)
        self._progress.tell(
            told.phase,
            f"{self._monitor.now_s - self._began_s:.0f} s of simulated time, at most {self._time_s:.0f} s",
            f"{told.known:.0f} m3 known",
            home_way_m=told.home_way,
            charge=told.charge,
        )


def figures(explored: ExplorationRecord, swaps: int) -> dict[str, Any]:
    """Return them for result.json."""
    result = explored.result
    if result is None:
        return {"end": "", "reason": "The exploration told no result."}
    left = zip(result.unknown_places, result.unknown_areas, result.unknown_reasons)
    began_s, ended_s = explored.flights[0].began_s, explored.flights[-1].ended_s
    known = [row for row in explored.known if row[1] >= 0.99 * result.known]
    return {
        "end": result.end,
        "reason": result.reason,
        "is_home": result.is_home,
        "known_m3": result.known,
        "views": result.views,
        "height_uncertain_m": explored.height_uncertain_m,
        "swaps": swaps,
        "time_99_s": known[0][0] - began_s if known else None,
        "home_s": ended_s - began_s,
        "unknown": [{"place_m": xyz(place), "border_m2": area, "why": why} for place, area, why in left],
    }
