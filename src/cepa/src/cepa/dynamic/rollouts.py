"""Rolls commands through the UAV's response, and judges the paths that come out."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.choice import LEAST_COMFORT_M, SCAN_NOISE_M
from cepa.dynamic.constants.free_space import RANGE_MARGIN_M
from cepa.dynamic.constants.response import (
    BRAKE_S,
    CLEAR_STRIDE,
    HOLD_S,
    LONGEST_COMMIT_S,
    LONGEST_COST_S,
    MEETING_S,
    PATH_STEP_S,
)
from cepa.dynamic.cost_to_go.course import Reference
from cepa.dynamic.kernels.admissible import braking
from cepa.dynamic.kernels.clear_path import is_clear
from cepa.dynamic.kernels.rollout import HIT, OUTCOME_COLUMNS, roll_out
from cepa.dynamic.kernels.surroundings import Braking, Cushions, Horizon, Surroundings
from cepa.dynamic.knowledge import Snapshot
from cepa.dynamic.observer import response_of
from cepa.dynamic.threats import as_seen
from cepa.dynamic.ways_out.hard_braking import is_too_late
from cepa.parameters import CepaParameters

HALF_STRIDE_S = 0.5 * CLEAR_STRIDE * PATH_STEP_S


class Assessment(NamedTuple):
    """What flying each of n commands brings."""

    is_admissible: np.ndarray
    """(n,) bool"""
    outcomes: np.ndarray
    """(n, 5): see `roll_out`; zeros where it is not admissible."""
    braking_margin_m: float
    """How much more than it must keep the UAV keeps from everything if it brakes at once."""
    brakes_too_late: bool
    """Whether it then comes too near to what stands, see `is_too_late`."""

    @property
    def passes(self) -> bool:
        """Whether one of the admissible commands meets nothing that moves."""
        return bool((self.outcomes[self.is_admissible, HIT] == 0.0).any())


class Rollouts:
    """Knows the UAV's response and the distances to keep. Vectors are as in kernels/response.py."""

    def __init__(self, parameters: CepaParameters):
        p, model = parameters, parameters.response
        self._r_ub_m, self._radius_m = float(p.r_ub), float(p.body_radius)
        self.response, self._delay_s = response_of(model, PATH_STEP_S), model.delay_s
        steps = _steps(LONGEST_COMMIT_S) + _steps(BRAKE_S)
        tube_m = model.tube_m(PATH_STEP_S, steps)[1:]
        self.hull_m = float(min(p.body_radius + p.margin, p.r_lb))
        least_m = max(self.hull_m, p.r_lb - SCAN_NOISE_M)
        self._usual = Cushions(float(p.r_lb), float(p.r_ub), least_m, self.hull_m, tube_m)
        comfort_m = max(float(p.r_lb), self.hull_m + LEAST_COMFORT_M)
        self._emergency = Cushions(self.hull_m, comfort_m, self.hull_m, self.hull_m, tube_m)
        self._clearance_m, self._beyond_m = np.empty(steps), np.empty(steps)
        self._commit_s = 0.0
        self._horizon = Horizon(0, _steps(BRAKE_S), _steps(cost_horizon_s(p)), _steps(HOLD_S))

    def horizon(self, commit_s: float) -> Horizon:
        """Return how far ahead paths are judged."""
        if commit_s != self._commit_s:
            self._commit_s = commit_s
            self._horizon = self._horizon._replace(commit=math.ceil(commit_s / PATH_STEP_S - 1e-6))
        return self._horizon

    def assess(
        self,
        commands: np.ndarray,
        state: np.ndarray,
        around: Surroundings,
        direction: np.ndarray,
        commit_s: float,
        is_emergency: bool = False,
    ) -> Assessment:
        """Return which commands (n, 3), m/s, are admissible, and what flying them brings.

        is_emergency: only the margin of the hull is kept, and comfort ends at r_LB.
        """
        horizon = self.horizon(commit_s)
        if len(around.movers):
            horizon = horizon._replace(cost=_steps(MEETING_S))
        clearance_m, beyond_m = self._clearance_m, self._beyond_m
        nearest_m, judged, margin_m = braking(
            state, self.response, around, horizon, self._usual, clearance_m, beyond_m
        )
        at_once = Braking(clearance_m, beyond_m, nearest_m, judged)
        cushions = self._emergency if is_emergency else self._usual
        is_admissible = np.empty(len(commands), np.bool_)
        outcomes = np.zeros((len(commands), OUTCOME_COLUMNS))
        world = self.response, around, horizon, cushions, at_once
        roll_out(state, commands, *world, direction, is_admissible, outcomes)
        steps = horizon.commit + horizon.brake
        return Assessment(is_admissible, outcomes, margin_m, is_too_late(clearance_m[:steps], self.hull_m))

    def assess_passing(
        self,
        commands: np.ndarray,
        state: np.ndarray,
        around: Surroundings,
        direction: np.ndarray,
        commit_s: float,
        shown: np.ndarray,
    ) -> Assessment:
        """Return the same; if all commands meet what may move, then as it moves now.

        Where it will be is less sure with time: after 3 s anywhere near a UAV that has a wall behind it. If
        that alone counted, all commands would be as bad, and the UAV would wait at the wall. If all commands
        meet it then, too, only the points (m, 2), m, count that the scan has ``shown`` of it: see `as_seen`.
        """
        assessed = self.assess(commands, state, around, direction, commit_s)
        if not len(around.movers) or assessed.passes:
            return assessed
        as_now = around.movers.copy()
        as_now[:, 5] = 0.0
        assessed = self.assess(commands, state, around._replace(movers=as_now), direction, commit_s)
        if assessed.passes:
            return assessed
        seen = around._replace(movers=as_seen(around.movers, shown, self._delay_s))
        return self.assess(commands, state, seen, direction, commit_s)

    def discomfort_in_emergency(self, around: Surroundings) -> float:
        """Return the discomfort in an emergency of staying where the UAV is, by what moves."""
        x, y, radius_m = around.movers[:, [0, 1, 4]].T
        here_m = float((np.hypot(x, y) - radius_m).min(initial=math.inf))
        inner, outer = self._emergency.inner, self._emergency.outer
        return max(0.0, (outer - here_m) / (outer - inner)) ** 2

    def is_clear(self, reference: Reference, snapshot: Snapshot, commit_s: float) -> bool:
        """Whether the reference may be flown as it is: nothing is within r_UB of its paths, all is seen."""
        observed, horizon = snapshot.observed, self.horizon(commit_s)
        beams = observed.beams
        return is_clear(
            snapshot.state,
            reference.velocity,
            self.response,
            horizon.commit,
            horizon.brake,
            horizon.cost,
            observed.standing,
            beams.ranges,
            beams.seen,
            beams.angle_0 + observed.motion.yaw_rad,
            beams.increment,
            observed.range_max - RANGE_MARGIN_M,
            math.hypot(self._r_ub_m, HALF_STRIDE_S * reference.speed),
            self._radius_m,
            CLEAR_STRIDE,
        )


def cost_horizon_s(parameters: CepaParameters) -> float:
    """Return how far ahead the cost looks: by T after the commit time."""
    return min(parameters.commit_s + parameters.time_horizon, LONGEST_COST_S)


def _steps(seconds: float) -> int:
    return round(seconds / PATH_STEP_S)
