"""How it flies: hover accuracy with every lidar's weight, setpoints in every form, parameters at work."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bodies import GRAVITY
from flight import NO_NOISE, Flight

from simulation_tools.px4.setpoint import Setpoint

LIDAR_WEIGHTS_KG = {"urg": 0.16, "ust": 0.13, "utm": 0.21, "puck": 0.59, "tim": 0.25, "m8": 0.80}
NORTH = math.pi / 2  # heading in ENU

pytestmark = pytest.mark.flight


@pytest.mark.parametrize("lidar", LIDAR_WEIGHTS_KG)
def test_it_hovers_within_five_centimetres_with_every_lidar(lidar):
    flight = Flight.of_iris(LIDAR_WEIGHTS_KG[lidar], seed=3, yaw=0.7)
    flight.take_off(2.0, yaw=0.7, seconds=20.0)
    rows = flight.record(10.0)
    error = np.linalg.norm(rows[:, 1:4] - [0.0, 0.0, 2.0], axis=1)
    assert error.max() < 0.05
    yaw = np.array([2.0 * math.atan2(z, w) for z, w in rows[:, 9:11]])
    assert np.abs(yaw - 0.7).max() < math.radians(1.0)


@pytest.mark.parametrize("extra_kg", [0.13, 0.80])
def test_hover_thrust_is_that_of_the_closed_form(extra_kg):
    flight = Flight.of_iris(extra_kg, noise=NO_NOISE)
    flight.take_off(2.0, seconds=25.0)
    expected = flight.airframe.hover_command(1.5 + extra_kg, GRAVITY)
    assert flight.px4.commands == pytest.approx(np.full(4, expected), abs=0.003)
    speeds = flight.airframe.rotor_states
    assert np.sum(5.84e-6 * speeds**2) == pytest.approx((1.5 + extra_kg) * GRAVITY, rel=0.005)


def test_hover_wanders_no_more_than_px4s():
    flight = Flight.of_reference_quad(seed=4)
    flight.take_off(3.0, yaw=NORTH, seconds=30.0)
    x, y, z = flight.record(30.0)[:, 1:4].T
    assert max(x.std(), y.std()) < 0.014
    assert z.std() < 0.003
    assert min(x.std(), y.std(), z.std()) > 0.0002  # the estimate does wander


def test_unarmed_it_stands_still():
    flight = Flight.of_iris()
    flight.run(2.0)
    assert flight.body.position == (0.0, 0.0, 0.0)
    assert not flight.airframe.rotor_states.any()


def test_body_velocities_follow_the_heading_at_receipt():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.take_off(2.0, yaw=2.0, seconds=14.0)
    flight.stream = Setpoint.fly((1.0, 0.5, 0.0), 0.0)
    flight.run(8.0)
    c, s = math.cos(2.0), math.sin(2.0)
    expected = (c * 1.0 - s * 0.5, s * 1.0 + c * 0.5)
    assert flight.body.velocity[:2] == pytest.approx(expected, abs=0.08)


def test_yaw_rate_setpoints_turn_counter_clockwise_for_positive_flu():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.take_off(2.0, yaw=0.0, seconds=14.0)
    flight.stream = Setpoint.fly((0.0, 0.0, 0.0), 0.5)
    flight.run(3.0)
    assert flight.body.rates[2] == pytest.approx(0.5, abs=0.05)


def test_parameters_take_effect_in_flight():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.take_off(2.0, seconds=14.0)
    flight.px4.parameters.set("MPC_XY_VEL_MAX", 1.0)
    flight.stream = Setpoint.hold((30.0, 0.0, 2.0))
    rows = flight.record(10.0)
    assert rows[:, 4].max() == pytest.approx(1.0, abs=0.1)


def test_the_same_seed_flies_the_same_flight_bit_for_bit():
    flights = [Flight.of_iris(seed=5) for _ in range(2)]
    for flight in flights:
        flight.take_off(2.0, seconds=6.0)
    assert flights[0].body.position == flights[1].body.position
    other = Flight.of_iris(seed=6)
    other.take_off(2.0, seconds=6.0)
    assert other.body.position != flights[0].body.position
