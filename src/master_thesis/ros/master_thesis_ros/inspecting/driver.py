"""The node `inspecting`: plans, starts the survey, swaps the battery, lands, and writes the results."""

from __future__ import annotations

import math
import subprocess
import uuid
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Iterable

import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import BatteryState

from gridslam.errors import SlamError
from inspection_tools import InspectionToolsError
from inspection_tools.msg import SurveyActionGoal, SurveyActionResult, SurveyResult
from inspection_tools.survey.plan import SurveyPlan
from master_thesis.errors import FlightError
from master_thesis.flight.monitor import Monitor
from master_thesis.inspecting.coverage import Judged, TruePose, judge_photographs
from master_thesis.inspecting.planning import provide_plan, ship_file
from master_thesis.inspecting.request import InspectingRequest, read
from master_thesis.inspecting.summary import headline
from master_thesis.launch_arguments.cepa_parameters import cepa_keeps_m
from master_thesis.results.run_files import FlownRun, complete_run, write_numbers
from master_thesis_ros.experiments.errand_node import ErrandNode
from master_thesis_ros.experiments.messages import pose_values, stamp_s
from master_thesis_ros.experiments.parameters import all_parameters
from master_thesis_ros.experiments.progress import ProgressLog
from master_thesis_ros.experiments.run import Run
from master_thesis_ros.experiments.simulator_services import SimulatorServices
from master_thesis_ros.experiments_3_4.volume_files import save_volume
from node_tools.ending import Ending
from node_tools.node import RunNode

SCAN_PERIOD_S = 1.0
COMMAND_S = 3600.0
"""Wall time for a command after the flight."""


@dataclass
class Told:
    """What was told. flight_s: of all flights, from the first photograph's way to the home.

    truths: of the camera, by the stamp of the photograph. flights: photographs, time_s, and the battery's
    charge at begin and end, 0 to 1, of each.
    """

    result: SurveyResult | None = None
    swaps: int = 0
    began_s: float = math.nan
    flight_s: float = 0.0
    charge: float = math.nan
    flights: list[dict] = field(default_factory=list)
    truths: dict[float, TruePose] = field(default_factory=dict)


class InspectingNode(ErrandNode):
    """Lets the node `inspect` take all photographs, with fresh batteries between.

    Subscribes, besides the topics of `ErrandNode`: /inspect/survey/result
        (inspection_tools/SurveyActionResult), /camera/ground_truth (geometry_msgs/PoseStamped).
    Publishes: /inspect/survey/goal (inspection_tools/SurveyActionGoal, latched).
    """

    def __init__(
        self, monitor: Monitor, request: InspectingRequest, told: Told, folder: Path, lockstep: bool
    ) -> None:
        self._request, self._told, self._folder = request, told, folder
        self._goal = rospy.Publisher("/inspect/survey/goal", SurveyActionGoal, queue_size=1, latch=True)
        super().__init__(monitor, request.flight.swaps, lockstep)
        self.subscribe("/inspect/survey/result", SurveyActionResult, self._on_result)
        self.subscribe("/mavros/battery", BatteryState, self._on_battery)
        self._truths = rospy.Subscriber("/camera/ground_truth", PoseStamped, self._on_camera, queue_size=100)

    def send_goal(self) -> None:
        """Begin the survey, or go on with what its folder lacks."""
        message = SurveyActionGoal()
        message.goal_id.id = f"the survey {uuid.uuid4()}"
        goal = message.goal
        goal.plan, goal.folder = str(self._folder / "plan.yaml"), str(self._folder / "photographs")
        goal.second_look = self._request.second_look
        goal.photographs, goal.time_max = self._request.photographs, self._request.flight.time_s
        self._goal.publish(message)
        self._told.began_s, self._began_charge = self._monitor.now_s, self._told.charge
        rospy.loginfo("The UAV hovers and begins to take photographs.")

    def _on_battery(self, message: BatteryState) -> None:
        self._told.charge = message.percentage

    def _on_camera(self, message: PoseStamped) -> None:
        x, y, z, qx, qy, qz, qw = pose_values(message.pose)
        self._told.truths[round(stamp_s(message), 6)] = (x, y, z), (qx, qy, qz, qw)

    def _on_result(self, message: SurveyActionResult) -> Iterable[Enum]:
        result = message.result
        if message.status.status == GoalStatus.SUCCEEDED:
            self._told.result = result
            time_s = self._monitor.now_s - self._told.began_s
            self._told.flight_s += time_s
            before = sum(each["photographs"] for each in self._told.flights)
            taken = result.taken + result.closer
            self._told.flights.append(
                {
                    "photographs": taken - before,
                    "time_s": time_s,
                    "battery_start": self._began_charge,
                    "battery_end": self._told.charge,
                }
            )
        ended = self._on_end(message.status, result.end, result.is_home, result.reason)
        self._told.swaps = self.swapped
        return ended


