"""The node `exploring`: starts the exploration, swaps the battery, lands, and writes the results."""

from __future__ import annotations

import uuid
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Iterable

import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus

from gridslam import SlamError
from inspection_tools.msg import (
    ExploreActionFeedback,
    ExploreActionGoal,
    ExploreActionResult,
    ExploreResult,
)
from master_thesis.exploring.request import ExploringRequest, read
from master_thesis.exploring.summary import headline
from master_thesis.flight.monitor import Monitor
from master_thesis.launch_arguments.cepa_parameters import cepa_keeps_m
from master_thesis.results.run_files import FlownRun, complete_run, write_numbers
from master_thesis_ros.experiments.errand_node import ErrandNode
from master_thesis_ros.experiments.parameters import all_parameters
from master_thesis_ros.experiments.progress import ProgressLog
from master_thesis_ros.experiments.run import Run
from master_thesis_ros.experiments_3_4.volume_files import save_volume
from node_tools.conversions import xyz
from node_tools.ending import Ending
from node_tools.node import RunNode

SCAN_PERIOD_S = 1.0


@dataclass
class Told:
    """What the action told. known: time in s, known volume in m3, way home in m and Wh, charge."""

    result: ExploreResult | None = None
    swaps: int = 0
    began_s: float | None = None
    ended_s: float | None = None
    known: list[tuple[float, ...]] = field(default_factory=list)


class ExploringNode(ErrandNode):
    """Lets the node `explore` explore to the end, with fresh batteries between.

    Subscribes, besides the topics of `ErrandNode`: explore_result (inspection_tools/ExploreActionResult),
        explore_feedback (ExploreActionFeedback).
    Publishes: explore_goal (inspection_tools/ExploreActionGoal, latched).
    """

    def __init__(self, monitor: Monitor, request: ExploringRequest, told: Told, lockstep: bool) -> None:
        self._request, self._told = request, told
        self._goal = rospy.Publisher("/explore/explore/goal", ExploreActionGoal, queue_size=1, latch=True)
        super().__init__(monitor, request.swaps, lockstep)
        self.subscribe("/explore/explore/result", ExploreActionResult, self._on_result)
        self.subscribe("/explore/explore/feedback", ExploreActionFeedback, self._on_feedback)

    def send_goal(self) -> None:
        """Begin to explore."""
        goal = ExploreActionGoal()
        goal.goal_id.id = f"the exploration {uuid.uuid4()}"
        goal.goal.time_max = self._request.time_s
        self._goal.publish(goal)
        if self._told.began_s is None:
            self._told.began_s = self._monitor.now_s
        rospy.loginfo("The UAV hovers and begins to explore.")

    def _on_feedback(self, message: ExploreActionFeedback) -> None:
        told = message.feedback
        row = (self._monitor.now_s, told.known, told.home_way, told.home_time, told.home_energy, told.charge)
        self._told.known.append(row)

    def _on_result(self, message: ExploreActionResult) -> Iterable[Enum]:
        result = message.result
        if message.status.status == GoalStatus.SUCCEEDED:
            self._told.result, self._told.ended_s = result, self._monitor.now_s
        ended = self._on_end(message.status, result.end, result.is_home, result.reason)
        self._told.swaps = self.swapped
        return ended


def make() -> RunNode:
    """Read and check the request. Return the function that flies it and writes the results."""
    asked = rospy.get_param("~", {})
    request = read(asked, cepa_keeps_m(all_parameters().get("cepa", {})))
    lockstep = asked.get("lockstep", False) is True
    return lambda ending: _fly(request, lockstep, ending)


def _fly(request: ExploringRequest, lockstep: bool, ending: Ending) -> int:
    """Return the exit code."""
    run = Run(request.description.experiment, ending)
    monitor, told = Monitor(request.limits, uav=request.description.model), Told()
    monitor.log.scan_period_s = SCAN_PERIOD_S
    run.lead(monitor, lambda: ExploringNode(monitor, request, told, lockstep))
    if not run.interrupted:
        save_volume(run.folder)
    description, wall = run.close(request.description, monitor)
    flown: FlownRun = (run.folder, description, monitor.log, monitor.course.outcome)
    numbers = {**write_numbers(*flown, wall), "exploration": _figures(told)}
    run.folder.write_json("result.json", numbers)
    columns = ("t_s", "known_m3", "home_way_m", "home_time_s", "home_energy_wh", "charge")
    run.folder.write_csv("exploration.csv", columns, told.known)
    return run.finish(
        numbers,
        headline,
        lambda content: _complete(flown, told, content),
        "clearance or pictures",
    )


def _complete(flown: FlownRun, told: Told, content: dict) -> dict:
    """Draw the map and the path, and complete the other files."""
    from master_thesis.exploring.pictures import write_explored  # numba and matplotlib take a second

    folder, _, log, _ = flown
    known = np.array([row[:2] for row in told.known]).reshape(-1, 2) - (told.began_s or 0.0, 0.0)
    try:
        write_explored(folder, folder.path / "map.ot", log.truth.array("x_m", "y_m", "z_m"), known)
    except (SlamError, OSError) as error:
        rospy.logwarn(f"There is no explored.png: {error}")
    return complete_run(*flown, content, ProgressLog())


def _figures(told: Told) -> dict[str, Any]:
    result = told.result
    if result is None:
        return {"end": "", "reason": "The exploration told no result."}
    left = zip(result.unknown_places, result.unknown_areas, result.unknown_reasons)
    assert told.began_s is not None
    assert told.ended_s is not None
    known = [row for row in told.known if row[1] >= 0.99 * result.known]
    return {
        "end": result.end,
        "reason": result.reason,
        "is_home": result.is_home,
        "known_m3": result.known,
        "views": result.views,
        "swaps": told.swaps,
        "time_99_s": known[0][0] - told.began_s if known else None,
        "home_s": told.ended_s - told.began_s,
        "unknown": [{"place_m": xyz(place), "border_m2": area, "why": why} for place, area, why in left],
    }
