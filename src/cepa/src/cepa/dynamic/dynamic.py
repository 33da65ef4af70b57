"""One step of CEPA for a UAV that cannot turn at once (thesis 10.1, vehicle dynamics)."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from cepa.algorithm import Algorithm
from cepa.decision import Decision, Reason, Vector2
from cepa.dynamic.candidates import REFERENCE, STANDSTILL, Chosen, candidates, leads_back
from cepa.dynamic.constants.choice import EVASION_M_S, SAME_SPEED_M_S
from cepa.dynamic.constants.response import MEETING_S
from cepa.dynamic.cost import Cost, limit_progress
from cepa.dynamic.cost_to_go.course import Course, Reference, course_of, reference_of
from cepa.dynamic.cost_to_go.hold_up import HoldUp
from cepa.dynamic.cost_to_go.search import CostToGoSearch
from cepa.dynamic.destination import Destination
from cepa.dynamic.heading import Heading
from cepa.dynamic.kernels.rollout import DISCOMFORT, LOSS, PROGRESS
from cepa.dynamic.knowledge import Knowledge, Observation, Outlook, Step
from cepa.dynamic.observer import Observer
from cepa.dynamic.obstacle_tracks.separation import Came, Separation
from cepa.dynamic.plane_knowledge import PlaneKnowledge
from cepa.dynamic.remembered.single_beams import SingleBeams
from cepa.dynamic.report import Considered, Explanation, Report, View, report_of, view_of
from cepa.dynamic.rollouts import Rollouts, cost_horizon_s
from cepa.dynamic.space_knowledge import SpaceKnowledge
from cepa.dynamic.threats import evasion_speed
from cepa.dynamic.timing import ScanTiming
from cepa.dynamic.ways_out.ways_out import WaysOut, must_brake_hard
from cepa.keep_out import KeepOut
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters
from cepa.scan import LaserScan2D


class Dynamic(Algorithm):
    """Chooses the least costly of the velocities from which the UAV can still brake, whatever comes.

    A velocity is admissible if the UAV keeps its distance from everything, and stays within what has been
    seen, when it flies it for the commit time and then brakes. The braking that made the last answer
    admissible is always admissible itself. Inside, all vectors are along the odometry's axes, with the lidar
    at the origin.
    """

    wants_motion = True
    wants_single_beams = True

    def __init__(self, parameters: CepaParameters | None = None):
        p = parameters or CepaParameters()
        self._delay_s = p.response.delay_s
        self._observer = Observer(p.response)
        self._timing = ScanTiming(p.commit_s)
        self._single_beams = SingleBeams()
        self._separation, self._destination = Separation(p), Destination()
        self._rollouts = Rollouts(p)
        self._search = CostToGoSearch(p) if p.window_m > 0.0 else None
        self._plane = PlaneKnowledge(p, self._rollouts, self._search)
        self._cost = Cost(p)
        self._ways_out = WaysOut(p, self._rollouts, self._cost)
        self.wants_cloud = p.climb_max > 0.0
        self._hold_up = HoldUp()
        self._hold_up.is_planned = self._search is None
        super().__init__(p)

    def reset(self) -> None:
        """Forget what was seen, what moves and what was commanded."""
        super().reset()
        for part in (self._observer, self._timing, self._single_beams, self._separation):
            part.reset()
        for part_of_choice in (self._destination, self._plane, self._ways_out, self._hold_up):
            part_of_choice.reset()
        if self._search is not None:
            self._search.reset()
        self._space: SpaceKnowledge | None = None
        self._is_guessed = False  # whether the last motion was
        self._rangings: Sequence[Ranging] = ()  # of the next scan
        self._command = np.zeros(3)  # the last one
        self._explanation: Explanation | None = None  # for report and view only

    def take_over(self, earlier: Dynamic) -> None:
        """Take over what one with other parameters knows; that one must not be used any longer."""
        self._grid = earlier._grid
        self._observer.take_over(earlier._observer)
        self._timing.take_over(earlier._timing)
        self._single_beams = earlier._single_beams
        self._separation.take_over(earlier._separation)
        self._destination = earlier._destination
        self._plane.take_over(earlier._plane)
        self._hold_up = earlier._hold_up
        self._hold_up.is_planned = self._search is None
        self._command, self._is_guessed = earlier._command.copy(), earlier._is_guessed
        if self._search is not None and earlier._search is not None:
            self._search.take_over(earlier._search)
        if self.wants_cloud and earlier._space is not None:
            self._space = self._new_space()
            self._space.take_over(earlier._space)

    @property
    def commit_s(self) -> float:
        """How long an answer is safe to fly, s. Whoever flies it must brake when no other came until then."""
        return self._timing.commit_s

    def take_ranges(self, rangings: Sequence[Ranging]) -> None:
        """Take in what range finders measured when the next scan was taken.

        From the first on the UAV climbs and sinks into what they or a cloud have seen.
        """
        self._rangings = rangings if self.wants_cloud else ()

    def take_ready(self, is_ready: bool) -> None:
        """Take in whether the UAV flies what is answered. It changes what is told, never an answer."""
        self._hold_up.is_ready = is_ready

    def take_keep_out(self, keep_out: KeepOut) -> None:
        """Keep out of these boxes from now on: their walls count as obstacles."""
        self._separation.keep_out = keep_out

    def report(self) -> Report | None:
        """Return the reasons of the last answer; None: there was none yet."""
        return report_of(self._explanation, self.parameters.body_radius) if self._explanation else None

    def view(self) -> View | None:
        """Return what was known and foreseen at the last answer; None as for ``report``."""
        if self._explanation is None:
            return None
        horizon = self._rollouts.horizon(self.commit_s)
        return view_of(self._explanation, self._rollouts.response, horizon)

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        """Return the velocity to fly.

        Without ``motion`` nothing is remembered. Once a cloud or a range finder's range came, the answer has
        a climb. The numbers are those of "One step" in doc/dynamic.md.
        """
        beams = self.beams(scan)
        told = self._told(motion, v_uav)
        now, state = self._estimate(told)  # 1 state
        if motion is not None:
            beams = self._single_beams.confirmed(beams, now, self._timing.period_s)  # 2 what stands
        heading = Heading(now.yaw_rad)
        reference = reference_of(heading.into_odometry(self._allowed(v_ref), now.climb_ref_m_s))
        self._destination.update(now.position_m, reference.velocity.tolist())
        rangings, self._rangings = self._rangings, ()
        came = Came(
            beams,
            scan.range_max,
            now,
            told.age_s,
            state,
            cloud,
            rangings,
            reference.speed,
            self._hold_up.is_held,
        )
        observed = self._separation.observe(came, self._space)  # 2 what moves
        knowledge = self._knowledge_of(observed)
        snapshot = knowledge.take_in(observed)  # 2 memory
        snapshot = self._separation.with_newest(snapshot, self._space, reference.speed)
        step = Step(knowledge, snapshot, reference, heading, self._command, self.commit_s)
        clear = knowledge.clear_reference(step.snapshot, reference, self.commit_s)  # 3 clear?
        if clear is not None:
            if self._search is not None and self._is_asked(reference):
                self._search.fly_clear(now.stamp_s)
            return self._answer(step, Chosen(clear, 0.0, 1, Reason.CUSHION_CLEAR))
        course = course_of(reference, self._destination.gain_1_s, cost_horizon_s(self.parameters))
        outlook = knowledge.outlook(step.snapshot, reference, course)  # 4 cost-to-go
        if outlook.search_climb:
            return self._answer(step, self._ways_out.climb_on_the_spot(step, outlook))
        return self._least_costly(step, outlook, course)  # 5 to 8

    def _allowed(self, v_ref: Vector2) -> Vector2:
        """Return the reference, slower where nobody can see what is over and under the scan's plane."""
        most_m_s, speed = self.parameters.planar_speed_max, math.hypot(*v_ref)
        if speed <= most_m_s or (self._space is not None and self._space.has_clouds):
            return v_ref
        return v_ref[0] * most_m_s / speed, v_ref[1] * most_m_s / speed

    def _is_asked(self, reference: Reference) -> bool:
        """Return whether the UAV is asked to fly, and not to hover."""
        return reference.speed >= self.parameters.reference_speed_min or reference.is_steep

    def _told(self, motion: Motion | None, v_uav: tuple[float, float]) -> Motion:
        """Return the motion, or a guess of it without odometry: only its velocity counts.

        The place of a guess is none. So what was seen from there is forgotten as soon as odometry comes, too.
        """
        if motion is None or self._is_guessed:
            self.reset()
        self._is_guessed = motion is None
        return motion or Motion(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (*v_uav, 0.0))

    def _estimate(self, told: Motion) -> tuple[Motion, np.ndarray]:
        """Return the motion at the scan's stamp, and the state (3, 4) when an answer shows its effect.

        told: by odometry, which may be older than the scan.
        """
        if self._timing.goes_back(told.stamp_s):
            self.reset()
        self._timing.take_in(told.stamp_s)
        told_s, later_s = told.stamp_s - told.age_s, told.stamp_s + self._delay_s
        state, way_m = self._observer.update(told_s, told.velocity_m_s, told.stamp_s, later_s)
        turn_rad = self._separation.tell(told)
        return (told.moved(way_m, turn_rad) if told.age_s > 0.0 else told), state

    def _knowledge_of(self, observed: Observation) -> Knowledge:
        """Return what takes in an observation: from the first cloud or range on that in space."""
        if not self.wants_cloud or not (observed.cloud or observed.rangings or self._space):
            return self._plane
        self._space = self._space or self._new_space()
        return self._space

    def _new_space(self) -> SpaceKnowledge:
        return SpaceKnowledge(self.parameters, self._rollouts, self._search, self._plane)

    def _least_costly(self, step: Step, outlook: Outlook, course: Course) -> Decision:
        """Return the least costly of the admissible candidates, or the way out of an emergency."""
        aside = self._ways_out.make_way(step, outlook, self._shown(step))
        if aside is not None:
            return self._answer(step, aside)
        reference, around, state = step.reference, outlook.around, step.snapshot.state
        is_threatened = len(around.movers) > 0
        fan_speed = max(reference.speed, EVASION_M_S) if is_threatened else reference.speed
        evades_at = evasion_speed(around.movers, fan_speed)
        level = candidates(reference.velocity, self._command, fan_speed, evades_at)
        commands = step.with_climbs(level, outlook.climb_m_s)  # 5 candidates
        flown = commands, state, around, course.direction, self.commit_s
        assessed = self._rollouts.assess_passing(*flown, step.snapshot.observed.moving)
        outcomes = assessed.outcomes
        is_admissible = assessed.is_admissible & leads_back(commands, outlook.blind_way)  # 6 admissible
        if is_threatened:
            asked_m, has_end = reference.speed * MEETING_S, around.cost_to_go.length.size > 0
            is_faster = np.hypot(commands[:, 0], commands[:, 1]) > fan_speed + SAME_SPEED_M_S
            limit_progress(outcomes[:, PROGRESS], asked_m, has_end, is_faster, is_admissible)
        own_speed = math.hypot(state[0, 1], state[1, 1])
        cost = self._cost.of(commands, outcomes, self._command, reference.speed, own_speed)  # 7 cost
        if outlook.height_m is not None:
            missed = outcomes, self._command, outlook.height_m
            cost += self._cost.of_height(commands, *missed, reference.is_steep)
        cost[~is_admissible] = math.inf
        best = int(np.argmin(cost)) if outlook.has_way and np.isfinite(cost).any() else STANDSTILL
        considered = Considered(
            outlook.remembered, outlook.is_hidden, int(is_admissible.sum()), assessed.braking_margin_m
        )
        end_m, progress_m = math.hypot(*course.end), float(outcomes[best, PROGRESS])
        is_emergency = self._ways_out.must_leave(around, progress_m, reference.speed, end_m)  # 8 emergency
        is_safe = is_admissible[best] and outcomes[best, LOSS] == 0.0
        if assessed.brakes_too_late and (is_emergency or not is_safe) and must_brake_hard(step):
            return self._answer(step, self._ways_out.brake_hard(step, len(commands)), considered)
        if is_emergency:
            return self._answer(step, self._ways_out.leave(step, outlook), considered)
        is_reference = best == REFERENCE and np.array_equal(commands[best, :2], reference.velocity[:2])
        is_clear = is_reference and outcomes[best, DISCOMFORT] == outcomes[best, LOSS] == 0.0
        reason = _reason(outlook.has_way, is_clear, best)
        chosen = Chosen(commands[best], float(cost[best]), len(commands), reason)
        return self._answer(step, chosen, considered)

    def _shown(self, step: Step) -> np.ndarray:
        """Return those of the columns (k, 8) that tell how soon the UAV must be gone."""
        observed = step.snapshot.observed
        is_by_clouds = self._separation.clouds_show_loads(observed.motion, self._space)
        return observed.falling if is_by_clouds else observed.columns

    def _answer(self, step: Step, chosen: Chosen, considered: Considered | None = None) -> Decision:
        """Return what was chosen as an answer, and keep what the next step needs of it."""
        command, cost, tested, reason = chosen
        self._command = command
        x, y, up = command.tolist()
        motion = step.snapshot.observed.motion
        stamp_s = motion.stamp_s
        returns = self._search.returns(stamp_s) if self._search is not None else 0
        asked = step.reference.velocity, self._is_asked(step.reference)
        told = self._hold_up.take_in(stamp_s, motion.position_m, *asked, returns)
        why = step.knowledge, step.snapshot, command, considered, self._hold_up.held_s, returns
        self._explanation = Explanation(*why)
        self._observer.command(stamp_s, (x, y, up), self.commit_s)
        return Decision(
            step.heading.into_scan(x, y),
            reason is Reason.MARGIN_LOST,
            cost,
            tested,
            reason,
            climb_m_s=up if step.snapshot.space is not None else None,
            warnings=(*step.snapshot.warnings, *told),
        )


def _reason(has_way: bool, is_clear: bool, best: int) -> Reason:
    """Return why candidate ``best`` is the answer. is_clear: it is the reference, and nothing is near it."""
    if not has_way:
        return Reason.NO_WAY
    if is_clear:
        return Reason.CUSHION_CLEAR
    return Reason.BRAKING if best == STANDSTILL else Reason.STEERED
