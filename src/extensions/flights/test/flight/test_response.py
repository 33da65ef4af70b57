"""CEPA's model of the vehicle's response against the flight controller in the loop."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cepa import Decision, Improved, Reason
from cepa.identification.identify import identify
from cepa.identification.recording import Recording
from cepa.identification.response import ResponseModel
from flights.flight.closed_loop import ClosedLoop
from flights.flight.parameters import ClosedLoopParameters
from simulation_tools.geometry import rotate
from simulation_tools.simulation import SimulationParameters

WORLD = Path(__file__).resolve().parents[2] / "worlds" / "empty.world"
FLIGHT_S, SPEED_M_S, HEIGHT_M = 30.0, 4.0, 3.0


class Unfiltered(Improved):
    """Flies the reference as it is."""

    def steer(self, scan, v_ref_xy, *_):
        return Decision((v_ref_xy[0], v_ref_xy[1]), False, 0.0, 1, Reason.CUSHION_CLEAR)


class RandomPilot:
    """Jumps of up to 60 degrees and of the speed, and brakings, every 0.3 to 2 s; all are kept."""

    def __init__(self, seed):
        self._rng, self._until_s = np.random.default_rng(seed), 0.0
        self._angle, self._command = 0.0, np.zeros(2)
        self.began_s, self.commands = None, []

    def __call__(self, t_s, pose):
        self.began_s = t_s if self.began_s is None else self.began_s
        if t_s >= self._until_s:
            self._until_s = t_s + self._rng.uniform(0.3, 2.0)
            self._angle += self._rng.uniform(-1.0, 1.0) * math.pi / 3.0
            speed = SPEED_M_S * self._rng.choice([0.0, 0.25, 0.5, 1.0, 1.0])
            self._command = speed * np.array([math.cos(self._angle), math.sin(self._angle)])
        climb = min(max(HEIGHT_M - pose.position_m[2], -1.0), 1.0)
        self.commands.append((t_s, *self._command, climb))
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        x, y = self._command
        return c * x + s * y, c * y - s * x, climb


@pytest.mark.flight
def test_the_identified_response_is_shipped_and_predicts_within_its_error():
    pilot, velocities = RandomPilot(1), []
    simulation = SimulationParameters(world=str(WORLD), seed=1)
    parameters = ClosedLoopParameters(simulation=simulation, goal_xyz_m=None)
    with ClosedLoop(parameters, steering=Unfiltered(), pilot=pilot) as loop:
        while pilot.began_s is None or loop.time_s < pilot.began_s + FLIGHT_S:
            truth = loop.step().ground_truth
            if truth is not None:
                velocity = rotate(truth.pose.orientation_xyzw, truth.linear_velocity_m_s)
                velocities.append((loop.time_s, *velocity))
    found = identify(Recording(np.array(pilot.commands), np.array(velocities)))
    shipped = ResponseModel()
    assert found.model.p == pytest.approx(shipped.p, rel=0.15)
    assert found.model.i < 0.05
    # A limited jerk shows as a longer lag and delay, and a longer lag as a longer delay
    assert found.model.lag_s + found.model.delay_s == pytest.approx(0.1, abs=0.04)
    assert found.model.error_m_s2 < 0.6
    assert found.deviation_rms_m[5] < 0.1  # after 1 s; PX4's own gains as a model miss by 0.34 m
