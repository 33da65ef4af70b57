"""A pilot who tries to hit something at 2 m/s, and cannot: CEPA is between his hands and the UAV."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from flights.flight.closed_loop import ClosedLoop
from flights.flight.parameters import ClosedLoopParameters
from simulation_tools.simulation import SimulationParameters

WORLDS = Path(__file__).resolve().parents[2] / "worlds"
SPEED_M_S = 2.0
ATTACK_S = 3.5


class Attacker:
    """Flies at full speed in one direction of the world after the other, whatever is there."""

    def __init__(self, directions_rad):
        self.directions_rad = directions_rad
        self.began_s = None

    def __call__(self, t_s, pose):
        self.began_s = t_s if self.began_s is None else self.began_s
        attack = int((t_s - self.began_s) / ATTACK_S) % len(self.directions_rad)
        direction = self.directions_rad[attack] - pose.yaw_rad
        return (SPEED_M_S * math.cos(direction), SPEED_M_S * math.sin(direction), 0.0)


@pytest.mark.flight
@pytest.mark.parametrize(
    ("world", "directions_deg"),
    [
        # straight at one wall, the other, back again, and along the hallway askew
        ("hallway", (90, -90, 45, 180)),
        pytest.param("forest", (0, 30, -80, 200), marks=pytest.mark.long),
    ],
)
def test_a_pilot_who_tries_cannot_hit_anything(world, directions_deg):
    attacker = Attacker(np.radians(directions_deg))
    simulation = SimulationParameters(world=str(WORLDS / f"{world}.world"), seed=1)
    parameters = ClosedLoopParameters(simulation=simulation, goal_xyz_m=None)
    with ClosedLoop(parameters, pilot=attacker) as loop:
        end_s = len(directions_deg) * ATTACK_S

        def tired(loop):
            return attacker.began_s is not None and loop.time_s > attacker.began_s + end_s

        outcome = loop.run(until=tired)
        way_m = np.linalg.norm(np.diff(loop.log.truth.array("x_m", "y_m"), axis=0), axis=1).sum()
    assert not outcome.collision
    assert tired(loop), "the flight ended before the pilot had enough"
    assert way_m > 10.0, "the pilot was not held on the spot, either"
