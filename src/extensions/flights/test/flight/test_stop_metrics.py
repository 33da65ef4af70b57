"""The figures of a stop."""

import math

import numpy as np
import pytest

from flights.flight.judging.stop_metrics import stop_of
from simulation_tools.geometry import quaternion_from_rpy

STEP_S = 0.01
LOST_S = 2.0


def truth(speed_at, turn_rad_s=0.0, heading_rad=0.0):
    """Return rows of a straight flight until 1.5 s after the loss; speed_at: of the time since the loss."""
    rows, x_m = [], 0.0
    for t_s in np.arange(1.0, LOST_S + 1.5, STEP_S):
        yaw_rad = heading_rad + turn_rad_s * (t_s - LOST_S)
        rows.append((t_s, x_m, 1.0, 2.0, *quaternion_from_rpy(0.0, 0.0, yaw_rad)))
        x_m += speed_at(t_s - LOST_S + 0.5 * STEP_S) * STEP_S
    return rows


def test_of_an_even_braking():
    """From 1 m/s at 2 m/s^2, after a reaction time of 0.1 s."""
    stop = stop_of(truth(lambda t_s: min(1.0, max(1.2 - 2.0 * t_s, 0.0))), LOST_S)
    assert stop.speed_m_s == pytest.approx(1.0)
    assert stop.slow_s == pytest.approx(0.55, abs=1.01 * STEP_S)  # (1 - 0.1) / 2 + 0.1
    assert stop.stays_slow_s == pytest.approx(0.55, abs=1.01 * STEP_S)
    assert stop.fastest_after_m_s == pytest.approx(0.2, abs=0.03)
    assert stop.way_m == pytest.approx(0.1 + 0.25, abs=1e-3)
    assert stop.turn_rad_s == 0.0


def test_a_uav_that_swings_back_is_slow_but_does_not_stay_so():
    stop = stop_of(truth(lambda t_s: 1.0 - 2.0 * t_s if t_s < 0.6 else -0.2 * (t_s < 0.8)), LOST_S)
    assert stop.slow_s == pytest.approx(0.45, abs=1.01 * STEP_S)
    assert stop.stays_slow_s == pytest.approx(0.8, abs=1.01 * STEP_S)
    assert stop.fastest_after_m_s == pytest.approx(0.2, abs=0.01)


def test_a_uav_that_flies_on_is_never_slow():
    stop = stop_of(truth(lambda t_s: 1.0), LOST_S)
    assert stop.slow_s is None
    assert stop.stays_slow_s == pytest.approx(1.5, abs=1.01 * STEP_S)


@pytest.mark.table("heading_rad", [0.0, math.pi])
def test_the_turn_counts_across_the_change_of_sign(heading_rad):
    stop = stop_of(truth(lambda t_s: 1.0, -0.7, heading_rad), LOST_S)
    assert stop.turn_rad_s == pytest.approx(-0.7)
