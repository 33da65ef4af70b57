"""Hover thrust and the take-off ramp."""

from __future__ import annotations

import math

import pytest

from simulation_tools.px4.control.hover_thrust import HoverThrustEstimator
from simulation_tools.px4.control.takeoff import Takeoff, TakeoffState
from simulation_tools.px4.parameters import Px4Parameters

DT = 0.008


def test_hover_thrust_is_found_and_only_then_valid():
    hover = HoverThrustEstimator(Px4Parameters())
    truth = 0.62
    for step in range(1500):
        thrust = truth + 0.02 * math.sin(0.05 * step)
        hover.update(9.80665 * (thrust / truth - 1.0), thrust, DT)
        if step * DT < 1.9:
            assert not hover.valid
    assert hover.valid
    assert hover.hover_thrust == pytest.approx(truth, abs=0.005)


def test_hover_thrust_shrugs_off_an_outlier():
    hover = HoverThrustEstimator(Px4Parameters())
    for _ in range(500):
        hover.update(0.0, 0.5, DT)
    hover.update(500.0, 0.5, DT)
    assert hover.hover_thrust == pytest.approx(0.5, abs=1e-3)


def test_take_off_spools_up_for_a_second_and_ramps_for_three():
    takeoff = Takeoff(Px4Parameters())
    start = -9.80665 / 4.0
    seen = {}
    limits = []
    for step in range(round(5.0 / DT)):
        takeoff.update(True, step * DT < 2.0, True, False, DT)
        seen.setdefault(takeoff.state, step * DT)
        limits.append(takeoff.speed_limit(3.0, DT))
    assert seen[TakeoffState.RAMPUP] == pytest.approx(1.0, abs=2 * DT)
    assert seen[TakeoffState.FLIGHT] == pytest.approx(4.0, abs=3 * DT)
    assert limits[0] == pytest.approx(start)
    halfway = round(2.5 / DT)
    assert limits[halfway] == pytest.approx(start + 0.5 * (3.0 - start), abs=0.03)
    assert limits[-1] == 3.0
    takeoff.update(False, True, True, False, DT)
    assert takeoff.state is TakeoffState.DISARMED
