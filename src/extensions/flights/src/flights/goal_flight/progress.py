"""Notices a flight that comes no nearer to its goal."""

from __future__ import annotations

import math
from typing import Sequence

PATIENCE_S = 15.0
LEAST_M = 0.5
UNPLANNED = "CEPA sees only what is near: fly_to_goal.launch planner:=true looks for a door farther aside."
PLANNED = "path_planner leads it around what is in the way, and says so if it finds no way."


class ProgressWatch:
    """Follows the distance to a goal.

    It reports when the distance has not shrunk by `LEAST_M` for `PATIENCE_S`.
    """

    def __init__(self, goal_xyz_m: Sequence[float], is_planned: bool = False) -> None:
        """goal_xyz_m: in the frame of the positions. is_planned: path_planner leads the UAV."""
        self._goal_xyz_m = tuple(goal_xyz_m)
        self._advice = PLANNED if is_planned else UNPLANNED
        self._nearest_m = math.inf
        self._nearest_s = -math.inf
        self._told_s = -math.inf

    def update(self, t_s: float, position_xyz_m: Sequence[float]) -> tuple[float, str | None]:
        """Take a position. Return its distance from the goal, m, and a sentence if progress has stopped."""
        distance_m = math.dist(position_xyz_m, self._goal_xyz_m)
        if distance_m <= self._nearest_m - LEAST_M:
            self._nearest_m, self._nearest_s = distance_m, t_s
        if t_s - max(self._nearest_s, self._told_s) < PATIENCE_S:
            return distance_m, None
        self._told_s = t_s
        return distance_m, (
            f"The UAV is {distance_m:.1f} m from the goal, and has come no nearer for "
            f"{t_s - self._nearest_s:.0f} s. {self._advice}"
        )
