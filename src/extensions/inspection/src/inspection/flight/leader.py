"""The photographs of a survey as a leader of an errand: see `flight_basics.errand.leader`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Mapping, NamedTuple, Protocol, Sequence

import numpy as np

from exploration.energy import EnergyWatch
from exploration.planning import PathPlanner
from flight_basics.errand.forwarding import ForwardingLeader
from flight_basics.errand.leader import Here, Outcome
from flight_basics.errand.messages import Answer
from inspection.flight.inspection import Inspection
from inspection.flight.motion import Motion
from inspection.flight.photograph_queue import Task
from inspection.flight.photograph_records import StampedPose
from inspection.flight.second_look import SearchState, SecondLook
from inspection.flight.slam_path import LevelPose
from inspection.survey.plan import SurveyPlan

NO_SURVEY = "No survey is being flown."


class SurveyPose(NamedTuple):
    """`Here.more`: the motion; for the records the pose with all of SLAM's correction, and that in odom."""

    motion: Motion
    pose: StampedPose
    in_odom: LevelPose | None


class Survey(NamedTuple):
    """What a goal asks for. time_max_s: None: the parameter's."""

    inspection: Inspection
    time_max_s: float | None


class Goals(Protocol):
    """Knows the goal that is flown. plan: of the goal. album: its photographs. second_look: takes more."""

    plan: SurveyPlan | None
    album: Any
    second_look: SecondLook | None

    def inspection_of(self, goal: Any) -> Inspection:
        """Read what a goal names. Raises FlightBasicsError."""

    def abort(self) -> bool:
        """Await no more photographs than there are. Return whether some were searched for."""


class Photographer(Protocol):
    """Opens the shutter, and stores what comes."""

    @property
    def is_shooting(self) -> bool:
        """Whether a shutter is to open."""

    @property
    def waits(self) -> bool:
        """Whether a picture is still to come."""

    def begin(self, inspection: Inspection, album: Any) -> None:
        """Take photographs of a survey from now on."""

    def take(self, task: Task, stamp_s: float) -> None:
        """Take a photograph soon."""

    def hurry(self) -> None:
        """Wait no longer than a UAV may that hovers at home."""

    def note(self, pose: StampedPose, in_odom: LevelPose | None) -> None:
        """Note a pose for the records."""


class SurveyLeader(ForwardingLeader[Inspection]):
    """Leads from photograph to photograph. The same goal again goes on with what its folder lacks.

    Args:
        goals, photographer: see there. planner, energy: as those of the inspection. closer_mm: resolution of
            a closer look, mm per pixel. is_marking: whether a photograph is still to be marked. tell: logs a
            sentence.
    """

    def __init__(
        self,
        goals: Goals,
        photographer: Photographer,
        planner: PathPlanner,
        energy: EnergyWatch | None,
        closer_mm: float,
        is_marking: Callable[[], bool] = lambda: False,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._goals, self._photographer = goals, photographer
        self._planner, self._closer_mm = planner, closer_mm
        self._is_marking, self._tell = is_marking, tell
        super().__init__(energy)

    @property
    def inspection(self) -> Inspection | None:
        """What flies the goal; None: no goal has come."""
        return self.led

    @property
    def setpoint(self) -> np.ndarray | None:
        """Where to fly, (x, y, z); None: stay."""
        return None if self.inspection is None else self.inspection.setpoint_m

    @property
    def end(self) -> str:
        """Why it has ended, in a word; empty: it has not."""
        end = None if self.inspection is None else self.inspection.end
        return "" if end is None else end.value

    @property
    def reason(self) -> str:
        """Why it has ended, in a sentence."""
        return self._it.reason

    @property
    def is_busy(self) -> bool:
        """Whether a shutter is to open."""
        return self._photographer.is_shooting

    @property
    def has_map(self) -> bool:
        """Whether a map has come, or a drawing is known."""
        return self._planner.has_map

    @property
    def search(self) -> SearchState:
        """What the search of photographs does."""
        second = self._goals.second_look
        return SearchState.IDLE if second is None else second.state

    def prepare(self, content: Any) -> Survey:
        """Read plan, folder and drawing. Raises FlightBasicsError."""
        return Survey(self._goals.inspection_of(content), content.time_max or None)

    def begin(self, plan: Survey, here: Here | None, kept: Mapping[str, Any] | None) -> str:
        """Begin, or go on with what is left. Raises ParameterError: the time makes no sense."""
        assert here is not None
        inspection = plan.inspection
        self._begin(inspection, plan.time_max_s, here, kept)
        self._photographer.begin(inspection, self._goals.album)
        return f"The survey begins; photographs to take: {len(inspection.queue.open)}."

    def note(self, here: Here) -> None:
        """Note the pose for the photographs' records."""
        told: SurveyPose = here.more
        self._photographer.note(replace(told.pose, deviation_m=here.deviation_m), told.in_odom)

    def follow(self, here: Here) -> bool:
        """Follow the way, and open the shutter when it is due."""
        motion = replace(here.more.motion, time_s=here.time_s)
        is_due = self._it.follow(motion)
        task = self._it.shutter(motion)
        if task is not None:
            self._photographer.take(task, here.stamp_s)
        return is_due

    def look(self, here: Here, readings: Sequence[tuple[float, float]]) -> list[str]:
        """Decide, also of what is photographed next."""
        self.rest()
        return super().look(here, readings)

    def rest(self) -> None:
        """Ask the search of photographs, or take its answer; also while the UAV has landed to wait for it."""
        second = self._goals.second_look
        if second is not None:
            says = second.look(self._photographer.waits or self._is_marking())
            if says:
                self._tell(says)

    def look_closer(self, point_m: np.ndarray, here_m: np.ndarray | None) -> Answer:
        """Photograph a point (x, y, z) from nearer, in the worker's thread."""
        inspection, plan = self.inspection, self._goals.plan
        if inspection is None or plan is None or here_m is None or inspection.end is not None:
            return Answer(False, NO_SURVEY)
        if not np.isfinite(point_m).all():
            return Answer(False, "The point is not three finite numbers.")
        task = inspection.look_closer(point_m, here_m, plan.camera.distance_m(self._closer_mm))
        words = "The UAV looks closer." if task else "No place near that point can be flown to."
        return Answer(task is not None, words)

    def stop_waiting(self) -> str:
        """Wait for no more photographs to take; a UAV that has landed stays on the ground."""
        if not self._goals.abort():
            return ""
        return "The photographs are not searched any more, and the UAV stays on the ground."

    def outcome(self) -> Outcome | None:
        """Return the end: at home when every picture has come or is late, or at once where it must land."""
        it = self._it
        if not (it.is_home or it.must_land):
            return None
        if self._photographer.waits and not it.must_land:
            self._photographer.hurry()
            return None
        log = f"The UAV {'is home' if it.is_home else 'is not home'}. {it.reason}"
        return Outcome(it.reason, must_land=it.must_land, log=log)