def make() -> RunNode:
    """Read and check the request. Return the function that flies it and writes the results."""
    asked = rospy.get_param("~", {})
    request = read(asked, cepa_keeps_m(all_parameters().get("cepa", {})))
    lockstep = asked.get("lockstep", False) is True
    return lambda ending: _fly(request, lockstep, ending)


def _fly(request: InspectingRequest, lockstep: bool, ending: Ending) -> int:
    """Return the exit code."""
    flight = request.flight
    run = Run(flight.description.experiment, ending)
    folder = run.folder.path
    simulator = SimulatorServices()  # its time stands still while the survey is planned
    try:
        plan = provide_plan(request, folder / "plan.yaml", flight.description.seed, rospy.loginfo)
    except (InspectionToolsError, SlamError) as error:
        raise FlightError(str(error)) from None
    monitor, told = Monitor(flight.limits, uav=flight.description.model), Told()
    monitor.log.scan_period_s = SCAN_PERIOD_S
    simulator.unpause()
    run.lead(monitor, lambda: InspectingNode(monitor, request, told, folder, lockstep))
    if not run.interrupted:
        save_volume(run.folder)
    description, wall = run.close(flight.description, monitor)
    flown: FlownRun = (run.folder, description, monitor.log, monitor.course.outcome)
    asked = min(len(plan.views), request.photographs or len(plan.views))
    numbers = {**write_numbers(*flown, wall), "inspection": _figures(told, asked)}
    numbers |= {"flights": told.flights, "world": str(flight.description.scenario.world_path)}
    run.folder.write_json("result.json", numbers)
    return run.finish(
        numbers,
        headline,
        lambda content: _complete(flown, plan, told, ship_file(request), content),
        "coverage, findings or pictures",
    )


def _complete(flown: FlownRun, plan: SurveyPlan, told: Told, ship: Path | None, content: dict) -> dict:
    """Judge the coverage, look for findings, and complete the other files."""
    folder = flown[0]
    photographs = folder.path / "photographs"
    inspection = dict(content["inspection"])
    rospy.loginfo("The coverage is computed.")
    try:
        judged = judge_photographs(
            photographs, folder.path / "plan.yaml", plan, told.truths, inspection.get("asked", 0)
        )
    except InspectionToolsError as error:
        judged = None
        rospy.logwarn(f"There is no coverage.json: {error}")
    if judged is not None:
        inspection["coverage"] = judged.figures()
        inspection["m2_per_min"] = 60.0 * judged.true_m2 / max(told.flight_s, 1.0)
    content = {**content, "inspection": inspection}
    folder.write_json("result.json", content)
    if judged is not None:
        _draw(flown, judged, inspection)
    if judged is not None and rospy.get_param("~findings", True):
        _command(
            "findings", str(photographs), "--mesh", plan.source, "--out", str(folder.path / "findings.json")
        )
    content = complete_run(*flown, content, ProgressLog())
    if judged is not None:
        _command("inspection_report", str(folder.path), *(("--ship", str(ship)) if ship else ()))
    return content


def _draw(flown: FlownRun, judged: Judged, inspection: dict) -> None:
    from master_thesis.inspecting.pictures import write_inspected  # matplotlib takes half a second

    folder, _, log, _ = flown
    words = (
        f"{inspection['taken']} photographs show {judged.true_m2:.0f} m²\n"
        f"in {inspection['flight_s'] / 60.0:.1f} min of flight, without GNSS"
    )
    path_m = log.truth.array("x_m", "y_m", "z_m")
    write_inspected(folder, folder.path / "coverage_truth.npz", path_m, judged.taken, words)


def _command(name: str, *arguments: str) -> None:
    """Run a command of inspection_tools; what it cannot do is a warning."""
    rospy.loginfo(f"rosrun inspection_tools {name} {' '.join(arguments)}")
    done = subprocess.run(
        ["rosrun", "inspection_tools", name, *arguments],
        capture_output=True, text=True, timeout=COMMAND_S, check=False,
    )  # fmt: skip
    if done.returncode:
        rospy.logwarn(f"{name} failed: {done.stderr.strip()[-500:]}")


def _figures(told: Told, asked: int) -> dict[str, Any]:
    result = told.result
    if result is None:
        return {"end": "", "reason": "The survey told no result."}
    left = zip(result.left_out, result.left_out_reasons)
    return {
        "end": result.end,
        "reason": result.reason,
        "is_home": result.is_home,
        "asked": asked,
        "taken": result.taken,
        "open": result.open,
        "closer": result.closer,
        "shots": result.shots,
        "left_out": [{"photograph": number, "why": why} for number, why in left],
        "swaps": told.swaps,
        "flight_s": told.flight_s,
    }
