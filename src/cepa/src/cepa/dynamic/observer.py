"""Where the UAV is when a command shows its effect: what odometry does not tell, and does not tell yet."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.linalg import solve_discrete_are

from cepa.dynamic.response import ResponseModel
from cepa.kernels.rollout import fly, observe
from cepa.kernels.surroundings import Response
from cepa.motion import Vector3

VELOCITY_NOISE_M_S = 0.01
ACCELERATION_NOISE_M_S2, INTEGRAL_NOISE_M_S2 = 5.0, 0.5
"""Standard deviations that acceleration and integral gain in a second."""
LONGEST_STEP_S = 1.0
"""After a longer gap nothing is known of acceleration and integral."""
KEPT_COMMANDS = 256
STEP_S = 1e-3
CLIMB_LAG_S = 0.35


def response_of(model: ResponseModel, step_s: float) -> Response:
    """Return the response over a step, for the kernels."""
    limits = model.acceleration_max_m_s2, model.jerk_max_m_s3, 1.0 - math.exp(-step_s / CLIMB_LAG_S)
    return Response(*model.transition(step_s), *limits, step_s)


class Observer:
    """A steady-state Kalman filter of both axes, and the commands that are on their way.

    Its states (3, 4) hold for x and y position, velocity, acceleration and integral, along the odometry's
    axes, and for z position and velocity.
    """

    def __init__(self, model: ResponseModel):
        self._model = model
        self._response = response_of(model, STEP_S)
        self._commands = np.zeros((KEPT_COMMANDS, 5))
        self._state = np.zeros((3, 4))
        self._period_s, self._gains = math.nan, np.zeros(3)
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next velocity is taken as it is, without acceleration."""
        self._stamp_s = -math.inf
        self._first = self._next = 0

    def take_over(self, earlier: Observer) -> None:
        """Take over the state and the commands of one with another model."""
        self._state, self._stamp_s = earlier._state.copy(), earlier._stamp_s
        self._commands, self._first, self._next = earlier._commands.copy(), earlier._first, earlier._next

    def command(self, stamp_s: float, command: np.ndarray, hold_s: float) -> None:
        """Take in a command (3,), m/s, that is given at ``stamp_s``; after ``hold_s`` the UAV brakes."""
        begins_s = stamp_s + self._model.delay_s
        row = self._commands[self._next % KEPT_COMMANDS]
        row[0], row[1], row[2:] = begins_s, begins_s + hold_s, command
        self._next += 1
        self._first = max(self._first, self._next - KEPT_COMMANDS)

    def update(self, stamp_s: float, velocity_m_s: Vector3) -> None:
        """Take in a velocity that was measured at ``stamp_s``."""
        dt_s = stamp_s - self._stamp_s
        if not 0.0 <= dt_s <= LONGEST_STEP_S:
            self._state[:] = 0.0
            self._state[:, 1] = velocity_m_s
        elif dt_s > 0.0:
            period_s = max(round(dt_s, 3), STEP_S)
            if period_s != self._period_s:
                self._period_s, self._gains = period_s, _gains(self._model, period_s)
            times = self._stamp_s, stamp_s
            observe(self._state, velocity_m_s, self._gains, *self._given(), *times, self._response)
        self._stamp_s = stamp_s
        while (
            self._first + 1 < self._next and self._commands[(self._first + 1) % KEPT_COMMANDS, 0] <= stamp_s
        ):
            self._first += 1

    def state_at(self, stamp_s: float) -> np.ndarray:
        """Return the state at a later time; its position is the way since the last measurement."""
        state = self._state.copy()
        fly(state, *self._given(), self._stamp_s, stamp_s, self._response)
        return state

    def _given(self) -> tuple[np.ndarray, int, int]:
        return self._commands, self._first, self._next


@lru_cache(maxsize=256)
def _gains(model: ResponseModel, dt_s: float) -> np.ndarray:
    """Return the gains (3,) of the velocity's innovation on velocity, acceleration and integral."""
    states = 3 if model.i > 0.0 else 2  # without i the integral stays 0
    f = model.transition(dt_s)[0][1 : 1 + states, 1 : 1 + states]
    noises = np.array([1e-3, ACCELERATION_NOISE_M_S2, INTEGRAL_NOISE_M_S2])[:states]
    seen = np.eye(1, states)
    variance = np.array([[VELOCITY_NOISE_M_S**2]])
    covariance = solve_discrete_are(f.T, seen.T, np.diag(noises**2) * dt_s, variance)
    gains = np.zeros(3)
    gains[:states] = (covariance @ seen.T / (seen @ covariance @ seen.T + variance))[:, 0]
    return gains
