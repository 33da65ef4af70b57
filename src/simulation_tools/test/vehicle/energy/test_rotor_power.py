"""The rotors' power: the published hover figure, momentum theory in climb, and any number of rotors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.vehicle.energy.rotor_power import RotorPower

IRIS = RotorPower()


def test_an_iris_in_hover_draws_3_12_watts_per_newton_to_the_1_5():
    """1.5 kg: 176 W (Liu, Sengupta and Kurzhanskiy; the reference's figure)."""
    thrust_n = 1.5 * 9.81
    assert IRIS.hover_power_w(thrust_n) == pytest.approx(3.12 * thrust_n**1.5, rel=1e-3)
    assert IRIS.hover_power_w(thrust_n) == pytest.approx(176.0, abs=0.5)


@given(st.integers(1, 8), st.floats(0.1, 60.0))
def test_equal_rotors_draw_what_the_whole_draws(n, thrust_n):
    assert IRIS.power_w(np.full(n, thrust_n / n), 0.0) == pytest.approx(IRIS.hover_power_w(thrust_n))


@given(st.lists(st.floats(0.0, 12.0), min_size=4, max_size=4))
def test_uneven_rotors_draw_more_for_the_same_thrust(thrusts_n):
    """Power grows faster than thrust, so equal shares are the cheapest."""
    power_w = IRIS.power_w(np.array(thrusts_n), 0.0)
    assert power_w >= IRIS.hover_power_w(sum(thrusts_n)) * (1.0 - 1e-9)


def test_a_climb_costs_its_lift_work_and_gives_back_induced_loss():
    """k1 T (V/2 + sqrt(V^2/4 + T/k2^2)) + c2 T^1.5 at 16 N and 2 m/s, worked out by hand."""
    induced = 0.8554 * 16.0 * (1.0 + math.sqrt(1.0 + 16.0 / 0.3051**2))
    assert IRIS.power_w(np.full(4, 4.0), 2.0) == pytest.approx(induced + 0.3177 * 64.0)
    hover, sinking = (IRIS.power_w(np.full(4, 4.0), climb) for climb in (0.0, -1.0))
    assert 0.0 < sinking < hover


def test_standing_rotors_draw_nothing():
    assert IRIS.power_w(np.zeros(4), 3.0) == 0.0
