"""The course of one run of Experiment 2, without ROS: hover, freeze, place, let go, watch.

The caller (the ROS node or the flight without ROS) reports events and carries out the returned actions. Time
is simulation time, in seconds. It stands still between FREEZE and `on_placed`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Sequence

from cepa import LaserScan2D
from flight_basics.checks import check_limits, limited
from flights.errors import FlightError
from flights.flight.flight_log import FlightLog
from flights.flight.judging.contacts import touched_by
from flights.worlds.placements import Obstacle
from simulation_tools.geometry import Pose

SAME_INSTANT_S = 1e-6


class TrialAction(Enum):
    """The actions of the caller."""

    FREEZE = "stop time, place the obstacles"
    SHOW = "the first scan with the obstacles is there"
    FINISH = "finish"


@dataclass(frozen=True)
class TrialParameters:
    """The length of each part, in s of simulation time.

    ready_timeout_s: at most, until the UAV hovers. settle_s: more hover until the freeze. observe_s: from
    the release to the end.
    """

    ready_timeout_s: float = limited(60.0, above=0.0, below=1e6)
    settle_s: float = limited(3.0, above=0.0, below=1e6)
    observe_s: float = limited(15.0, above=0.0, below=1e6)

    def __post_init__(self) -> None:
        check_limits(self, FlightError)


@dataclass(frozen=True)
class Freeze:
    """The instant of the freeze: its time, the UAV's true pose in `world`, and the placed obstacles."""

    t_s: float
    uav: Pose
    obstacles: tuple[Obstacle, ...]


@dataclass(frozen=True)
class FirstScan:
    """The first scan that shows the obstacles, and its stamp.

    The lidar turns only while time runs. So this scan is up to one period of the lidar later than the
    freeze. The flight controller has not received a command from it yet.
    """

    t_s: float
    scan: LaserScan2D


class EmergencyTrial:
    """The state of a run. Every `on_...` returns the actions to carry out."""

    def __init__(self, parameters: TrialParameters, uav: str) -> None:
        """Watch the model named `uav`."""
        self.log = FlightLog()
        self.freeze: Freeze | None = None
        self.first_scan: FirstScan | None = None
        self.touched: dict[str, float] = {}  # the touched shapes, with the time of the first contact
        self.failure: str | None = None
        self.finished = False
        self._parameters = parameters
        self._uav = uav
        self._began_s = 0.0
        self._ready_s: float | None = None
        self._freezing = False
        self._no_hover = ""

    @property
    def now_s(self) -> float:
        """Time of the newest true pose."""
        return self.log.truth.rows[-1][0] if len(self.log.truth) else 0.0

    @property
    def has_begun(self) -> bool:
        """Whether the wait for the hover is over."""
        return self.freeze is not None

    def on_ready(self, ready: bool) -> None:
        """Note whether the UAV hovers and takes orders."""
        if not ready:
            self._ready_s = None
        elif self._ready_s is None:
            self._ready_s = self.now_s

    def on_waiting(self, reason: str) -> None:
        """Note why the UAV does not hover yet, in words; empty: it hovers."""
        self._no_hover = reason

    def on_truth(self, t_s: float, pose: Pose, decide: bool = True) -> list[TrialAction]:
        """Take the true pose in `world`. Return the actions, unless `decide` is called later."""
        if t_s < self.now_s - SAME_INSTANT_S:
            return self.abort("The clock jumped back: the simulation was reset.")
        if not len(self.log.truth):
            self._began_s = t_s
        self.log.truth.add(t_s, *pose.position_m, *pose.orientation_xyzw)
        return self.decide() if decide else []

    def decide(self) -> list[TrialAction]:
        """Return the actions at the time of the newest true pose."""
        if self.finished:
            return []
        if self.freeze is not None:
            return self._end_after_observation(self.now_s - self.freeze.t_s)
        return self._await_hover(self.now_s)

    def _await_hover(self, t_s: float) -> list[TrialAction]:
        if self._freezing:
            return []
        if self._ready_s is not None and t_s - self._ready_s >= self._parameters.settle_s:
            self._freezing = True
            return [TrialAction.FREEZE]
        if t_s - self._began_s > self._parameters.ready_timeout_s + self._parameters.settle_s:
            why = f": {self._no_hover}" if self._no_hover else ""
            return self.abort(f"The UAV did not hover within {self._parameters.ready_timeout_s:g} s{why}.")
        return []

    def _end_after_observation(self, released_for_s: float) -> list[TrialAction]:
        if released_for_s < self._parameters.observe_s - SAME_INSTANT_S:
            return []
        if self.first_scan is None:
            return self.abort("No scan came after the obstacles were placed; is the lidar's chain running?")
        self.finished = True
        return [TrialAction.FINISH]

    def on_placed(self, t_s: float, uav: Pose, obstacles: Sequence[Obstacle]) -> None:
        """Note the freeze. Time goes on after this."""
        self.freeze = Freeze(t_s, uav, tuple(obstacles))

    def on_scan(self, t_s: float, scan: LaserScan2D) -> list[TrialAction]:
        """Take CEPA's input scan. Keep the first one stamped after the freeze."""
        if self.freeze is None or self.first_scan is not None or t_s <= self.freeze.t_s + SAME_INSTANT_S:
            return []
        self.first_scan = FirstScan(t_s, scan)
        return [TrialAction.SHOW]

    def on_contact(self, t_s: float, collision_1: str, collision_2: str, upwards: float = 0.0) -> None:
        """Note a contact between two collision shapes, named model::link::collision.

        After the release every contact counts, also with the ground, so `upwards` does not matter.
        """
        if self.freeze is None or self.finished:
            return  # the UAV stood on the ground before
        self.log.contacts.add_simultaneous(t_s, collision_1, collision_2)
        self.touched.setdefault(touched_by(self._uav, collision_1, collision_2), t_s)

    def abort(self, why: str) -> list[TrialAction]:
        """End the run at once, unless it is over; `why` is a sentence."""
        if self.finished:
            return []
        self.failure = why
        self.finished = True
        return [TrialAction.FINISH]
