"""The figures of climbs beside other libraries, and the places that are flown to in the tank."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

from benchmarks.gnss_rows.beside import aligned_m
from benchmarks.gnss_rows.climb_places import CLIMBS, is_open
from benchmarks.gnss_rows.climbs import silent_m
from flights.worlds.ballast_tank import BallastTankParameters
from simulation_tools.simulation import Simulation, SimulationParameters


def test_an_error_counts_as_silent_a_second_after_the_last_remark():
    times_s = np.arange(6.0)
    off_m = np.array([0.1, 0.2, 5.0, 4.0, 3.0, 0.3])
    told = np.array([False, True, True, False, False, False])
    assert silent_m(times_s, off_m, told) == pytest.approx(3.0)
    assert silent_m(times_s, off_m, np.ones(6, bool)) == 0.0


def test_a_path_that_is_only_turned_and_moved_has_no_error():
    path = np.random.default_rng(1).normal(size=(50, 3))
    turn = np.array(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert aligned_m(path @ turn.T + (3.0, 2.0, 1.0), path) == pytest.approx(0.0, abs=1e-9)
    assert aligned_m(path * 1.1, path) > 0.05


def test_ways_through_the_tank_lead_through_its_manholes_and_touch_nothing():
    climb, tank = CLIMBS["ballast_tank"], BallastTankParameters()
    parameters = SimulationParameters(str(climb.world), lidar="near_puck", model=climb.model)
    with contextlib.closing(Simulation(parameters)) as simulation:
        rays = simulation.world.rays
        places = [waypoint.position_m for waypoint in climb.mission(rays, np.random.default_rng(3), 300.0)]
        ways = list(zip(places, places[1:]))
        assert len({int(np.floor((x + tank.length_m / 2) / tank.compartment_m)) for x, _, _ in places}) > 2
        assert max(z for *_, z in places) - min(z for *_, z in places) > 2.5
        assert all(is_open(rays, np.array(one), np.array(other), 0.22) for one, other in ways)
