"""The node `inspecting`: lets others explore, plans, lets others photograph, and writes the results."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any, Sequence

import rospy

from flight_basics.errors import FlightBasicsError
from flights.errors import FlightError
from flights.exploring.itinerary import Itinerary
from flights.flight.judging.contacts import UavParts
from flights.flight.monitor import Monitor
from flights.inspecting.coverage import Judged, judge_photographs
from flights.inspecting.planning import provide_plan, ship_file, write_page
from flights.inspecting.request import InspectingRequest, read
from flights.inspecting.summary import headline
from flights.inspecting.whole_plan import WholePlanPage
from flights.launch_arguments.cepa_parameters import cepa_keeps_m
from flights.results.run_files import FlownRun, complete_run, write_numbers
from flights_ros.drivers.led_flight_node import LedFlightNode
from flights_ros.drivers.parameters import all_parameters
from flights_ros.drivers.part import Flown, Part
from flights_ros.drivers.progress import ProgressLog
from flights_ros.drivers.run import Run
from flights_ros.drivers.simulator_services import SimulatorServices
from flights_ros.drivers.volume_files import save_clouds, save_volume
from flights_ros.exploring.driver import with_judged_map
from flights_ros.exploring.part import ExplorationPart
from flights_ros.exploring.part import figures as exploration_figures
from flights_ros.inspecting.part import SurveyPart
from flights_ros.inspecting.part import figures as survey_figures
from gridslam.errors import SlamError
from inspection.survey.plan import SurveyPlan
from node_tools.ending import Ending
from node_tools.node import RunNode

SCAN_PERIOD_S = 1.0
COMMAND_S = 3600.0
"""Wall time for a command after the flight."""


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
    page = WholePlanPage(folder / "plan.yaml", lambda: _write_whole_page(request, folder))
    monitor = Monitor(flight.limits, UavParts.load(flight.description.model))
    monitor.log.scan_period_s = SCAN_PERIOD_S

    def make_plan() -> SurveyPlan:
        planned = request
        if request.explore_s is not None:
            if not save_volume(run.folder):
                raise FlightError("There is no map to plan photographs on.")
            save_clouds(run.folder)
            planned = replace(request, drawing=folder / "map.bt")
        plan = provide_plan(planned, folder / "plan.yaml", flight.description.seed, rospy.loginfo)
        if plan.draft is not None:
            page.watch()
        return plan

    survey = SurveyPart(request, folder, make_plan)
    parts: tuple[Part, ...] = (survey,)
    if request.explore_s is not None:
        parts = ExplorationPart(monitor, request.explore_s), survey
    simulator = SimulatorServices()  # its time stands still while the survey is planned
    try:
        if parts[0] is survey:
            survey.prepare()
    except (FlightBasicsError, SlamError) as error:
        raise FlightError(str(error)) from None
    simulator.unpause()
    itinerary = Itinerary(len(parts), flight.swaps)
    told_hover_m = flight.hover_m if flight.sends_hover_height else None
    run.lead(monitor, lambda: LedFlightNode(monitor, itinerary, parts, lockstep, told_hover_m))
    _take_whole_plan(request, survey, page, folder)
    if not run.interrupted:
        save_volume(run.folder)
    elif survey.plan is not None:
        _tell_what_is_left("inspection", folder, survey.plan, ship_file(request))
    description, wall = run.close(flight.description, monitor)
    flown: FlownRun = (run.folder, description, monitor.log, monitor.course.outcome)
    numbers = {**write_numbers(*flown, wall), **_figures(request, parts, itinerary)}
    run.folder.write_result(numbers)

    def tell_how() -> None:
        if survey.plan is not None:
            _tell_what_is_left("work after the flight", folder, survey.plan, ship_file(request))

    return run.finish(
        numbers,
        headline,
        lambda content: _complete(flown, survey, ship_file(request), content),
        "coverage, findings or pictures",
        tell_how,
    )


def _take_whole_plan(
    request: InspectingRequest, survey: SurveyPart, page: WholePlanPage, folder: Path
) -> None:
    """Take the plan as it was completed in flight, and write its page if that was not done then."""
    has_page = page.end()
    try:
        if survey.read_whole_plan() and not has_page:
            write_page(request, folder / "plan.yaml")
    except FlightBasicsError as error:
        rospy.logwarn(str(error))


def _complete(flown: FlownRun, survey: SurveyPart, ship: Path | None, content: dict) -> dict:
    """Judge the coverage, look for findings, and complete the other files."""
    folder, plan, told = flown[0], survey.plan, survey.photographed
    photographs = folder.path / "photographs"
    if "exploration" in content:
        content = with_judged_map(flown, content)
    inspection = dict(content["inspection"])
    judged = None
    if plan is not None:
        rospy.loginfo("The coverage is computed.")
        try:
            judged = judge_photographs(
                photographs, folder.path / "plan.yaml", plan, told.truths, inspection.get("asked", 0),
                Path(content["world"]),
            )  # fmt: skip
        except FlightBasicsError as error:
            rospy.logwarn(f"There is no coverage.json: {error}")
            folder.lacks(f"There is no coverage.json: {error}")
    if judged is not None:
        inspection["coverage"] = judged.figures()
        inspection["m2_per_min"] = 60.0 * judged.true_m2 / max(told.flight_s, 1.0)
    content = {**content, "inspection": inspection}
    folder.write_result(content)
    if judged is not None:
        _draw(flown, judged, inspection)
    if plan is not None and judged is not None and rospy.get_param("~findings", True):
        if rospy.get_param("~detector", False):
            _command("ask_detector", f"_folder:={photographs}", f"_mesh:={plan.source}")
        if not _command(*_searching(folder.path, plan)):
            folder.lacks("There is no findings.json; the log of this run tells why findings failed.")
    content = complete_run(*flown, content, ProgressLog())
    folder.write_result(content, is_whole=True)  # the report tells how the run ended, as result.json does
    if judged is not None and not _command(*_reporting(folder.path, ship)):
        folder.lacks("There is no report.html; the log of this run tells why inspection_report failed.")
    return content


def _searching(folder: Path, plan: SurveyPlan) -> tuple[str, ...]:
    """Return the command that searches the photographs of a run for findings."""
    found = str(folder / "findings.json")
    return "findings", str(folder / "photographs"), "--mesh", plan.source, "--out", found


def _reporting(what: Path, ship: Path | None) -> tuple[str, ...]:
    """Return the command that writes the report of a run's folder, or the page of a plan."""
    return "inspection_report", str(what), *(("--ship", str(ship)) if ship else ())


