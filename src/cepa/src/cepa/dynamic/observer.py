"""Estimates what odometry does not tell of the UAV's state: acceleration and integral."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import solve_discrete_are

from cepa.dynamic.response import ResponseModel

VELOCITY_NOISE_M_S = 0.05
ACCELERATION_NOISE_M_S2 = 0.5
"""Standard deviation that the acceleration gains in a second, and the integral in ten."""
LONGEST_STEP_S = 0.5


class Observer:
    """A steady-state Kalman filter of both axes; position is not estimated and stays 0."""

    def __init__(self, model: ResponseModel):
        self._model = model
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next velocity is taken as it is, without acceleration."""
        self._state: np.ndarray | None = None

    def update(self, dt_s: float, command_xy: np.ndarray, velocity_xy: np.ndarray) -> np.ndarray:
        """Return the state (2, 4: position 0, velocity, acceleration, integral) that fits the velocity best.

        dt_s: since the last update, during which ``command_xy`` was flown; m/s in the odometry's axes.
        """
        if self._state is None or not 0.0 < dt_s <= LONGEST_STEP_S:
            self._state = np.zeros((2, 4))
            self._state[:, 1] = velocity_xy
            return self._state
        f, g = self._model.transition(round(dt_s, 3) or 1e-3)
        state = self._state @ f.T + np.outer(command_xy, g)
        state[:, 1:] += np.outer(velocity_xy - state[:, 1], _gains(self._model, round(dt_s, 3) or 1e-3))
        state[:, 0] = 0.0
        self._state = state
        return state


@lru_cache(maxsize=64)
def _gains(model: ResponseModel, dt_s: float) -> np.ndarray:
    f = model.transition(dt_s)[0][1:, 1:]
    noise = np.diag([1e-6, ACCELERATION_NOISE_M_S2**2, (0.1 * ACCELERATION_NOISE_M_S2) ** 2]) * dt_s
    seen = np.array([[1.0, 0.0, 0.0]])
    variance = np.array([[VELOCITY_NOISE_M_S**2]])
    covariance = solve_discrete_are(f.T, seen.T, noise, variance)
    return (covariance @ seen.T / (seen @ covariance @ seen.T + variance))[:, 0]
