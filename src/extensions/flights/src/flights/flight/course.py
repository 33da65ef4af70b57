"""The course of one run, without ROS: wait until ready, fly to the goal, hover, land, done.

The caller (the ROS node or the closed loop without ROS) reports events and carries out the returned actions.
Time is simulation time, in seconds. Nothing here waits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

from flight_basics.checks import check_limits, limited
from flights.errors import FlightError
from flights.flight.flight_log import Series
from flights.flight.judging.contacts import GROUND, Contacts, UavParts
from flights.flight.judging.landing import REST_S, STEP_S, UNKNOWN, Landing, landing_of

GROUNDED_S = 5.0
"""A UAV that stands on the ground for so long in the middle of its flight has landed."""
PATIENCE = 3.0
"""A flight may take this many times as long as the straight path at full speed."""


class Phase(Enum):
    """The parts of a run."""

    WAITING = "waiting for the start"
    FLYING = "flying to the goal"
    HOVERING = "hovering at the goal"
    LANDING = "landing"
    DONE = "done"

    __hash__ = object.__hash__
    """Each pose looks members up. An enumeration's own hash, of the name, takes five times as long."""


class Action(Enum):
    """The actions of the caller."""

    SEND_GOAL = "send the goal"
    LAND = "land"
    FINISH = "finish"


