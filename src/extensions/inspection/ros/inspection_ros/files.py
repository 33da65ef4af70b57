"""The files of a survey that is flown: its plan, its folder of photographs, and the drawing of the place."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import rospy

from exploration.planning import PlannerParameters
from flight_basics.errors import SurveyError
from inspection.flight import InspectionParameters, PhotographQueue, PriorMap
from inspection.flight.photograph_records import done_in
from inspection.msg import SurveyGoal
from inspection.photographs.folder import PhotographFolder
from inspection.survey.asked_for import AskedFor
from inspection.survey.parameters import SurveyParameters
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan
from inspection.survey.surface.mesh_file import read_mesh
from inspection.survey.surface.reading import read_room


class SurveyFiles(NamedTuple):
    """What a goal names. queue: knows what the folder holds already. parameters: for its photographs."""

    plan: SurveyPlan
    folder: PhotographFolder
    queue: PhotographQueue
    parameters: InspectionParameters


class SurveyName(NamedTuple):
    """What is the same for the same survey. words: of the goal. plan, mesh: what these files hold."""

    words: str
    plan: str
    mesh: str


def name_of(goal: SurveyGoal, mesh: str) -> SurveyName:
    """Return a goal's name. mesh: file of the plan's surface."""
    words = f"{goal.plan} {goal.folder} {goal.photographs} {goal.second_look} {goal.supplement}"
    return SurveyName(words, digest_of(goal.plan), digest_of(mesh))


def digest_of(path: str) -> str:
    """Return what tells a file's content from any other; empty: it cannot be read."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return ""


def files_of(goal: SurveyGoal, parameters: InspectionParameters) -> SurveyFiles:
    """Read what a goal names.

    Raises:
        FlightBasicsError: one sentence.
    """
    plan = read_plan(Path(goal.plan))
    serials = (str(rospy.get_param(name, "")).strip() for name in ("~camera_serial", "~lens_serial"))
    folder = PhotographFolder(Path(goal.folder), plan.camera, *serials)
    for sentence in folder.damaged:
        rospy.logwarn("%s", sentence)
    of_plan = parameters.for_plan(plan)
    views = plan.views[: goal.photographs or None]
    done = done_in(folder.folder, of_plan, views)
    if done:
        rospy.loginfo("%d photographs are in %s already.", len(done), goal.folder)
    queue = PhotographQueue(views, done, parameters.tries)
    return SurveyFiles(plan, folder, queue, of_plan)


def asked_for(plan: SurveyPlan) -> AskedFor | None:
    """Return what tells what each photograph of a plan is to show; None: its mesh cannot be read."""
    try:
        mesh = read_mesh(Path(plan.source))
    except SurveyError as error:
        rospy.logwarn("%s No photograph is taken again because of its exposure.", error)
        return None
    return AskedFor(mesh, plan.camera, plan.asked.incidence)


class Drawings:
    """The drawing of the place. One that is named by the parameters is read at once, before the flight.

    Parameters (private): drawing (str): a mesh; drawing_home (str): a place in its air, "x y z"; use_drawing
        (bool, true).
    """

    def __init__(self, planner: PlannerParameters) -> None:
        """Read it; raises SurveyError if it cannot be read."""
        self._known: tuple[tuple[str, str], PriorMap] | None = None
        """By path and content."""
        path = str(rospy.get_param("~drawing", "")).strip()
        self._is_used = bool(rospy.get_param("~use_drawing", True))
        if path and self._is_used:
            home_m = [float(value) for value in str(rospy.get_param("~drawing_home", "")).split()] or None
            asked = SurveyParameters(radius=planner.radius, margin=planner.margin)
            self._known = (path, digest_of(path)), PriorMap(read_room(Path(path), asked, home_m))

    def prior_of(self, plan: SurveyPlan) -> PriorMap | None:
        """Return what the drawing of a plan knows; None: it is not to be used."""
        if not self._is_used:
            return None
        name = plan.source, digest_of(plan.source)
        if self._known is None or self._known[0] != name:
            self._known = name, PriorMap(read_room(Path(plan.source), plan.asked, plan.home_m))
        return self._known[1]
