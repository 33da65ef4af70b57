"""Velocity steps in four directions, for identifying how a UAV responds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa.decision import Vector2
from cepa.errors import ParameterError
from flight_basics.checks import check_limits, limited

QUARTERS = (0.0, math.pi, 0.5 * math.pi, -0.5 * math.pi)
SHARES = (0.5, 1.0, 1.0)
"""Of the speed, one round of directions each."""
DECELERATION_M_S2 = 1.5
"""Least deceleration that is counted on to stay within the box."""
LATENCY_S = 0.5


@dataclass(frozen=True)
class StepParameters:
    """What is flown. Raises ParameterError for a value that is not above 0."""

    speed_m_s: float = limited(2.0, above=0.0)
    """Of the greatest step."""
    step_s: float = limited(2.0, above=0.0)
    """Duration of a step; it ends sooner at the edge of the box."""
    pause_s: float = limited(1.5, above=0.0)
    """Standstill after a step."""
    box_m: float = limited(15.0, above=0.0)
    """Edge of the square around the start that is not left."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "The steps' {}")


class StepFlight:
    """Tells the velocity to fly at each instant; all vectors along the odometry's axes."""

    def __init__(self, start_xy: Vector2, heading_rad: float, parameters: StepParameters | None = None):
        self._p = parameters or StepParameters()
        self._start = np.array(start_xy, float)
        self._steps = [
            share * self._p.speed_m_s * np.array([math.cos(heading_rad + turn), math.sin(heading_rad + turn)])
            for share in SHARES
            for turn in QUARTERS
        ]
        self._until_s: float | None = None
        self._flying = False

    def velocity(self, t_s: float, position_xy: Vector2) -> np.ndarray | None:
        """Return the velocity (2,) m/s to command at time ``t_s`` and a position; None when all is flown."""
        if self._until_s is None or t_s >= self._until_s:
            if not (self._steps or self._flying):
                return None
            self._flying = not self._flying
            self._until_s = t_s + (self._p.step_s if self._flying else self._p.pause_s)
            if self._flying:
                self._step = self._steps.pop(0)
        if self._flying and self._would_leave(np.array(position_xy)):
            self._flying, self._until_s = False, t_s + self._p.pause_s
        return self._step if self._flying else np.zeros(2)

    def _would_leave(self, position_xy: np.ndarray) -> bool:
        speed = float(np.hypot(*self._step))
        ahead = (LATENCY_S + speed / (2.0 * DECELERATION_M_S2)) * self._step
        return bool(np.abs(position_xy + ahead - self._start).max() > 0.5 * self._p.box_m)
