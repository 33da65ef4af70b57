"""Turns the goals of the action into surveys, and begins them: anew, after a landing, or after a restart."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path
from typing import Callable

import numpy as np
import rospy

from inspection_tools.energy import EnergyWatch
from inspection_tools.findings.background import BackgroundSearch
from inspection_tools.findings.wanted import Wanted
from inspection_tools.inspection import Inspection, InspectionParameters
from inspection_tools.inspection.motion import Motion
from inspection_tools.inspection.second_look import SearchState, SecondLook
from inspection_tools.msg import SurveyGoal
from inspection_tools.photographs.folder import PhotographFolder, records_in
from inspection_tools.planning import PathPlanner
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools_ros.map_feed import MapFeed
from inspection_tools_ros.surveying.detector_link import DetectorLink
from inspection_tools_ros.surveying.files import Drawings, files_of, name_of

FINE_MM = 0.5
"""Photographs as fine as this are closer looks: they need none."""


class SurveyGoals:
    """Knows the goal that is flown.

    Attributes:
        plan: of the goal; None: none has come. folder: its photographs. second_look: takes more
            photographs than the plan's; None: nobody asks for them.
        on_stored: takes each photograph that is stored.
    """

    def __init__(
        self,
        planner: PathPlanner,
        planner_lock: threading.Lock,
        feed: MapFeed,
        parameters: InspectionParameters,
        energy: EnergyWatch | None,
        detector: DetectorLink | None = None,
    ) -> None:
        self._planner, self._planner_lock, self._feed = planner, planner_lock, feed
        self._parameters, self._energy, self._detector = parameters, energy, detector
        self._drawings = Drawings(planner.parameters)
        self._name = ""
        self._inspection: Inspection | None = None
        self.plan: SurveyPlan | None = None
        self.folder: PhotographFolder | None = None
        self.second_look: SecondLook | None = None
        self.on_stored: Callable[[Path], None] = lambda _: None

    def inspection_of(self, goal: SurveyGoal) -> Inspection:
        """Read plan, folder and drawing, unless they are those of the goal before.

        Raises:
            InspectionToolsError: one sentence.
        """
        if self._inspection is not None and name_of(goal) == self._name:
            return self._inspection
        files = files_of(goal, self._parameters)
        prior = self._drawings.prior_of(files.plan)
        with self._planner_lock:
            if prior is not self._feed.prior:
                self._feed.use(prior)
        given = replace(files.parameters, time_max=goal.time_max or self._parameters.time_max)
        self._name, self.plan, self.folder = name_of(goal), files.plan, files.folder
        inspection = self._inspection = Inspection(self._planner, files.todo, given, self._energy)
        self.close()
        is_fine = files.plan.asked.resolution <= FINE_MM
        wanted = Wanted(goal.supplement and not goal.photographs, goal.second_look and not is_fine)
        is_draft = files.plan.draft is not None and not goal.photographs
        if any(wanted) or is_draft:
            search = BackgroundSearch(Path(goal.plan), files.folder.folder / "closer.yaml", wanted)
            self.second_look = SecondLook(inspection, search, is_draft)
        self.on_stored = self._taker(files.plan.source)
        for path, _ in records_in(files.folder.folder)[0]:
            self.on_stored(path)
        return inspection

    def _taker(self, mesh: str) -> Callable[[Path], None]:
        """Return what takes photographs that are stored: first the detector, then the second look."""
        searches = self.second_look.stored if self.second_look else lambda _: None
        if self._detector is None:
            return searches
        self._detector.mesh, self._detector.on_marked = mesh, searches
        return self._detector.give

    def abort(self) -> bool:
        """Await no more photographs than there are. Return whether some were searched for.

        The same goal again begins with a new search.
        """
        was_searching = self.second_look is not None and self.second_look.state is SearchState.SEARCHING
        if self.second_look is not None:
            self.second_look.abort()
            self._name = ""
        return was_searching

    def close(self) -> None:
        """End the search of photographs, if there is one."""
        if self.second_look is not None:
            self.second_look.close()
            self.second_look = None

    def begin(self, inspection: Inspection, motion: Motion) -> None:
        """Begin, or go on with what is left. A node that died comes home to the same place."""
        home = rospy.get_param("~begun", {})
        known = home.get("home") if home.get("goal") == self._name else None
        inspection.begin(motion.stamp_s, motion.place_m, None if known is None else np.array(known))
        assert inspection.home_m is not None
        rospy.set_param("~begun", {"goal": self._name, "home": inspection.home_m.tolist()})
        rospy.loginfo("The survey begins: %d photographs are open.", len(inspection.todo.open))