@dataclass(frozen=True)
class PhaseLimits:
    """Time limits of the phases.

    hover_s: hover at the goal before landing. ready_timeout_s: from the start to the hover.
    flight_timeout_s: from sending the goal to reaching it; `for_way` may raise it. landing_timeout_s: from
    the order to land to disarmed. takes_off_once: a UAV that lands before it hovers over the start ends the
    run. Else `mavros_publisher` may let it take off again.
    """

    hover_s: float = limited(2.0, above=0.0, below=1e6)
    ready_timeout_s: float = limited(60.0, above=0.0, below=1e6)
    flight_timeout_s: float = limited(120.0, above=0.0, below=1e6)
    landing_timeout_s: float = limited(60.0, above=0.0, below=1e6)
    takes_off_once: bool = False

    def __post_init__(self) -> None:
        check_limits(self, FlightError)

    def for_way(self, way_m: float, speed_m_s: float, hold_s: float = 0.0) -> PhaseLimits:
        """Return the same limits with enough time for a path of this length at this speed (above 0).

        hold_s: time that the UAV stays at waypoints.
        """
        needed_s = min(PATIENCE * way_m / speed_m_s + hold_s, 999_999.0)
        return replace(self, flight_timeout_s=max(self.flight_timeout_s, needed_s))


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run.

    landed: the last landing was good. times_s: start of each phase. failure: None, or a sentence with the
    reason of the failure. touched: the touched obstacles. ground: models that carried the UAV before or after
    the flight. landing: the last one; None: there was none. between_s: each landing between two parts of the
    flight, from its order until the UAV hovers again.
    """

    reached_goal: bool
    collision: bool
    landed: bool
    failure: str | None
    times_s: dict[Phase, float]
    touched: tuple[str, ...]
    ground: tuple[str, ...] = (GROUND,)
    landing: Landing | None = None
    between_s: tuple[tuple[float, float], ...] = ()

    @property
    def success(self) -> bool:
        """Whether the UAV reached the goal without a contact and has landed well."""
        return self.reached_goal and self.landed and not self.collision and self.failure is None


class Course:
    """State machine of a run. Every `on_...` returns the actions to carry out."""

    def __init__(self, parameters: PhaseLimits, uav: UavParts, truth: Series) -> None:
        """Start a run of a UAV. truth: its true poses (`POSE_COLUMNS`); the caller adds each new one."""
        self._parameters, self._truth = parameters, truth
        self._contacts = Contacts(uav)
        self.phase = Phase.WAITING
        """The phase of the run."""
        self.lands_between = False
        """Whether the UAV lands, or stands, between two parts of its flight: see `land_between`."""
        self._between_s: list[tuple[float, float]] = []
        self._times: dict[Phase, float] = {}
        self._set_by_s = 0.0
        """By how much the clock was set ahead in this phase."""
        self._limits_s = {
            Phase.WAITING: parameters.ready_timeout_s,
            Phase.FLYING: parameters.flight_timeout_s,
            Phase.LANDING: parameters.landing_timeout_s,
        }
        self._reached = False
        self._landing: Landing | None = None
        self._ordered_s = self._touched_s = math.inf
        self._failure: str | None = None
        self._ready = False
        self._awaited = "the hover"
        self._distance_m: float | None = None
        self._no_hover = ""
        self._why_here = ""
        """Why it must land where it is; empty: it need not."""
        self._own_descent = ""
        """Why the flight controller brings the UAV down by itself; empty: it does not."""
        self._was_in_air = False
        self._grounded_s: float | None = None

    def has_begun(self, phase: Phase) -> bool:
        """Return whether a phase has begun."""
        return phase in self._times

    @property
    def phases_begun(self) -> int:
        """The number of phases that have begun."""
        return len(self._times)

    @property
    def outcome(self) -> Outcome:
        """The outcome so far."""
        return Outcome(
            reached_goal=self._reached,
            collision=bool(self._contacts.touched),
            landed=self._landing is not None and self._landing.is_good,
            failure=self._failure_sentence(),
            times_s=dict(self._times),
            touched=self._contacts.touched,
            ground=self._contacts.ground,
            landing=self._landing,
            between_s=tuple(self._between_s),
        )

    def on_ready(self, ready: bool, awaited: str = "the hover") -> None:
        """Note whether the UAV hovers over the start and takes orders. awaited: the reason for waiting."""
        self._ready, self._awaited = ready, awaited

    def on_distance(self, distance_m: float) -> None:
        """Note the UAV's distance from its goal, for the sentence about a flight that ends too early."""
        self._distance_m = distance_m

    def on_waiting(self, reason: str) -> None:
        """Note why the UAV does not hover yet, in words; empty: it hovers."""
        self._no_hover = reason

    def on_clock_set(self, step_s: float) -> None:
        """Note that the clock was set ahead: no limit of time counts that."""
        self._set_by_s += step_s

    def on_time(self, t_s: float) -> list[Action]:
        """Take the present time. Call this at every true pose."""
        self._times.setdefault(Phase.WAITING, t_s)
        in_phase = t_s - self._times[self.phase] - self._set_by_s
        if self.phase is Phase.WAITING and self._ready:
            return self._enter(Phase.FLYING, t_s, Action.SEND_GOAL)
        if self.phase is Phase.FLYING and self._why_here:
            self._fail(self._why_here)
            return self._enter(Phase.LANDING, t_s, Action.LAND)
        if self._stands_in_flight(t_s):
            self._fail(self._own_descent or f"The UAV stood on the ground while {self.phase.value}.")
            return self._enter(Phase.LANDING, t_s, Action.LAND)
        if self.phase is Phase.HOVERING and in_phase >= self._parameters.hover_s:
            return self._enter(Phase.LANDING, t_s, Action.LAND)
        return self._on_too_late(t_s, in_phase)

    def land_here(self, why: str) -> None:
        """Note that the UAV must land where it is, and that the run fails; `why` is a sentence."""
        self._why_here = why

    def on_own_descent(self, t_s: float, why: str) -> None:
        """Note why the flight controller brings the UAV down by itself, a sentence; empty: it does not.

        The ground under it is no collision then.
        """
        if not (self._is_led or self.phase is Phase.WAITING):
            return
        if why and not self._own_descent:
            self._expect_landing(t_s)
        self._own_descent = why

    def on_landed(self, t_s: float, on_ground: bool) -> None:
        """Note whether the flight controller believes that the UAV stands on the ground."""
        self._was_in_air = self._was_in_air or not on_ground
        if not on_ground:
            self._grounded_s = None
        elif self._grounded_s is None:
            self._grounded_s = t_s

    @property
    def _is_led(self) -> bool:
        """Whether the UAV is in the air by this run's orders."""
        return self.phase in (Phase.FLYING, Phase.HOVERING) and not self.lands_between

    def _stands_in_flight(self, t_s: float) -> bool:
        since_s = self._grounded_s
        return self._is_led and self._was_in_air and since_s is not None and t_s - since_s >= GROUNDED_S

    def land_between(self, t_s: float) -> None:
        """The UAV is told to land between two parts: it may touch the ground and disarm."""
        self.lands_between, self._own_descent = True, ""
        self._between_s.append((t_s, math.inf))
        self._expect_landing(t_s)

    def fly_on(self, t_s: float) -> None:
        """The UAV hovers again after it has landed between two parts."""
        self.lands_between = False
        self._between_s[-1] = (self._between_s[-1][0], t_s)

    def stay_landed(self, t_s: float) -> list[Action]:
        """End the run on the ground, where the UAV has landed between two parts of its flight."""
        self._reached = True
        for phase in (Phase.HOVERING, Phase.LANDING):
            self._enter(phase, t_s)
        return self._enter(Phase.DONE, t_s, Action.FINISH)

    def on_goal_reached(self, t_s: float, reached: bool) -> None:
        """Note that the position controller has reached the goal."""
        if reached and self.phase is Phase.FLYING:
            self._reached = True
            self._enter(Phase.HOVERING, t_s)

    def on_contact(self, t_s: float, collision_1: str, collision_2: str, upwards: float = 0.0) -> None:
        """Note a contact between two collision shapes; see `Contacts.classify`."""
        in_flight = self._is_led and not self._own_descent
        finds_ground = not self.lands_between
        if self._contacts.classify(collision_1, collision_2, upwards, in_flight, finds_ground):
            self._touched_s = min(self._touched_s, t_s if t_s >= self._ordered_s else math.inf)

    def on_armed(self, t_s: float, armed: bool) -> list[Action]:
        """Note whether the motors may turn. Disarming after the landing is the end, good or bad."""
        if armed or self.phase is Phase.DONE:
            return []
        if self.phase is Phase.WAITING:
            if not (self._parameters.takes_off_once and self._was_in_air):
                return []
            untold = "The flight controller landed and disarmed before the UAV hovered over the start."
            self._fail(self._own_descent or untold)
            return self._enter(Phase.DONE, t_s, Action.FINISH)
        if self.lands_between or self.phase is Phase.LANDING:
            if self._is_good_landing(t_s) and self.lands_between:
                return []
        elif self._own_descent:
            self._fail(self._own_descent)
            self._is_good_landing(t_s)
        else:
            self._fail(f"The flight controller disarmed while {self.phase.value}, at {t_s:.1f} s.")
        return self._enter(Phase.DONE, t_s, Action.FINISH)

    def abort(self, t_s: float, why: str) -> list[Action]:
        """End the run at once, for a reason given as a sentence."""
        if self.phase is Phase.DONE:
            return []
        self._fail(why)
        return self._enter(Phase.DONE, t_s, Action.FINISH)

    def _expect_landing(self, t_s: float) -> None:
        self._ordered_s, self._touched_s, self._landing = t_s, math.inf, None

    def _is_good_landing(self, t_s: float) -> bool:
        """Judge a landing once, when the motors stop. A bad one fails the run."""
        if self._landing is None:
            truth = self._truth.since(self._ordered_s - max(REST_S, 2.0 * STEP_S))
            self._landing = (
                landing_of(truth, self._ordered_s, t_s, self._touched_s) if len(truth) else UNKNOWN
            )
            if self._landing.failure:
                self._fail(self._landing.failure)
        return self._landing.is_good

    def _on_too_late(self, t_s: float, in_phase_s: float) -> list[Action]:
        limit_s = self._limits_s.get(self.phase)
        if limit_s is None or in_phase_s < limit_s:
            return []
        self._fail(f"Still {self._doing()} after {limit_s:g} s{self._why_late()}.")
        if self.phase is Phase.FLYING:
            return self._enter(Phase.LANDING, t_s, Action.LAND)
        return self._enter(Phase.DONE, t_s, Action.FINISH)

    def _doing(self) -> str:
        return f"waiting for {self._awaited}" if self.phase is Phase.WAITING else self.phase.value

    def _why_late(self) -> str:
        if self.phase is Phase.WAITING and not self._ready and self._no_hover:
            return f": {self._no_hover}"
        if self.phase is Phase.FLYING and self._distance_m is not None:
            return f", {self._distance_m:.1f} m from it"
        return ""

    def _enter(self, phase: Phase, t_s: float, *actions: Action) -> list[Action]:
        self.phase, self._set_by_s = phase, 0.0
        self._times.setdefault(phase, t_s)
        if Action.LAND in actions:
            self._expect_landing(t_s)
        return list(actions)

    def _fail(self, why: str) -> None:
        self._failure = self._failure or why

    def _failure_sentence(self) -> str | None:
        return self._failure or self._contacts.failure
