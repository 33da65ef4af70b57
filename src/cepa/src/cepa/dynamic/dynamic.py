"""CEPA for a UAV that cannot turn at once (thesis 10.1: "adjust further for vehicle dynamics")."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Sequence

import numpy as np

from cepa.algorithm import Algorithm, velocity
from cepa.decision import Decision, Reason
from cepa.dynamic.candidates import REFERENCE, STANDSTILL, candidates, climbing
from cepa.dynamic.cloud_lookout import HEIGHT_GAIN_S, LAYER_M, SEEN_CELL_M, CloudLookout
from cepa.dynamic.cost import Cost
from cepa.dynamic.lookout import FIELD_CELL_M, RANGE_MARGIN_M, Lookout, Sight
from cepa.dynamic.movers import Movers
from cepa.dynamic.observer import Observer, response_of
from cepa.dynamic.view import Judgement, Moment, Report, View, report_of, view_of
from cepa.dynamic.ways_out import CELL_M as WAY_CELL_M
from cepa.dynamic.ways_out import Layers, Ways, WaysOut
from cepa.kernels.rollout import Cushions, Horizon, Scan, Surroundings, braking, error_share, is_clear, judge
from cepa.motion import Cloud, Motion
from cepa.parameters import CepaParameters
from cepa.scan import LaserScan2D

STEP_S = 0.05
BRAKE_S, COST_HORIZON_S, HOLD_S = 3.0, 1.6, 0.6
COMMIT_PERIODS = 2.0
LONGEST_COMMIT_S = 0.5
NOISE_M = 0.06
"""The nearest of a thing's points is nearer than the thing by so much. So r_LB is kept within it."""
AHEAD_M = 2.0
"""It climbs to a height at which at least so much straight ahead is open."""
CLEAR_STRIDE = 4
"""The paths of the reference are looked at in every fourth step."""
NO_MOVERS = np.empty((0, 6))
EVASION_M_S = 1.5
"""The UAV evades what moves with so much, even when the reference is slower."""
NO_WAY_SEARCHED = Ways(np.empty((0, 0)), 0.0, 0.0)
NO_SIGHT = np.empty(0)
NOTHING_UNSEEN = np.empty((0, 0, 0), np.bool_)


