"""CEPA for a UAV that cannot turn at once (thesis 10.1: "adjust further for vehicle dynamics")."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from cepa.algorithm import Algorithm
from cepa.decision import Decision, Reason, Vector2
from cepa.destination import Destination
from cepa.dynamic.candidates import REFERENCE, STANDSTILL, candidates, climbing, leads_back
from cepa.dynamic.cloud_lookout import HEIGHT_GAIN_S, NO_POINTS
from cepa.dynamic.cost import Cost
from cepa.dynamic.judge import LONGEST_COMMIT_S, Judge, cost_horizon_s
from cepa.dynamic.late_scans import MovingThings
from cepa.dynamic.leaving import Leaving
from cepa.dynamic.lookout import FIELD_CELL_M, RANGE_MARGIN_M, Lookout, Seen, Sight
from cepa.dynamic.observer import Observer
from cepa.dynamic.pseudo_3d import Plane
from cepa.dynamic.remembered.flicker import Flicker
from cepa.dynamic.spatial import Spatial, Way
from cepa.dynamic.view import Judgement, Moment, Report, View, report_of, view_of
from cepa.dynamic.ways_out import CELL_M as WAY_CELL_M
from cepa.dynamic.ways_out import NO_WAY_SEARCHED, Course, Ways, WaysOut, course_of
from cepa.kernels.surroundings import Surroundings
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters
from cepa.scan import LaserScan2D

COMMIT_PERIODS = 2.0
EVASION_M_S = 1.5
"""The UAV evades what moves with so much, even when the reference is slower."""
CLIMB_SHARES = (1.0, 0.5, 0.25)
"""Of the greatest climb: what it tries on the spot."""
AT_REST_M_S = 0.1
NOTHING, NOTHING_UNSEEN = np.empty((0, 2)), np.empty((0, 0, 0), np.uint8)


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
        model = p.response
        self._delay_s = model.delay_s
        self._judge = Judge(p)
        self._leaving = Leaving(p, self._judge.hull_m)
        self._observer = Observer(model)
        self._destination = Destination()
        self._lookout = Lookout(p)
        self._moving = MovingThings(p, self._lookout)
        self._flicker = Flicker()
        self._ways_out = WaysOut(p) if p.window_m > 0.0 else None
        self._cost = Cost(p)
        self._rotation, self._v_ref = np.empty((2, 2)), np.empty(2)
        self.wants_cloud = p.climb_max > 0.0
        super().__init__(p)

    def reset(self) -> None:
        """Forget what was seen, what moves and what was commanded."""
        super().reset()
        self._observer.reset()
        self._destination.reset()
        self._lookout.reset()
        self._moving.reset()
        self._flicker.reset()
        self._spatial: Spatial | None = None
        self._rangings: Sequence[Ranging] = ()
        self._leaving.reset()
        if self._ways_out is not None:
            self._ways_out.reset()
        self._stamp_s = -math.inf
        self._set_period(0.0)
        self._moment: Moment | None = None
        self._judgement: Judgement | None = None
        self._command = np.zeros(3)

    def take_over(self, earlier: Dynamic) -> None:
        """Take over what one with other parameters knows; that one must not be used any longer."""
        self._grid = earlier._grid
        self._moving.take_over(earlier._moving)
        self._flicker = earlier._flicker
        self._stamp_s = earlier._stamp_s
        self._set_period(earlier._period_s)
        self._command = earlier._command.copy()
        self._observer.take_over(earlier._observer)
        self._destination = earlier._destination
        self._lookout.take_over(earlier._lookout)
        if self._ways_out is not None and earlier._ways_out is not None:
            self._ways_out.take_over(earlier._ways_out)
        if self.wants_cloud and earlier._spatial is not None:
            self._spatial = Spatial(self.parameters)
            self._spatial.take_over(earlier._spatial)

    @property
    def commit_s(self) -> float:
        """How long an answer is safe to fly, s. Whoever flies it must brake when no other came until then."""
        return self._commit_s

    def take_ranges(self, rangings: Sequence[Ranging]) -> None:
        """Take in what range finders measured when the next scan was taken.

        From the first on the UAV climbs and sinks into what they or a cloud have seen.
        """
        self._rangings = rangings if self.wants_cloud else ()

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        """Return the velocity to fly.

        Without ``motion`` nothing is remembered. Once a cloud or a range finder's range came, the answer has
        a climb. While clouds come that look all around, the scan shows what moves, and nothing else.
        """
        beams = self.beams(scan)
        told = motion or self._guessed_motion(v_uav)
        is_known = motion is not None
        motion, state = self._state(told)
        self._motion = motion
        if is_known:
            beams = self._flicker.steadied(beams, motion, self._period_s)
        yaw_rad = motion.yaw_rad
        reference = self._along_odometry(v_ref, yaw_rad, motion.climb_ref_m_s)
        along_x, along_y, _ = reference.tolist()
        self._destination.update(motion.position_m, (along_x, along_y))
        points, seen, is_moving, discs = self._moving.see(beams, motion, told.age_s, scan.range_max)
        standing = NOTHING
        if len(points):
            standing = points[~is_moving, :2] if len(discs) else points[:, :2].copy()
        self._judgement = None
        if self.wants_cloud and (cloud or self._rangings or self._spatial):
            self._spatial = self._spatial or Spatial(self.parameters)
            self._spatial.watch(cloud, motion.stamp_s)
            plane = self._plane(standing, seen, motion) if self._spatial.wants_plane else None
            beam_ends = points[~is_moving] if plane is not None or cloud is None else NO_POINTS
            space = self._spatial.look(cloud, motion, discs, plane, self._rangings, beam_ends)
            self._rangings = ()
            near = space.points[self._is_at_the_body(space.points[:, 2]), :2]
            self._moment = Moment(motion, near, seen, state, discs, space)
            return self._steer_in_space(reference)
        self._lookout.keep(standing, seen, motion)
        self._moment = Moment(motion, standing, seen, state, discs)
        speed = math.hypot(along_x, along_y)
        if len(discs) or self._leads_away(speed) or self._lookout.is_astray:
            return self._steer_in_plane(reference)
        farthest_m = scan.range_max - RANGE_MARGIN_M
        if self._judge.is_clear(
            reference, speed, state, standing, beams, yaw_rad, farthest_m, self._commit_s
        ) and not self._lookout.knows_near(cost_horizon_s(self.parameters) * reference[:2], motion):
            return self._answer(reference, 0.0, 1, Reason.CUSHION_CLEAR)
        return self._steer_in_plane(reference)

    def _leads_away(self, speed: float) -> bool:
        """Whether the last way out did not begin towards the reference, so that it must be searched again."""
        if self._ways_out is None or not self._ways_out.leads_away:
            return False
        return speed >= self.parameters.reference_speed_min

    def _plane(self, standing: np.ndarray, seen: Seen, motion: Motion) -> Plane:
        """Return what a planar lidar knows, from the ends of its beams (n, 2), m, that stand still.

        At another height it sees past what stands below or above, so one such scan is enough to forget that.
        """
        self._lookout.keep(standing, seen, motion)
        sight = self._lookout.look(standing, seen, motion, patience=1)
        return Plane(seen.reach_m, self._lookout.distances(sight))

    def _is_at_the_body(self, heights_m: np.ndarray) -> np.ndarray:
        p = self.parameters
        return (-p.body_below <= heights_m) & (heights_m <= p.body_above)

    def report(self) -> Report | None:
        """Return the reasons of the last answer; None: there was none yet."""
        if self._moment is None:
            return None
        return report_of(self._moment, self._judgement, self.parameters.body_radius)

    def view(self) -> View | None:
        """Return what was known and foreseen at the last answer; None as for ``report``."""
        if self._moment is None:
            return None
        foreseen = self._command, self._judge.response, self._judge.horizon(self.commit_s), self._lookout
        return view_of(self._moment, self._judgement, *foreseen)

    def _guessed_motion(self, v_uav: tuple[float, float]) -> Motion:
        """Return the motion of a UAV whose odometry is not known: only its velocity counts."""
        self.reset()
        return Motion(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (*v_uav, 0.0))

    def _state(self, motion: Motion) -> tuple[Motion, np.ndarray]:
        """Return the motion at the scan's stamp, and the state (3, 4) when an answer shows its effect."""
        gap_s = motion.stamp_s - self._stamp_s
        if gap_s < 0.0:
            self.reset()  # the clock went back
        elif gap_s <= LONGEST_COMMIT_S:
            period_s = self._period_s
            self._set_period(period_s + 0.1 * (gap_s - period_s) if period_s else gap_s)
        self._stamp_s = motion.stamp_s
        told_s, later_s = motion.stamp_s - motion.age_s, motion.stamp_s + self._delay_s
        state = self._observer.update(told_s, motion.velocity_m_s, motion.stamp_s, later_s)
        turn_rad = self._moving.tell(motion)
        if motion.age_s > 0.0:
            motion = motion.moved(self._observer.way_m, turn_rad)
        return motion, state

    def _set_period(self, period_s: float) -> None:
        """Set the mean time between scans, s."""
        self._period_s = period_s
        self._commit_s = min(max(self.parameters.commit_s, COMMIT_PERIODS * period_s), LONGEST_COMMIT_S)

    def _steer_in_plane(self, reference: np.ndarray) -> Decision:
        """Choose among level velocities, by the scan and its memory."""
        assert self._moment is not None  # since steer
        speed, course = self._course(reference)
        _, standing, seen, state, discs, _ = self._moment
        sight = self._lookout.look(standing, seen, self._motion)
        around, has_way = self._surroundings(sight, discs, course, speed)
        fan_speed = max(speed, EVASION_M_S) if len(discs) else speed
        commands = candidates(reference, self._command, fan_speed)
        known = sight.remembered, sight.is_hidden
        is_allowed = leads_back(commands, sight.blind_way)
        return self._best_of_admissible(reference, commands, state, around, has_way, known, is_allowed)

    def _steer_in_space(self, reference: np.ndarray) -> Decision:
        """Choose among velocities with a climb, by clouds or by a plane and range finders."""
        assert self._moment is not None  # since steer
        assert self._spatial is not None
        p, space, discs = self.parameters, self._moment.space, self._moment.discs
        assert space is not None
        speed, course = self._course(reference)
        state = self._moment.state.copy()
        state[2, 0] -= space.middle_m
        fan_speed = max(speed, EVASION_M_S) if len(discs) else speed
        level = candidates(reference, self._command, fan_speed)
        height_m = self._spatial.open_height_m(space, course.direction, speed)
        commands = climbing(level, height_m / HEIGHT_GAIN_S, p.climb_max)
        around = self._spatial.around(space, discs)
        first = commands[REFERENCE : REFERENCE + 1]
        is_free, result = self._judge.judge(first, state, around, course.direction, self.commit_s)
        is_clear = is_free[0] and result[0, 1] == result[0, 2] == 0.0 and height_m == space.asked_m
        if is_clear and not (self._spatial.knows_one_height and self._leads_away(speed)):
            return self._answer(commands[REFERENCE], 0.0, 1, Reason.CUSHION_CLEAR)
        searches = speed >= p.reference_speed_min
        way = self._spatial.way(
            space, discs, course, height_m, self._motion, self._ways_out if searches else None
        )
        if way.climbs:
            return self._climb_on_the_spot(way, state)
        known = space.points, space.is_hidden
        choice = commands, state, way.around, way.is_open, known, True, way.height_m - space.middle_m
        return self._best_of_admissible(reference, *choice)

    def _climb_on_the_spot(self, way: Way, state: np.ndarray) -> Decision:
        """Climb or sink as fast as may be, to look for a way at other heights."""
        assert self._spatial is not None
        shares = way.climbs * np.array(CLIMB_SHARES)
        commands = np.stack(
            [np.zeros(len(shares)), np.zeros(len(shares)), self.parameters.climb_max * shares], 1
        )
        admissible, _ = self._judge.judge(commands, state, way.around, np.zeros(2), self.commit_s)
        if admissible.any():
            return self._answer(commands[admissible.argmax()], 0.0, len(commands), Reason.STEERED)
        if not np.any(np.abs(state[:, 1]) > AT_REST_M_S):
            self._spatial.give_up_height()
        return self._answer(np.zeros(3), math.inf, len(commands), Reason.BRAKING)

    def _best_of_admissible(
        self,
        reference: np.ndarray,
        commands: np.ndarray,
        state: np.ndarray,
        around: Surroundings,
        has_way: bool,
        known: tuple[np.ndarray, np.ndarray],
        is_allowed: np.ndarray | bool,
        height_m: float | None = None,
    ) -> Decision:
        """Return the least costly of the commands (n, 3) that are admissible, or the way out of an emergency.

        known: what is remembered, and which of it is hidden. is_allowed: (n,), of those that are admissible.
        height_m: to fly at, in the state's axes.
        """
        speed, course = self._course(reference)
        admissible, results = self._judge.judge(commands, state, around, course.direction, self.commit_s)
        admissible &= is_allowed
        self._judgement = Judgement(*known, int(admissible.sum()), self._judge.braking_margin_m)
        own_speed = math.hypot(state[0, 1], state[1, 1])
        cost = self._cost.of(commands, results, self._command, speed, own_speed)
        if height_m is not None:
            cost += self._cost.of_height(commands, results, self._command, height_m)
        cost[~admissible] = math.inf
        best = int(np.argmin(cost)) if has_way and np.isfinite(cost).any() else STANDSTILL
        if self._leaving.is_needed(around, float(results[best, 0]), speed, math.hypot(*course.end)):
            return self._leave(reference, state, around)
        is_reference = best == REFERENCE and np.array_equal(commands[best, :2], reference[:2])
        reason = Reason.NO_WAY if not has_way else Reason.BRAKING if best == STANDSTILL else Reason.STEERED
        if has_way and is_reference and results[best, 1] == results[best, 2] == 0.0:
            reason = Reason.CUSHION_CLEAR
        return self._answer(commands[best], float(cost[best]), len(commands), reason)

    def _leave(self, reference: np.ndarray, state: np.ndarray, around: Surroundings) -> Decision:
        """Return the admissible velocity that regains r_LB fastest; the hull's own margin must suffice."""
        p, speed = self.parameters, max(math.hypot(reference[0], reference[1]), self.parameters.v_max)
        direction = self._leaving.direction(around)
        straight = np.zeros(3) if direction is None else np.array([*(p.v_max * direction), 0.0])
        commands = candidates(straight, self._command, speed)
        if self._moment is not None and self._moment.space is not None:
            commands = climbing(commands, 0.0, p.climb_max)
        around = around._replace(way=NO_WAY_SEARCHED.length[None])
        away = np.zeros(2) if direction is None else direction
        admissible, results = self._judge.judge(
            commands, state, around, away, self.commit_s, is_emergency=True
        )
        cost = self._cost.of_leaving(commands, results, self._command, direction is not None)
        cost[~admissible] = math.inf
        best = int(np.argmin(cost)) if np.isfinite(cost).any() else STANDSTILL
        return self._answer(commands[best], float(cost[best]), len(commands), Reason.MARGIN_LOST)

    def _surroundings(
        self, sight: Sight, discs: np.ndarray, course: Course, speed: float
    ) -> tuple[Surroundings, bool]:
        """Return what is around the UAV, and whether there is a way out."""
        distance = self._lookout.distances(sight)
        ways: Ways | None = NO_WAY_SEARCHED
        if self._ways_out is not None and speed >= self.parameters.reference_speed_min:
            ways = self._ways_out.search(sight.obstacles, course, self._motion)
        length, *offset = ways or NO_WAY_SEARCHED
        field = distance, FIELD_CELL_M, 1.0, self._lookout.far_m
        seen = sight.reach, NOTHING_UNSEEN, 1.0
        return Surroundings(*field, *seen, discs, length[None], WAY_CELL_M, *offset), ways is not None

    def _course(self, reference: np.ndarray) -> tuple[float, Course]:
        return course_of(reference[:2], self._destination.gain_1_s, cost_horizon_s(self.parameters))

    def _along_odometry(self, v_ref: Vector2, yaw_rad: float, climb_m_s: float) -> np.ndarray:
        """Return the reference (3,), m/s, along the odometry's axes, and keep the turn for the answer."""
        self._turn = c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        rotation, reference = self._rotation, np.empty(3)
        rotation[0, 0] = rotation[1, 1] = c
        rotation[0, 1], rotation[1, 0] = -s, s
        self._v_ref[0], self._v_ref[1] = v_ref
        rotation.dot(self._v_ref, reference[:2])
        reference[2] = climb_m_s
        return reference

    def _answer(self, command: np.ndarray, cost: float, tested: int, reason: Reason) -> Decision:
        self._command = command
        (c, s), (x, y, up) = self._turn, command.tolist()
        self._observer.command(self._stamp_s, (x, y, up), self._commit_s)
        climb = up if self._moment is not None and self._moment.space is not None else None
        emergency = reason is Reason.MARGIN_LOST
        return Decision(
            (c * x + s * y, -s * x + c * y),
            emergency,
            cost,
            tested,
            reason,
            climb_m_s=climb,
            warnings=self._spatial.warnings if climb is not None and self._spatial is not None else (),
        )
