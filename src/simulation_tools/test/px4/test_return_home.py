"""AUTO.RTL as measured on PX4 SITL: how high it climbs near home and far from it, and where it stays."""

from __future__ import annotations

import copy
import math
from functools import cache

import numpy as np
import pytest
from flight import NO_NOISE, Flight, hovering

from simulation_tools.px4.modes import LandedState, Mode, Result
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.return_home import return_z
from simulation_tools.px4.setpoint import Setpoint

YAW_RAD = 0.4  # heading of home, from east


@cache
def taken_off(height_m):
    flight = Flight.of_reference_quad(noise=NO_NOISE, yaw=YAW_RAD)
    flight.take_off(height_m, yaw=YAW_RAD, seconds=6.0 + 1.5 * height_m)
    return flight


def returning_from(distance_m, height_m, **parameters):
    """Return (highest, flight) of a return from there to its end. The local frame is 488 m over the sea."""
    flight = copy.deepcopy(taken_off(height_m))
    for name, value in parameters.items():
        flight.px4.parameters.set(name, value)
    if distance_m:
        flight.stream = Setpoint.hold((distance_m, 0.0, height_m), YAW_RAD)
        flight.run(8.0 + 0.3 * distance_m)
    flight.stream = None
    flight.texts.clear()
    assert flight.px4.request_mode(Mode.AUTO_RTL) is Result.ACCEPTED
    rows = flight.record(80.0, until=lambda: not flight.px4.status.armed)
    assert not flight.px4.status.armed
    assert math.hypot(*flight.body.position[:2]) < 0.3
    return rows[:, 3].max(), flight


def test_on_the_ground_it_stays_there_and_disarms():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(1.0)
    flight.px4.request_arm()
    flight.run(1.0)
    flight.texts.clear()
    assert flight.px4.request_mode(Mode.AUTO_RTL) is Result.ACCEPTED
    assert flight.run(12.0, until=lambda: not flight.px4.status.armed)
    assert flight.time_s == pytest.approx(1.0 + 10.0, abs=0.05)
    assert flight.body.position == (0.0, 0.0, 0.0)
    assert flight.texts == [
        "RTL HOME activated",
        "RTL: landing at home position.",
        "Disarmed by auto preflight disarming",
    ]


@pytest.mark.flight
@pytest.mark.table(
    ("distance_m", "height_m", "highest_m"),
    [
        (1.0, 3.0, 3.0),
        (3.0, 3.0, 3.68),
        (25.0, 3.0, 29.95),
    ],
)
def test_how_high_it_climbs(distance_m, height_m, highest_m):
    """Highest points measured on PX4; it flies home, not up, once it is 0.8 m below the return altitude."""
    highest, _ = returning_from(distance_m, height_m)
    assert highest == pytest.approx(highest_m, rel=0.05)


@pytest.mark.flight
def test_it_says_where_it_goes():
    highest, flight = returning_from(8.0, 3.0)
    assert highest == pytest.approx(7.86, rel=0.05)  # measured on PX4
    assert flight.texts == [
        "RTL HOME activated",
        "RTL: landing at home position.",
        "RTL: climb to 496 m (8 m above destination)",
        "RTL: return at 496 m (8 m above destination)",
        "RTL: land at destination",
        "Landing detected",
        "Disarmed by landing",
    ]


@pytest.mark.flight
def test_it_turns_to_the_heading_of_its_arming_before_it_lands():
    """PX4, 90 degrees off over home: 1.6 s, the turn to within MIS_YAW_ERR at MPC_YAWRAUTO_MAX."""
    flight = Flight.of_reference_quad(noise=NO_NOISE, yaw=0.0)
    flight.take_off(3.0, yaw=math.pi / 2, seconds=12.0)
    began_s = flight.time_s
    flight.px4.request_mode(Mode.AUTO_RTL)
    assert flight.run(5.0, until=lambda: flight.px4.status.landed_state is LandedState.LANDING)
    assert flight.time_s - began_s == pytest.approx((90.0 - 12.0) / 45.0, abs=0.3)
    assert flight.run(15.0, until=lambda: flight.px4.status.landed_state is LandedState.ON_GROUND)
    assert flight.px4.status.mode is Mode.AUTO_RTL


@pytest.mark.flight
def test_a_delay_makes_it_sink_and_wait_before_it_lands():
    _, flight = returning_from(12.0, 5.0, RTL_RETURN_ALT=8.5, RTL_DESCEND_ALT=3.5, RTL_LAND_DELAY=5.0)
    assert [text for text in flight.texts if text.startswith("RTL: ")][1:] == [
        "RTL: climb to 497 m (9 m above destination)",
        "RTL: return at 497 m (9 m above destination)",
        "RTL: descend to 492 m (4 m above destination)",
        "RTL: loiter 5.0s",
        "RTL: land at destination",
    ]


@pytest.mark.flight
def test_a_negative_delay_waits_for_ever():
    flight = hovering(3.0, seconds=12.0)
    flight.px4.parameters.set("RTL_LAND_DELAY", -1.0)
    flight.px4.request_mode(Mode.AUTO_RTL)
    flight.run(20.0)
    assert flight.texts[-1] == "RTL: completed, loitering"
    assert flight.body.position[2] == pytest.approx(3.0, abs=0.2)


# The return altitude by itself: distance from home, height now, height of the return over home (closed form)


@pytest.mark.table(
    ("distance_m", "height_m", "expected_m"),
    [
        (0.0, 3.0, 3.0),  # over home: where it is
        (1.5, 1.0, 3.0),  # within NAV_ACC_RAD: twice the distance
        (1.5, 5.0, 5.0),  # never lower than it flies
        (2.5, 1.0, 4.0),  # farther: at least twice NAV_ACC_RAD
        (8.0, 3.0, 8.0),  # the cone of 45 degrees
        (9.99, 3.0, 9.99),
        (10.01, 3.0, 30.0),  # beyond RTL_MIN_DIST: RTL_RETURN_ALT
        (50.0, 40.0, 40.0),
    ],
)
def test_the_return_altitude(distance_m, height_m, expected_m):
    assert height_over_home(distance_m, height_m) == pytest.approx(expected_m)


@pytest.mark.table(
    ("angle_deg", "expected_m"),
    [
        (0, 30.0),
        (25, 8.0 / math.tan(math.radians(25.0))),
        (65, 4.0),
        (60, 8.0 / math.tan(math.radians(60.0))),
        (90, 4.0),
    ],
)
def test_the_cone(angle_deg, expected_m):
    assert height_over_home(8.0, 1.0, RTL_CONE_ANG=angle_deg) == pytest.approx(expected_m)


def test_the_cone_ends_at_rtl_min_dist():
    assert height_over_home(8.0, 1.0, RTL_MIN_DIST=5.0) == pytest.approx(30.0)


def height_over_home(distance_m, height_m, **parameters):
    home = np.array([2.0, -3.0, 0.5])
    position = home + np.array([0.6 * distance_m, 0.8 * distance_m, -height_m])
    return home[2] - return_z(position, home, Px4Parameters(parameters))