def _write_whole_page(request: InspectingRequest, folder: Path) -> bool:
    """Write the page of the whole plan, in flight. Return whether that was done."""
    return _command(*_reporting(folder / "plan.yaml", ship_file(request)), before=("nice",))


def _tell_what_is_left(what: str, folder: Path, plan: SurveyPlan, ship: Path | None) -> None:
    """After Ctrl-C: tell which commands search what was photographed, and write the report.

    what: was interrupted.
    """
    rospy.logwarn(
        f"The {what} was interrupted, and no call continues the flight. "
        "These two calls search the photographs that were taken, and write their report:\n"
        f"rosrun inspection {' '.join(_searching(folder, plan))}\n"
        f"rosrun inspection {' '.join(_reporting(folder, ship))}"
    )


def _draw(flown: FlownRun, judged: Judged, inspection: dict) -> None:
    from flights.inspecting.pictures import caption, write_inspected  # matplotlib takes half a second

    folder, _, log, _ = flown
    words = caption(judged, inspection["flight_s"])
    path_m = log.truth.array("x_m", "y_m", "z_m")
    write_inspected(folder, folder.path / "coverage_truth.npz", path_m, judged.taken, words)


def _command(name: str, *arguments: str, before: tuple[str, ...] = ()) -> bool:
    """Run a command of inspection, which ends when this process does. Return whether it did its work.

    What it cannot do is a warning. before: words before the command.
    """
    words = f"rosrun inspection {name} {' '.join(arguments)}"
    rospy.loginfo(f"The run now calls: {words}")
    try:
        done = subprocess.run(
            ["setpriv", "--pdeathsig", "TERM", *before, "rosrun", "inspection", name, *arguments],
            capture_output=True, text=True, timeout=COMMAND_S, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        rospy.logwarn(
            f"{name} was not done after {COMMAND_S / 60.0:.0f} min, so the results lack what it writes. "
            f"To give it more time: {words}"
        )
        return False
    if done.returncode:
        rospy.logwarn(f"{name} failed: {done.stderr.strip()[-500:]}")
    return not done.returncode


def _figures(request: InspectingRequest, parts: Sequence[Part], itinerary: Itinerary) -> dict[str, Any]:
    """Return what the parts told, for result.json."""
    survey = parts[-1]
    assert isinstance(survey, SurveyPart)
    views = 0 if survey.plan is None else len(survey.plan.views)
    told = survey.photographed
    share = None if survey.plan is None else survey.plan.asked.share
    asked = min(views, request.photographs or views)
    inspection = survey_figures(told, asked, itinerary.swapped[-1], share)
    content: dict[str, Any] = {
        "inspection": {**inspection, "stored": survey.stored},
        "world": str(request.flight.description.scenario.world_path),
    }
    flights = [_row(flown, photographs=photographs) for photographs, flown in told.flights]
    if isinstance(parts[0], ExplorationPart):
        explored = parts[0].explored
        content["exploration"] = exploration_figures(explored, itinerary.swapped[0])
        flights = [_row(flown, purpose="mapping") for flown in explored.flights] + flights
    return {**content, "flights": flights}


def _row(flown: Flown, **more: object) -> dict[str, Any]:
    charges = {"battery_start": flown.battery_start, "battery_end": flown.battery_end}
    return {**more, "time_s": flown.time_s, **charges}