class Dynamic(Algorithm):
    """Chooses the least costly of the velocities from which the UAV can still brake, whatever comes.

    A velocity is admissible if the UAV keeps its distance from everything, and stays within what has been
    seen, when it flies it for the commit time and then brakes. The braking that made the last answer
    admissible is always admissible itself. Inside, all vectors are along the odometry's axes, with the lidar
    at the origin.
    """

    wants_motion = True

    def __init__(self, parameters: CepaParameters | None = None):
        p = parameters or CepaParameters()
        model = p.response
        self._response = response_of(model, STEP_S)
        steps = _steps(LONGEST_COMMIT_S) + _steps(BRAKE_S)
        hull_m = float(p.body_radius + p.margin)
        tube_m = model.tube_m(STEP_S, steps)[1:]
        least_m = max(hull_m, p.r_lb - NOISE_M)
        self._cushions = Cushions(float(p.r_lb), float(p.r_ub), least_m, hull_m, tube_m)
        self._delay_s = model.delay_s
        self._least, self._most = np.empty(steps), np.empty(steps)
        self._observer = Observer(model)
        self._lookout = Lookout(p)
        self._movers = Movers()
        self._ways_out = WaysOut(p) if p.window_m > 0.0 else None
        self._cost = Cost(p)
        self.wants_cloud = p.climb_max > 0.0
        super().__init__(p)

    def reset(self) -> None:
        """Forget what was seen, what moves and what was commanded."""
        super().reset()
        self._observer.reset()
        self._lookout.reset()
        self._movers.reset()
        self._cloud_lookout: CloudLookout | None = None
        if self._ways_out is not None:
            self._ways_out.reset()
        self._stamp_s = -math.inf
        self._period_s = 0.0
        self._moment: Moment | None = None
        self._judgement: Judgement | None = None
        self._command = np.zeros(3)

    def take_over(self, earlier: Dynamic) -> None:
        """Take over what one with other parameters knows; that one must not be used any longer."""
        self._grid, self._movers = earlier._grid, earlier._movers
        self._stamp_s, self._period_s = earlier._stamp_s, earlier._period_s
        self._command = earlier._command.copy()
        self._observer.take_over(earlier._observer)
        self._lookout.take_over(earlier._lookout)
        if self._ways_out is not None and earlier._ways_out is not None:
            self._ways_out.take_over(earlier._ways_out)
        if self.wants_cloud and earlier._cloud_lookout is not None:
            self._cloud_lookout = CloudLookout(self.parameters)
            self._cloud_lookout.take_over(earlier._cloud_lookout)

    @property
    def commit_s(self) -> float:
        """How long an answer is safe to fly, s. Whoever flies it must brake when no other came until then."""
        return min(max(self.parameters.commit_s, COMMIT_PERIODS * self._period_s), LONGEST_COMMIT_S)

    def steer(
        self,
        scan: LaserScan2D,
        v_ref_xy: Sequence[float],
        v_uav_xy: Sequence[float] = (0.0, 0.0),
        motion: Motion | None = None,
        cloud: Cloud | None = None,
    ) -> Decision:
        """Return the velocity to fly, m/s in the scan's frame. Raises VelocityError.

        Without ``motion`` nothing is remembered. Once a cloud came, the scan counts no more, and the answer
        has a climb.
        """
        v_ref, v_uav = velocity(v_ref_xy, "v_ref"), velocity(v_uav_xy, "v_uav")
        beams = self.beams(scan)
        motion, state = self._state(motion or self._guessed_motion(v_uav))
        self._motion = motion
        turn = _rotation(motion.yaw_rad)
        reference = np.array([*(turn @ v_ref), motion.climb_ref_m_s])
        if self.wants_cloud and (cloud or self._cloud_lookout):
            return self._steer_in_space(reference, state, cloud, motion, turn)
        points, seen = self._lookout.see(beams, motion, scan.range_max)
        standing, discs = self._told_apart(points, seen, motion)
        self._lookout.keep(standing, seen, motion)
        self._moment, self._judgement = Moment(motion, standing, seen, state), None
        view = beams.ranges, beams.seen, beams.angle_0 + motion.yaw_rad, beams.increment
        clear_m = scan.range_max - RANGE_MARGIN_M
        if not len(discs) and self._is_clear(reference, state, Scan(standing, *view, clear_m)):
            return self._answer(reference, turn, 0.0, 1, Reason.CUSHION_CLEAR)
        sight = self._lookout.look(standing, seen, motion)
        return self._best_of_admissible(reference, state, sight, discs, turn)

    def _told_apart(
        self, points: np.ndarray, seen: np.ndarray, motion: Motion
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return which points (n, 2) stand still, m, and what moves as discs (k, 6) that grow."""
        here = np.array(motion.position_m[:2])
        p, z = self.parameters, motion.position_m[2]
        is_level = self._movers.clear_of_floor(points, p.floor_height - z, p.ceiling_height - z)
        moving = self._movers.update(motion.stamp_s, points[:, :2] + here, here, seen, is_level)
        discs = moving.discs(here)
        discs[:, :2] += self._delay_s * discs[:, 2:4]
        discs[:, 4] += self._delay_s * discs[:, 5]
        return points[~moving.is_moving, :2], discs

    def report(self) -> Report | None:
        """Return the reasons of the last answer; None: there was none yet, or it came from clouds."""
        if self._moment is None:
            return None
        return report_of(self._moment, self._judgement, self.parameters.body_radius)

    def view(self) -> View | None:
        """Return what was known and foreseen at the last answer; None as for ``report``."""
        if self._moment is None:
            return None
        foreseen = self._command, self._response, self._horizon(), self._lookout
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
            self._period_s += 0.1 * (gap_s - self._period_s) if self._period_s else gap_s
        self._stamp_s = motion.stamp_s
        self._observer.update(motion.stamp_s - motion.age_s, np.array(motion.velocity_m_s))
        way = np.zeros(3)
        if motion.age_s > 0.0:
            way = self._observer.state_at(motion.stamp_s)[:, 0]
            motion = motion.moved(way)
        state = self._observer.state_at(motion.stamp_s + self._delay_s)
        state[:, 0] -= way
        return motion, state

    def _keep(self, state: np.ndarray) -> np.ndarray:
        """Return the distance to keep after each step of braking, m."""
        cushions = self._cushions
        tube = error_share(state, 0.0, 0.0) * cushions.tube
        return np.maximum(cushions.least, cushions.hull + tube)

    def _is_clear(self, reference: np.ndarray, state: np.ndarray, scan: Scan) -> bool:
        """Whether the reference may be flown as it is: nothing is within r_UB of its paths, all is seen."""
        between_m = 0.5 * CLEAR_STRIDE * STEP_S * math.hypot(reference[0], reference[1])
        distance_m = math.hypot(self.parameters.r_ub, between_m)
        paths = state, reference, self._response, self._horizon()
        return bool(is_clear(*paths, scan, distance_m, float(self.parameters.body_radius), CLEAR_STRIDE))

    def _horizon(self) -> Horizon:
        return Horizon(
            math.ceil(self.commit_s / STEP_S - 1e-6), _steps(BRAKE_S), _steps(COST_HORIZON_S), _steps(HOLD_S)
        )

    def _best_of_admissible(
        self, reference: np.ndarray, state: np.ndarray, sight: Sight, discs: np.ndarray, turn: np.ndarray
    ) -> Decision:
        speed, direction = _course(reference)
        around, has_way = self._surroundings(sight, discs, direction, speed)
        fan_speed = max(speed, EVASION_M_S) if len(discs) else speed
        commands = candidates(reference, self._command, fan_speed)
        admissible, results = self._judged(commands, state, around, direction)
        margin_m = float((self._least - self._keep(state))[: sum(self._horizon()[:2])].min())
        self._judgement = Judgement(sight, around, int(admissible.sum()), margin_m)
        cost = self._cost.of(commands, results, self._command, speed)
        cost[~admissible] = math.inf
        return self._least_costly(commands, cost, results, around, has_way, turn)

    def _steer_in_space(
        self, reference: np.ndarray, state: np.ndarray, cloud: Cloud | None, motion: Motion, turn: np.ndarray
    ) -> Decision:
        """Choose among velocities with a climb, by clouds; None: this one is missing."""
        self._moment = self._judgement = None
        p, (speed, direction) = self.parameters, _course(reference)
        if self._cloud_lookout is None:
            self._cloud_lookout = CloudLookout(p)
        space = self._cloud_lookout.look(cloud, motion)
        state[2, 0] -= space.middle_m
        field = space.distance, FIELD_CELL_M, LAYER_M, self._cloud_lookout.far_m
        seen = NO_SIGHT, space.unseen, SEEN_CELL_M, NO_MOVERS
        length, *offset = NO_WAY_SEARCHED
        around = Surroundings(*field, *seen, length[None], WAY_CELL_M, *offset)
        height_m = space.open_height_m(direction, max(AHEAD_M, speed * COST_HORIZON_S), p.r_lb)
        level = candidates(reference, self._command, speed)
        commands = climbing(level, height_m / HEIGHT_GAIN_S, p.climb_max)
        is_free, result = self._judged(commands[REFERENCE : REFERENCE + 1], state, around, direction)
        if is_free[0] and result[0, 1] == result[0, 2] == 0.0 and height_m == space.asked_m:
            decision = self._answer(commands[REFERENCE], turn, 0.0, 1, Reason.CUSHION_CLEAR)
            return replace(decision, climb_m_s=float(self._command[2]))
        ways: Ways | None = NO_WAY_SEARCHED
        if self._ways_out is not None and speed >= p.reference_speed_min:
            layers = Layers(space.distance, FIELD_CELL_M, space.detours_m)
            ways = self._ways_out.search_layers(layers, direction, motion)
        length, *offset = ways or NO_WAY_SEARCHED
        around = Surroundings(*field, *seen, length[None], WAY_CELL_M, *offset)
        admissible, results = self._judged(commands, state, around, direction)
        cost = self._cost.of(commands, results, self._command, speed)
        cost += self._cost.of_height(commands, results, self._command, height_m - space.middle_m)
        cost[~admissible] = math.inf
        decision = self._least_costly(commands, cost, results, around, ways is not None, turn)
        return replace(decision, climb_m_s=float(self._command[2]))

    def _least_costly(
        self,
        commands: np.ndarray,
        cost: np.ndarray,
        results: np.ndarray,
        around: Surroundings,
        has_way: bool,
        turn: np.ndarray,
    ) -> Decision:
        best = int(np.argmin(cost)) if has_way and np.isfinite(cost).any() else STANDSTILL
        reason = self._reason(best, has_way, around, results[best])
        return self._answer(commands[best], turn, float(cost[best]), len(commands), reason)

    def _surroundings(
        self, sight: Sight, discs: np.ndarray, direction: np.ndarray, speed: float
    ) -> tuple[Surroundings, bool]:
        """Return what is around the UAV, and whether there is a way out."""
        distance = self._lookout.distances(sight)
        ways: Ways | None = NO_WAY_SEARCHED
        if self._ways_out is not None and speed >= self.parameters.reference_speed_min:
            obstacles = np.concatenate((sight.points, sight.hidden))
            ways = self._ways_out.search(obstacles, direction, self._motion)
        length, *offset = ways or NO_WAY_SEARCHED
        field = distance, FIELD_CELL_M, 1.0, self._lookout.far_m
        seen = sight.reach, NOTHING_UNSEEN, 1.0
        return Surroundings(*field, *seen, discs, length[None], WAY_CELL_M, *offset), ways is not None

    def _judged(
        self, commands: np.ndarray, state: np.ndarray, around: Surroundings, direction: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return which commands (n, 3) are admissible (n,), and what flying them brings (n, 4)."""
        horizon = self._horizon()
        braking(state, self._response, around, horizon, self._least, self._most)
        admissible, results = np.empty(len(commands), np.bool_), np.zeros((len(commands), 4))
        world = self._response, around, horizon, self._cushions, self._least, self._most
        judge(state, commands, *world, direction, admissible, results)
        return admissible, results

    def _reason(self, best: int, has_way: bool, around: Surroundings, result: np.ndarray) -> Reason:
        p = self.parameters
        middle = around.distance.shape[1] // 2
        if around.distance[around.distance.shape[0] // 2, middle, middle] < p.body_radius + p.margin:
            return Reason.MARGIN_LOST
        if not has_way:
            return Reason.NO_WAY
        if best == STANDSTILL:
            return Reason.BRAKING
        clear = best == REFERENCE and result[1] == 0.0 and result[2] == 0.0
        return Reason.CUSHION_CLEAR if clear else Reason.STEERED

    def _answer(
        self, command: np.ndarray, turn: np.ndarray, cost: float, tested: int, reason: Reason
    ) -> Decision:
        self._command = command.copy()
        self._observer.command(self._stamp_s, command, self.commit_s)
        x, y = turn.T @ command[:2]
        return Decision((float(x), float(y)), reason is Reason.MARGIN_LOST, cost, tested, reason)


def _course(reference: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the reference's horizontal speed, m/s, and its direction (2,); zeros if it has none."""
    speed = math.hypot(reference[0], reference[1])
    return speed, reference[:2] / speed if speed > 0.0 else np.zeros(2)


def _rotation(angle_rad: float) -> np.ndarray:
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, -s], [s, c]])


def _steps(seconds: float) -> int:
    return round(seconds / STEP_S)
