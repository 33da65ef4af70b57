"""Flies a Px4 on a RigidBody: the closed loop of these tests."""

from __future__ import annotations

import copy
from functools import cache

import numpy as np
from bodies import DT_S, RigidBody, iris, reference_quad

from simulation_tools.px4.estimation.steady_estimator import EstimatorNoise
from simulation_tools.px4.modes import LandedState, Mode, Result
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import Setpoint


class Flight:
    """Airframe, body and flight controller in a loop; `stream` is the setpoint sent at 50 Hz, or None."""

    def __init__(self, airframe, body, noise=None, seed=0, parameters=None, origin=None):
        self.airframe = airframe
        self.body = body
        self._origin = body.position  # of the local frame
        self.px4 = Px4(airframe, parameters, np.random.default_rng(seed), noise, origin)
        self.texts = []
        self.px4.on_statustext = self._hear
        self.stream = None
        self.stream_period_us = 20_000
        self._sent_us = -(10**9)
        self.log = []

    @classmethod
    def of_reference_quad(cls, noise=None, seed=0, **where):
        return cls(reference_quad(), RigidBody.reference_quad(**where), noise, seed)

    @classmethod
    def of_iris(cls, extra_kg=0.13, noise=None, seed=0, parameters=None, origin=None, **where):
        return cls(iris(), RigidBody.iris(extra_kg, **where), noise, seed, parameters, origin)

    @property
    def time_s(self):
        return 1e-6 * self.body.time_us

    def _hear(self, severity, text):
        self.texts.append(text)

    def step(self):
        if self.stream is not None and self.body.time_us - self._sent_us >= self.stream_period_us:
            self._sent_us = self.body.time_us
            self.px4.offer_setpoint(self.stream)
        commands = self.px4.step(self.body.state)
        self.body.step(*self.airframe.step(commands, self.body.velocity_body, DT_S))

    def run(self, seconds, until=lambda: False):
        """Fly for a time, or until something is true; returns whether it became true."""
        for _ in range(round(seconds / DT_S)):
            self.step()
            if until():
                return True
        return False

    def record(self, seconds, until=lambda: False):
        """Fly and return rows (t, position ENU, velocity ENU, attitude x y z w), t from now."""
        start, rows = self.body.time_us, []
        for _ in range(round(seconds / DT_S)):
            self.step()
            body = self.body
            rows.append((1e-6 * (body.time_us - start), *body.position, *body.velocity, *body.attitude))
            if until():
                break
        return np.array(rows)

    def take_off(self, height=2.0, yaw=np.nan, seconds=12.0):
        """Arm in OFFBOARD at the place where it stands and rise."""
        x, y, z = np.subtract(self.body.position, self._origin)
        self.stream = Setpoint.hold((x, y, z + height), yaw)
        self.run(1.0)
        assert self.px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
        assert self.px4.request_arm() is Result.ACCEPTED
        self.run(seconds)


NO_NOISE = EstimatorNoise.none()


def hovering(height=2.0, seconds=10.0, make=Flight.of_iris):
    """Return a flight without noise that is up in OFFBOARD, what has been said forgotten."""
    flight = copy.deepcopy(_taken_off(height, seconds, make))
    flight.texts.clear()
    return flight


@cache
def _taken_off(height, seconds, make):
    flight = make(noise=NO_NOISE)
    flight.take_off(height, seconds=seconds)
    assert flight.px4.status.landed_state is LandedState.IN_AIR
    return flight
