"""CEPA for a UAV that cannot turn at once (thesis 10.1: "adjust further for vehicle dynamics")."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from cepa.algorithm import Algorithm, velocity
from cepa.decision import Decision, Reason
from cepa.dynamic.candidates import candidates
from cepa.dynamic.lookout import FIELD_CELL_M, RANGE_MARGIN_M, Lookout, Sight
from cepa.dynamic.observer import Observer
from cepa.dynamic.ways_out import CELL_M as WAY_CELL_M
from cepa.dynamic.ways_out import WaysOut
from cepa.kernels.rollout import Cushions, Horizon, Response, Scan, Surroundings, braking, is_clear, judge
from cepa.motion import Cloud, Motion
from cepa.parameters import CepaParameters
from cepa.scan import LaserScan2D

STEP_S = 0.05
COMMIT_S, BRAKE_S = 0.1, 2.5
COST_HORIZON_S = 1.6
STANDSTILL = 2
"""Its row among the candidates."""
NOWHERE = np.empty((0, 0))
CLIMB_LAG_S = 0.35
CLEAR_STRIDE = 4
NO_MOVERS = np.empty((0, 6))
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
        self._observer = Observer(model)
        climb_gain = 1.0 - math.exp(-STEP_S / CLIMB_LAG_S)
        self._response = Response(*model.transition(STEP_S), model.acceleration_max_m_s2, climb_gain, STEP_S)
        steps = (round(seconds / STEP_S) for seconds in (COMMIT_S, BRAKE_S, COST_HORIZON_S))
        self._horizon = Horizon(*steps)
        braking_steps = self._horizon.commit + self._horizon.brake
        tube = model.tube_m(STEP_S, braking_steps)[1:]
        self._cushions = Cushions(
            float(p.r_lb), float(p.r_ub), np.maximum(p.r_lb, p.body_radius + p.margin + tube)
        )
        self._lookout = Lookout(p)
        self._ways_out = WaysOut(p) if p.window_m > 0.0 else None
        self._least, self._most = np.empty(braking_steps), np.empty(braking_steps)
        super().__init__(p)

    def reset(self) -> None:
        """Forget what was seen, what moves and what was commanded."""
        super().reset()
        self._observer.reset()
        self._lookout.reset()
        self._stamp_s = math.nan
        self._command = np.zeros(3)

    @property
    def commit_s(self) -> float:
        """How long an answer is safe to fly, s. Whoever flies it must brake if no other came until then."""
        return COMMIT_S

    def steer(
        self,
        scan: LaserScan2D,
        v_ref_xy: Sequence[float],
        v_uav_xy: Sequence[float] = (0.0, 0.0),
        motion: Motion | None = None,
        cloud: Cloud | None = None,
    ) -> Decision:
        """Return the velocity to fly, m/s in the scan's frame. Raises VelocityError.

        Without ``motion`` nothing is remembered.
        """
        v_ref, v_uav = velocity(v_ref_xy, "v_ref"), velocity(v_uav_xy, "v_uav")
        beams = self.beams(scan)
        motion = motion or self._guessed_motion(v_uav)
        turn = _rotation(motion.yaw_rad)
        reference = np.array([*(turn @ v_ref), motion.climb_ref_m_s])
        state = self._state(motion)
        points = self._lookout.points(beams, motion, scan.range_max)
        self._lookout.keep(beams, points, motion, scan.range_max)
        angle_0 = beams.angle_0 + motion.yaw_rad
        seen = Scan(
            points, beams.ranges, beams.seen, angle_0, beams.increment, scan.range_max - RANGE_MARGIN_M
        )
        if self._is_clear(reference, state, seen):
            return self._answer(reference, turn, 0.0, 1, Reason.CUSHION_CLEAR)
        sight = self._lookout.look(beams, points, motion, scan.range_max)
        return self._best_of_admissible(reference, state, sight, turn)

    def _guessed_motion(self, v_uav: tuple[float, float]) -> Motion:
        """Return the motion of a UAV whose odometry is not known: only its velocity counts."""
        self.reset()
        return Motion(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (*v_uav, 0.0))

    def _state(self, motion: Motion) -> np.ndarray:
        velocity_m_s = np.array(motion.velocity_m_s)
        dt_s = motion.stamp_s - self._stamp_s
        self._stamp_s = motion.stamp_s
        state = np.zeros((3, 4))
        state[:2] = self._observer.update(dt_s, self._command[:2], velocity_m_s[:2])
        state[2, 1] = velocity_m_s[2]
        return state

    def _is_clear(self, reference: np.ndarray, state: np.ndarray, scan: Scan) -> bool:
        """Whether the reference may be flown as it is: nothing is within r_UB of its paths, all is seen."""
        distance = self._cushions.outer + 0.5 * CLEAR_STRIDE * STEP_S * float(np.hypot(*reference[:2])) * 0.25
        paths = state, reference, self._response, self._horizon
        return bool(is_clear(*paths, scan, distance, float(self.parameters.body_radius), CLEAR_STRIDE))

    def _best_of_admissible(
        self, reference: np.ndarray, state: np.ndarray, sight: Sight, turn: np.ndarray
    ) -> Decision:
        p = self.parameters
        speed = math.hypot(reference[0], reference[1])
        direction = reference[:2] / speed if speed > 0.0 else turn[:, 0]
        way = NOWHERE
        if self._ways_out is not None and speed >= p.reference_speed_min:
            obstacles = np.concatenate((sight.points, sight.remembered))
            found = self._ways_out.search(obstacles, direction)
            way = NOWHERE if found is None else found
        around = Surroundings(
            self._lookout.distances(sight),
            FIELD_CELL_M,
            1.0,
            self._lookout.far_m,
            sight.reach,
            NOTHING_UNSEEN,
            1.0,
            NO_MOVERS,
            way,
            WAY_CELL_M,
        )
        braking(state, self._response, around, self._horizon, self._least, self._most)
        commands = candidates(reference, self._command, speed)
        admissible, results = np.empty(len(commands), np.bool_), np.zeros((len(commands), 4))
        paths = self._response, around, self._horizon, self._cushions, self._least, self._most
        judge(state, commands, *paths, direction, admissible, results)
        cost = self._cost(commands, results, speed)
        cost[~admissible] = math.inf
        best = int(np.argmin(cost))
        if not admissible.any():
            return self._answer(commands[STANDSTILL], turn, math.inf, len(commands), Reason.BRAKING)
        return self._answer(commands[best], turn, float(cost[best]), len(commands), Reason.STEERED)

    W_COMFORT, W_CHANGE, W_LOST = 0.6, 0.05, 0.6

    def _cost(self, commands: np.ndarray, results: np.ndarray, speed: float) -> np.ndarray:
        """Return the cost of each candidate (n,)."""
        progress, discomfort, lost, _height = results.T
        change = np.hypot(*(commands - self._command)[:, :2].T)
        scale = 1.0 / max(speed, 1.0)
        return (
            self.W_COMFORT * discomfort
            + self.W_LOST * lost
            + self.W_CHANGE * scale * change
            - scale * progress
        )

    def _answer(
        self, command: np.ndarray, turn: np.ndarray, cost: float, tested: int, reason: Reason
    ) -> Decision:
        self._command = command.copy()
        x, y = turn.T @ command[:2]
        return Decision((float(x), float(y)), False, cost, tested, reason)


def _rotation(angle_rad: float) -> np.ndarray:
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, -s], [s, c]])
