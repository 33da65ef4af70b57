"""Judges commands by the paths that the UAV would fly."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.observer import response_of
from cepa.kernels.rollout import braking, is_clear, judge
from cepa.kernels.surroundings import Cushions, Horizon, Surroundings
from cepa.parameters import CepaParameters
from cepa.scan import Beams

STEP_S = 0.05
BRAKE_S, HOLD_S, LONGEST_COST_S = 3.0, 0.6, 4.0
LONGEST_COMMIT_S = 0.5
NOISE_M = 0.06
"""The nearest of a thing's points is nearer than the thing by so much. So r_LB is kept within it."""
MEETING_S = 3.0
"""The cost looks so far ahead while something moves: to step aside takes so long."""
CLEAR_STRIDE = 4
HALF_STRIDE_S = 0.5 * CLEAR_STRIDE * STEP_S
"""The paths of the reference are looked at in every fourth step."""
LEAST_COMFORT_M = 0.05
"""In an emergency comfort begins so far beyond the margin at the least."""


class Judge:
    """Knows the UAV's response and the distances to keep. Vectors are as in kernels/rollout.py."""

    def __init__(self, parameters: CepaParameters):
        p, model = parameters, parameters.response
        self._r_ub_m, self._radius_m = float(p.r_ub), float(p.body_radius)
        self.response = response_of(model, STEP_S)
        steps = _steps(LONGEST_COMMIT_S) + _steps(BRAKE_S)
        tube_m = model.tube_m(STEP_S, steps)[1:]
        self.hull_m = float(p.body_radius + p.margin)
        least_m = max(self.hull_m, p.r_lb - NOISE_M)
        self._usual = Cushions(float(p.r_lb), float(p.r_ub), least_m, self.hull_m, tube_m)
        comfort_m = max(float(p.r_lb), self.hull_m + LEAST_COMFORT_M)
        self._emergency = Cushions(self.hull_m, comfort_m, self.hull_m, self.hull_m, tube_m)
        self._least, self._most = np.empty(steps), np.empty(steps)
        self._commit_s, self.braking_margin_m = 0.0, math.inf
        """How much more than it must keep the UAV keeps from everything if it brakes at once, m, at the last
        ``judge``."""
        self._horizon = Horizon(0, _steps(BRAKE_S), _steps(cost_horizon_s(p)), _steps(HOLD_S))

    def horizon(self, commit_s: float) -> Horizon:
        """Return how far ahead paths are judged."""
        if commit_s != self._commit_s:
            self._commit_s = commit_s
            self._horizon = self._horizon._replace(commit=math.ceil(commit_s / STEP_S - 1e-6))
        return self._horizon

    def judge(
        self,
        commands: np.ndarray,
        state: np.ndarray,
        around: Surroundings,
        direction: np.ndarray,
        commit_s: float,
        is_emergency: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return which commands (n, 3) are admissible (n,), and what flying them brings (n, 5).

        is_emergency: only the margin of the hull is kept, and comfort ends at r_LB.
        """
        horizon = self.horizon(commit_s)
        if len(around.movers):
            horizon = horizon._replace(cost=_steps(MEETING_S))
        brakes = self.response, around, horizon, self._usual, self._least, self._most
        nearest_m, self.braking_margin_m = braking(state, *brakes)
        admissible, results = np.empty(len(commands), np.bool_), np.zeros((len(commands), 5))
        cushions = self._emergency if is_emergency else self._usual
        world = self.response, around, horizon, cushions, self._least, self._most, nearest_m
        judge(state, commands, *world, direction, admissible, results)
        return admissible, results

    def is_clear(
        self,
        reference: np.ndarray,
        speed: float,
        state: np.ndarray,
        points: np.ndarray,
        beams: Beams,
        yaw_rad: float,
        farthest_m: float,
        commit_s: float,
    ) -> bool:
        """Whether the reference may be flown as it is: nothing is within r_UB of its paths, all is seen.

        speed: of the reference. points: (n, 2) m, the ends of the beams. yaw_rad: of the lidar. farthest_m:
        beyond it nothing counts as seen.
        """
        distance_m = math.hypot(self._r_ub_m, HALF_STRIDE_S * speed)
        ranges, seen, angle_0, increment, _ = beams
        commit, brake, cost, _ = self.horizon(commit_s)
        return is_clear(
            state,
            reference,
            self.response,
            commit,
            brake,
            cost,
            points,
            ranges,
            seen,
            angle_0 + yaw_rad,
            increment,
            farthest_m,
            distance_m,
            self._radius_m,
            CLEAR_STRIDE,
        )


def cost_horizon_s(parameters: CepaParameters) -> float:
    """Return how far ahead the cost looks: by T after the commit time."""
    return min(parameters.commit_s + parameters.time_horizon, LONGEST_COST_S)


def _steps(seconds: float) -> int:
    return round(seconds / STEP_S)
