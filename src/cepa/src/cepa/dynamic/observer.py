"""The UAV's state when a command shows its effect, by odometry's velocity and the commands on their way."""

from __future__ import annotations

import math
from functools import lru_cache
from struct import Struct
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.constants.response import (
    ACCELERATION_NOISE_M_S2,
    CLIMB_LAG_S,
    INTEGRAL_NOISE_M_S2,
    KEPT_COMMANDS,
    LONGEST_OBSERVER_GAP_S,
    OBSERVER_STEP_S,
    VELOCITY_NOISE_M_S,
)
from cepa.dynamic.kernels.response import observe
from cepa.identification.response import ResponseModel
from cepa.motion import Vector3

ROW, ROW_BYTES = Struct("5d"), 40
"""Of a command: when it begins and is braked, s, and its velocity, m/s."""


def response_of(model: ResponseModel, step_s: float) -> np.ndarray:
    """Return the response over a step (20,), for the kernels: x(t + step) = F x + G u.

    Rows of F, without its first column, and of G: for position, velocity, acceleration and integral. Then the
    greatest acceleration, m/s2, and its greatest change in a step. Then the share of its error that the
    vertical velocity loses in a step, and the step, s.
    """
    f, g = model.transition(step_s)
    limits = model.acceleration_max_m_s2, model.jerk_max_m_s3 * step_s
    climb_share = 1.0 - math.exp(-step_s / CLIMB_LAG_S)
    return np.array([*np.column_stack((f[:, 1:], g)).flat, *limits, climb_share, step_s])


class Estimate(NamedTuple):
    """Where the UAV is, and how it moves."""

    state: np.ndarray
    """(3, 4): see `Observer`."""
    way_m: np.ndarray
    """(3,) m: from where the velocity was measured to where the scan was taken."""


class Observer:
    """A steady-state Kalman filter of both axes, and the commands that are on their way.

    Its states (3, 4) hold for x and y position, velocity, acceleration and integral, along the odometry's
    axes, and for z position and velocity.
    """

    def __init__(self, model: ResponseModel):
        self._model = model
        self._response = response_of(model, OBSERVER_STEP_S)
        self._commands = np.zeros((KEPT_COMMANDS, 5))
        self._rows = self._commands.data
        self._state = np.zeros((3, 4))
        self._gains: dict[int, np.ndarray] = {}
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next velocity is taken as it is, without acceleration."""
        self._stamp_s = -math.inf
        self._first = self._next = 0

    def take_over(self, earlier: Observer) -> None:
        """Take over the state and the commands of one with another model."""
        self._state, self._stamp_s = earlier._state.copy(), earlier._stamp_s
        self._commands[:], self._first, self._next = earlier._commands, earlier._first, earlier._next

    def command(self, stamp_s: float, command: Sequence[float], hold_s: float) -> None:
        """Take in a command (x, y, z), m/s, that is given at ``stamp_s``; after ``hold_s`` the UAV brakes."""
        begins_s = stamp_s + self._model.delay_s
        x, y, z = command
        place = self._next % KEPT_COMMANDS * ROW_BYTES
        ROW.pack_into(self._rows, place, begins_s, begins_s + hold_s, x, y, z)  # thrice as fast as numpy
        self._next += 1
        if self._next - self._first > KEPT_COMMANDS:
            self._first += 1

    def update(self, told_s: float, velocity_m_s: Vector3, scan_s: float, later_s: float) -> Estimate:
        """Take in a velocity that was measured at ``told_s``; return the state at ``later_s``.

        Its position counts from where the UAV is at ``scan_s``.
        """
        from_s, self._stamp_s = self._stamp_s, told_s
        if not 0.0 <= told_s - from_s <= LONGEST_OBSERVER_GAP_S:
            from_s = told_s
            self._state[:] = 0.0
            self._state[:, 1] = velocity_m_s
        vx, vy, vz = map(float, velocity_m_s)  # the kernel takes no whole numbers among floats
        later, way_m = np.empty((3, 4)), np.empty(3)
        self._first = observe(
            self._state,
            vx,
            vy,
            vz,
            self._gains_over(told_s - from_s),
            self._commands,
            self._first,
            self._next,
            from_s,
            told_s,
            scan_s,
            later_s,
            self._response,
            way_m,
            later,
        )
        return Estimate(later, way_m)

    def _gains_over(self, time_s: float) -> np.ndarray:
        """Return the gains (3,) over a time, to the millisecond; whole numbers are looked up fast."""
        time_ms = round(1e3 * time_s) or 1
        gains = self._gains.get(time_ms)
        if gains is None:
            gains = self._gains[time_ms] = _gains(self._model, time_ms / 1e3)
        return gains


@lru_cache(maxsize=256)
def _gains(model: ResponseModel, dt_s: float) -> np.ndarray:
    """Return the gains (3,) of the velocity's innovation on velocity, acceleration and integral."""
    from scipy.linalg import solve_discrete_are  # slow to import, and only the algorithm `dynamic` needs it

    states = 3 if model.i > 0.0 else 2  # without i the integral stays 0
    f = model.transition(dt_s)[0][1 : 1 + states, 1 : 1 + states]
    noises = np.array([1e-3, ACCELERATION_NOISE_M_S2, INTEGRAL_NOISE_M_S2])[:states]
    seen = np.eye(1, states)
    variance = np.array([[VELOCITY_NOISE_M_S**2]])
    covariance = solve_discrete_are(f.T, seen.T, np.diag(noises**2) * dt_s, variance)
    gains = np.zeros(3)
    gains[:states] = (covariance @ seen.T / (seen @ covariance @ seen.T + variance))[:, 0]
    return gains
