"""Tells when a UAV that is asked to fly gets nowhere, or comes back again and again."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.choice import HELD_M, HELD_OWED_M, HELD_PAUSE_S, HELD_S
from cepa.dynamic.constants.cost_to_go import RETURNS_S, RETURNS_TOLD

ANOTHER_WAY = (
    "Lead it another way: set waypoints, or let path_planner lead it on a map (fly_to_goal: planner:=true)."
)
ANOTHER_PLAN = "CEPA looks for no way itself (window_m is 0): whoever plans must lead it another way."


class HoldUp:
    """Watches how long the UAV has stayed at a place although the reference leads on.

    It leads on if the UAV has not flown what it was asked to. A UAV that works within a small space, such as
    one that takes photographs, flies all of it. It is not held up, however long that takes.
    """

    def __init__(self) -> None:
        self.is_ready = True
        """Whether the UAV flies what it is asked. One that is landed, or takes off, is not held up."""
        self.is_planned = False
        """Whether the way is another node's alone (`window_m` 0)."""
        self.reset()

    def reset(self) -> None:
        """Forget where the UAV was."""
        self._place_m, self._since_s, self._asked_s = (math.inf, math.inf, math.inf), 0.0, -math.inf
        self._last_m = self._place_m
        self._owed_m = np.zeros(3)  # what it was asked to fly since then, without what it has flown
        self._is_told, self._returns_told = False, 0
        self.held_s = 0.0
        """How long it has stayed within HELD_M, s."""

    @property
    def is_held(self) -> bool:
        """Whether it has stayed for so long that somebody should know."""
        return self.held_s >= HELD_S and float(np.linalg.norm(self._owed_m)) >= HELD_OWED_M

    def take_in(
        self,
        stamp_s: float,
        position_m: tuple[float, float, float],
        reference_m_s: np.ndarray,
        is_asked: bool,
        returns: int,
    ) -> tuple[str, ...]:
        """Take in where the UAV is; return what the user should read.

        reference_m_s (3,): what it is asked to fly, along the odometry's axes. is_asked: whether that is
        enough to fly. returns: see `CostToGoSearch.returns`.
        """
        if not self.is_ready:
            self.held_s, self._asked_s = 0.0, -math.inf
            return ()
        if is_asked:
            went_on = math.dist(position_m, self._place_m) > HELD_M
            if went_on or not 0.0 <= stamp_s - self._asked_s <= HELD_PAUSE_S:
                self._place_m, self._since_s, self._is_told = position_m, stamp_s, False
                self._owed_m = np.zeros(3)
            else:
                self._owed_m += (stamp_s - self._asked_s) * reference_m_s
                self._owed_m -= np.subtract(position_m, self._last_m)
            self._asked_s, self._last_m = stamp_s, position_m
            self.held_s = stamp_s - self._since_s
        else:
            self.held_s = 0.0
        return (*self._about_holding(), *self._about_returns(returns))

    def _about_holding(self) -> tuple[str, ...]:
        if not self.is_held or self._is_told:
            return ()
        self._is_told = True
        return (
            f"The UAV is asked to fly, but has stayed within {HELD_M:g} m for {self.held_s:.0f} s: nothing "
            f"that it fits through is open. {ANOTHER_PLAN if self.is_planned else ANOTHER_WAY}",
        )

    def _about_returns(self, returns: int) -> tuple[str, ...]:
        is_new, self._returns_told = returns > self._returns_told, returns
        if not is_new or returns < RETURNS_TOLD:
            return ()
        return (
            f"The UAV has come back to where it was {returns} times in {RETURNS_S:g} s: no way that it tried "
            f"led on. {ANOTHER_WAY}",
        )
