"""The emergency of `Dynamic`: something is too near, and the UAV leaves along admissible paths."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.choice import (
    EMERGENCY_DEPTH_M,
    EMERGENCY_IDLE_SHARE,
)
from cepa.dynamic.kernels.surroundings import Surroundings
from cepa.dynamic.rollouts import cost_horizon_s
from cepa.dynamic.ways_out.straight_ways import WayOut, straight_ways
from cepa.parameters import CepaParameters


class Emergency:
    """Tells when it is an emergency, and in which direction r_LB is regained soonest."""

    def __init__(self, parameters: CepaParameters, hull_m: float):
        """hull_m: of the body with its margin."""
        self._p, self._hull_m = parameters, hull_m
        self.reset()

    def reset(self) -> None:
        """Forget that it is an emergency."""
        self._is_on = False
        self._last = np.zeros(2)

    def is_needed(self, around: Surroundings, progress_m: float, speed: float, end_m: float) -> bool:
        """Whether something is within the hull's margin, or within r_LB while the UAV gains nothing.

        It lasts until r_LB is free. progress_m: of the answer in cost_horizon_s. speed: of the reference.
        end_m: from the UAV; inf: the reference has none.
        """
        p, field = self._p, around.field.distance
        middle = field.shape[1] // 2
        here_m = float(field[len(field) // 2, middle, middle])
        asked_m = min(speed * cost_horizon_s(p), end_m)
        idles = speed < p.reference_speed_min or progress_m < EMERGENCY_IDLE_SHARE * asked_m
        begins = here_m < self._hull_m or (here_m < p.r_lb - EMERGENCY_DEPTH_M and idles)
        self._is_on = here_m < p.r_lb if self._is_on else begins
        if not self._is_on:
            self._last = np.zeros(2)
        return self._is_on

    def climb_m(self, around: Surroundings) -> float:
        """Return how far up (< 0: down) the next height is at which r_LB is kept; inf: there is none.

        On its way it keeps the hull's margin, or what it has where it is.
        """
        distance, _, layer_m, _ = around.field
        layers, side = len(distance) // 2, distance.shape[1] // 2
        upwards, downwards = distance[layers:, side, side], distance[layers::-1, side, side]
        above_m, below_m = (self._steps_to_r_lb(column_m) * layer_m for column_m in (upwards, downwards))
        return above_m if above_m <= below_m else -below_m

    def _steps_to_r_lb(self, column_m: np.ndarray) -> float:
        """Return after how many layers r_LB is kept; inf: it is not before something is too near."""
        keep_m = min(self._hull_m, float(column_m[0]))
        is_regained = (np.minimum.accumulate(column_m) >= keep_m) & (column_m >= self._p.r_lb)
        return float(is_regained.argmax()) if is_regained.any() else math.inf

    def way_out(self, around: Surroundings) -> WayOut | None:
        """Return the straight level flight that regains r_LB soonest; None: there is none.

        On its way it keeps the hull's margin, or what it has where it is. A wider way counts as shorter.
        """
        ways = straight_ways(around.field)
        keep_m = min(self._hull_m, ways.here_m)
        is_regained = (ways.narrowest_m >= keep_m) & (ways.clearance_m >= self._p.r_lb)
        way = ways.soonest(is_regained, self._p.r_lb, self._last)
        if way is not None:
            self._last = way.direction
        return way
