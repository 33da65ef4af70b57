"""Turns the goals of the action into surveys: anew, or with what is left after a landing."""

from __future__ import annotations

from pathlib import Path
from typing import Callable

from exploration_ros.map_feed import MapFeed

from exploration.energy import EnergyWatch
from exploration.planning import PathPlanner
from flight_basics.errors import FlightBasicsError
from inspection.findings.background import BackgroundSearch, SearchTargets
from inspection.flight import Inspection, InspectionParameters
from inspection.flight.photograph_records import done_in
from inspection.flight.second_look import SearchState, SecondLook
from inspection.flight.viewpoints import is_completed
from inspection.msg import SurveyGoal
from inspection.photographs.listing import records_in
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan
from inspection_ros.detector_link import DetectorLink
from inspection_ros.files import Drawings, SurveyName, asked_for, digest_of, files_of, name_of
from inspection_ros.photographer import Album

FINE_MM = 0.5
"""Photographs as fine as this are closer looks: they need none."""


class SurveyGoals:
    """Knows the goal that is flown. Its methods are called in the worker's thread, but for `abort`.

    Attributes:
        plan: of the goal; None: none has come. album: its photographs. second_look: takes more
            photographs than the plan's; None: nobody asks for them.
    """

    def __init__(
        self,
        planner: PathPlanner,
        feed: MapFeed,
        parameters: InspectionParameters,
        energy: EnergyWatch | None,
        detector: DetectorLink | None = None,
    ) -> None:
        self._planner, self._feed = planner, feed
        self._parameters, self._energy, self._detector = parameters, energy, detector
        self._drawings = Drawings(planner.parameters)
        self._name: SurveyName | None = None
        self._inspection: Inspection | None = None
        self.plan: SurveyPlan | None = None
        self.album: Album | None = None
        self.second_look: SecondLook | None = None

    def inspection_of(self, goal: SurveyGoal) -> Inspection:
        """Read plan, folder and drawing, unless they are those of the goal before.

        Raises:
            FlightBasicsError: one sentence.
        """
        if self._inspection is not None and self._is_known(goal):
            self._inspection.note_stored(self._stored())
            return self._inspection
        plan = digest_of(goal.plan)  # before it is read: whoever edits it meanwhile gets it read again
        files = files_of(goal, self._parameters)
        prior = self._drawings.prior_of(files.plan)
        if prior is not self._feed.prior:
            self._feed.use(prior)
        self._name, self.plan = name_of(goal, files.plan.source)._replace(plan=plan), files.plan
        inspection = Inspection(self._planner, files.queue, files.parameters, self._energy)
        self._inspection = inspection
        self.close()
        is_fine = files.plan.asked.resolution <= FINE_MM
        targets = SearchTargets(goal.supplement and not goal.photographs, goal.second_look and not is_fine)
        is_draft = files.plan.draft is not None and not goal.photographs
        if any(targets) or is_draft:
            search = BackgroundSearch(Path(goal.plan), files.folder.folder / "closer.yaml", targets)
            self.second_look = SecondLook(inspection, search, is_draft)
        self.album = Album(files.folder, self._taker(files.plan.source), asked_for(files.plan))
        for path, _ in records_in(files.folder.folder)[0]:
            self.album.on_stored(path)
        return inspection

    def _stored(self) -> set[int]:
        """Return the numbers of the photographs that are in the folder."""
        assert self._inspection is not None
        assert self.plan is not None
        assert self.album is not None
        views = [task.view for task in self._inspection.queue.tasks]
        return done_in(self.album.folder.folder, self._parameters.for_plan(self.plan), views)

    def _is_known(self, goal: SurveyGoal) -> bool:
        """Whether a goal asks for the survey that is there. A draft may have become a whole plan since."""
        if self.plan is None or self._name is None:
            return False
        name = name_of(goal, self.plan.source)
        if name == self._name:
            return True
        if name._replace(plan=self._name.plan) != self._name or not self._has_completed(goal.plan):
            return False
        self._name = name
        return True

    def _has_completed(self, path: str) -> bool:
        """Whether the search of this survey has made a plan's file of the draft that is flown."""
        if self.second_look is None or self._inspection is None or self.plan is None:
            return False
        try:
            whole = read_plan(Path(path))
        except FlightBasicsError:
            return False
        told = [task.view for task in self._inspection.queue.tasks]
        are_all_told = self.second_look.lacks_rest or len(told) >= len(whole.views)
        if not are_all_told or not is_completed(self.plan, whole, told):
            return False
        self.plan = whole
        return True

    def _taker(self, mesh: str) -> Callable[[Path], None]:
        """Return what takes photographs that are stored: first the detector, then the second look."""
        searches = self.second_look.stored if self.second_look else lambda _: None
        detector = self._detector
        if detector is None:
            return searches
        return lambda path: detector.give(path, mesh, searches)

    def abort(self) -> bool:
        """Await no more photographs than there are. Return whether some were searched for.

        The same goal again begins with a new search.
        """
        was_searching = self.second_look is not None and self.second_look.state is SearchState.SEARCHING
        if self.second_look is not None:
            self.second_look.abort()
            self._name = None
        return was_searching

    def close(self) -> None:
        """End the search of photographs, if there is one."""
        if self.second_look is not None:
            self.second_look.close()
            self.second_look = None
