"""How it flies: hover accuracy, and setpoints in every form."""

from __future__ import annotations

import math

import pytest
from flight import NO_NOISE, Flight

from simulation_tools.px4.setpoint import Setpoint

NORTH = math.pi / 2  # heading in ENU

pytestmark = pytest.mark.flight


def test_hover_wanders_as_px4s_does():
    """PX4: standard deviations of 1.4 cm in x and y, 0.3 cm in z."""
    flight = Flight.of_reference_quad(seed=4)
    flight.take_off(3.0, yaw=NORTH, seconds=25.0)
    spread_cm = 100.0 * flight.record(300.0)[:, 1:4].std(axis=0)
    # Over five minutes they spread by 6 % from seed to seed, over 30 s by 20 %.
    assert spread_cm == pytest.approx([1.4, 1.4, 0.3], rel=0.1)


def test_the_local_frame_begins_where_the_vehicle_stands():
    """Real PX4 on the ground: local position 0.00, whatever the body's height over it and its place."""
    flight = Flight.of_iris(noise=NO_NOISE, position=(30.0, -20.0, 0.0))
    world = flight.px4.origin
    flight.run(2.0)
    assert flight.px4.estimate["position"][0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert flight.px4.home == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    local = flight.px4.origin
    assert world.to_local(local.latitude_deg, local.longitude_deg) == pytest.approx((-20.0, 30.0), abs=1e-4)
    flight.take_off(2.0, seconds=14.0)
    assert flight.px4.estimate["position"][0] == pytest.approx([0.0, 0.0, -2.0], abs=0.06)
    assert flight.body.position == pytest.approx((30.0, -20.0, 2.0), abs=0.06)


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


@pytest.mark.table(("change_rad_s", "least_m", "most_m"), [(3.2, 1.0, 2.5), (0.3, -0.1, 0.1)])
def test_a_heavy_uav_sinks_while_its_yaw_rate_jumps_to_and_fro(change_rad_s, least_m, most_m):
    """PX4's mixer lowers the thrust to turn. With Puck and camera an Iris has none to spare."""
    flight = Flight.of_iris(extra_kg=0.77, noise=NO_NOISE)
    flight.take_off(8.0, seconds=20.0)
    height_m, rate_rad_s = flight.body.position[2], 0.0
    for turn in range(60):  # 20 setpoints a second; the sense changes with every other one
        wanted = 1.6 if turn // 2 % 2 else -1.6
        rate_rad_s += min(max(wanted - rate_rad_s, -change_rad_s), change_rad_s)
        flight.stream = Setpoint.fly((0.0, 0.0, 0.0), rate_rad_s)
        flight.run(0.05)
    assert least_m <= height_m - flight.body.position[2] <= most_m


def test_yaw_rate_setpoints_turn_counter_clockwise_for_positive_flu():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.take_off(2.0, yaw=0.0, seconds=14.0)
    flight.stream = Setpoint.fly((0.0, 0.0, 0.0), 0.5)
    flight.run(3.0)
    assert flight.body.rates[2] == pytest.approx(0.5, abs=0.05)
