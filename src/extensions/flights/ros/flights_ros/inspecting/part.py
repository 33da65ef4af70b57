"""The photographs as a part of an itinerary: the node `inspect` takes them."""

from __future__ import annotations

import threading
import time
import uuid
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable

import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String

from flights.inspecting.coverage import TruePose
from flights.inspecting.request import InspectingRequest
from flights_ros.drivers.messages import pose_values, stamp_s
from flights_ros.drivers.part import Flown, Part
from flights_ros.drivers.progress import FlightProgress
from inspection.flight import End
from inspection.flight.second_look import SearchState
from inspection.msg import SurveyActionFeedback, SurveyActionGoal, SurveyActionResult, SurveyResult
from inspection.photographs.listing import photographs_in
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan

WAKE_S = 0.5
"""Wall time between two looks whether ROS shuts down."""
ENDS = {
    SearchState.ABORTED: (End.ABORTED, "The search of the photographs was aborted."),
    SearchState.DONE: (End.DONE, "The photographs are searched, and no more is to be photographed."),
}
"""With which a UAV that has landed to wait for the search takes off no more."""
MakePlan = Callable[[], SurveyPlan]
"""Writes plan.yaml into the run's folder; raises an error of the libraries."""


@dataclass
class Photographed:
    """What was told. flights: photographs of each, first. truths: of the camera, by a photograph's stamp."""

    result: SurveyResult | None = None
    flights: list[tuple[int, Flown]] = field(default_factory=list)
    truths: dict[float, TruePose] = field(default_factory=dict)

    @property
    def flight_s(self) -> float:
        """Of all flights, each from its goal to its result."""
        return sum(flown.time_s for _, flown in self.flights)


class SurveyPart(Part):
    """Lets the node `inspect` take all photographs.

    Listens: /camera/ground_truth (geometry_msgs/PoseStamped), /inspect/search (std_msgs/String),
        /inspect/survey/feedback (inspection/SurveyActionFeedback).
    Publishes: /inspect/survey/goal (inspection/SurveyActionGoal, latched).

    Args:
        request: see there. folder: of the run. make_plan: see there.

    Attributes:
        photographed: what was told. plan: that is flown; None: it is not made yet.
    """

    action, result_class = "/inspect/survey", SurveyActionResult

    def __init__(self, request: InspectingRequest, folder: Path, make_plan: MakePlan) -> None:
        self._request, self._folder, self._make_plan = request, folder, make_plan
        self.photographed = Photographed()
        self.plan: SurveyPlan | None = None
        self._goal = rospy.Publisher(f"{self.action}/goal", SurveyActionGoal, queue_size=1, latch=True)
        self._is_ready = threading.Event()
        self._is_ready.set()
        self._search, self._progress = SearchState.IDLE, FlightProgress()
        self.listens = (
            ("/camera/ground_truth", PoseStamped, self._on_camera),
            ("/inspect/search", String, self._on_search),
            (f"{self.action}/feedback", SurveyActionFeedback, self._on_feedback),
        )

    def prepare(self) -> None:
        """Make the plan."""
        self.plan = self._make_plan()

    def read_whole_plan(self) -> bool:
        """Read the plan again if it was a draft: it was completed in flight. Return whether it was one.

        Raises: SurveyError: it cannot be read.
        """
        if self.plan is None or self.plan.draft is None:
            return False
        self.plan = read_plan(self._folder / "plan.yaml")
        return True

    def wait(self) -> bool:
        """Wait until the photographs are searched, and say so. Return whether it goes on."""
        began_s = time.monotonic()
        while not self._is_ready.wait(WAKE_S) and not rospy.is_shutdown():
            so_far = f"{time.monotonic() - began_s:.0f} s so far"
            self._progress.tell("searching the photographs", so_far, "rosservice call /inspect/abort ends it")
        end = ENDS.get(self._search)
        told = self.photographed.result
        if end is not None and told is not None:
            told.end, told.reason = end[0].value, end[1]
        return end is None

    def send_goal(self) -> None:
        """Begin the survey, or go on with what its folder lacks."""
        message = SurveyActionGoal()
        message.goal_id.id = f"the survey {uuid.uuid4()}"
        goal = message.goal
        goal.plan, goal.folder = str(self._folder / "plan.yaml"), str(self._folder / "photographs")
        goal.second_look, goal.supplement = self._request.second_look, self._request.supplement
        goal.photographs, goal.time_max = self._request.photographs, self._request.flight.time_s
        self._goal.publish(message)
        rospy.loginfo("The UAV hovers and begins to take photographs.")

    def note(self, result: SurveyResult, flown: Flown) -> None:
        """Take the result."""
        told = self.photographed
        told.result = result
        before = sum(photographs for photographs, _ in told.flights)
        told.flights.append((result.taken + result.closer - before, flown))

    @property
    def stored(self) -> int:
        """Photographs in the run's folder, also those of a flight that told no result."""
        return len(photographs_in(self._folder / "photographs"))

    def _on_search(self, message: String) -> None:
        self._search = SearchState(message.data)
        if self._search is SearchState.SEARCHING:
            self._is_ready.clear()
        else:
            self._is_ready.set()

    def _on_feedback(self, message: SurveyActionFeedback) -> None:
        told = message.feedback
        words = f"{told.taken} of {told.of} photographs are taken"
        self._progress.tell(told.phase, words, home_way_m=told.home_way, charge=told.charge)

    def _on_camera(self, message: PoseStamped) -> None:
        x, y, z, qx, qy, qz, qw = pose_values(message.pose)
        self.photographed.truths[round(stamp_s(message), 6)] = (x, y, z), (qx, qy, qz, qw)


def figures(told: Photographed, asked: int, swaps: int, share: float | None) -> dict[str, Any]:
    """Return them for result.json.

    asked: photographs of the plan that were to be taken. share: of the surface that they are to show, 0..1;
    None: there is no plan.
    """
    result = told.result
    if result is None:
        return {"end": "", "reason": "The survey told no result."}
    whole = result.taken + result.open + sum(number > 0 for number in result.left_out)
    left = zip(result.left_out, result.left_out_reasons)
    return {
        "end": result.end,
        "reason": result.reason,
        "is_home": result.is_home,
        "asked": max(asked, whole),
        "share_asked": share,
        "taken": result.taken,
        "open": result.open,
        "closer": result.closer,
        "shots": result.shots,
        "left_out": [{"photograph": number, "why": why} for number, why in left],
        "swaps": swaps,
        "flight_s": told.flight_s,
    }
