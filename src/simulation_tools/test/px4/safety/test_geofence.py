"""The fence: where PX4 reacts, what it then flies, and what counts as outside."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flight import NO_NOISE, Flight, hovering
from plans import Places

from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.plan.items import Command
from simulation_tools.px4.plan.plan import PlanKind
from simulation_tools.px4.safety.geofence import areas_of, is_inside, stopping_distance
from simulation_tools.px4.setpoint import NAN, Setpoint

APPROACHING = "Approaching on Geofence"
FAR, HIGH = "Maximum distance from home reached (25.00000)", "Maximum altitude above home reached (6.00000)"
LIMIT, MOST, JERK = 3.0, 5.0, 4.0  # MPC_ACC_HOR, MPC_ACC_HOR_MAX, MPC_JERK_AUTO
CHECK_S = 0.2


def stop_by_steps(speed, dt=1e-4):
    """From an acceleration of MOST: jerk to -LIMIT, hold it, and jerk to 0 when that leaves no speed."""
    x, v, a = 0.0, speed, MOST
    while True:
        releases = a < 0.0 and v <= 0.5 * a * a / JERK
        if releases and a >= -1e-3:
            return x
        brakes = -JERK if a > -LIMIT else 0.0
        jerk = JERK if releases else brakes
        x, v, a = x + v * dt, v + a * dt, a + jerk * dt


@pytest.mark.table("speed", [0.0, 1.0, 3.0, 8.0])
def test_the_stopping_distance_is_that_of_a_vehicle_that_accelerates_first(speed):
    expected = stop_by_steps(speed) + CHECK_S * speed
    assert stopping_distance(speed, LIMIT, MOST, JERK) == pytest.approx(expected, abs=0.02)


def north_at(speed, **parameters):
    """A flight in OFFBOARD at 2 m that flies north, with parameters."""
    flight = hovering()
    for name, value in parameters.items():
        flight.px4.parameters.set(name, value)
    flight.stream = Setpoint(velocity=(speed, 0.0, 0.0), yaw_rate=0.0)
    return flight


def reaction(flight, seconds=12.0):
    """Fly until the mode changes; returns how far north the UAV is then, NaN if it never changes."""
    changed = flight.run(seconds, until=lambda: flight.px4.status.mode is not Mode.OFFBOARD)
    return flight.body.position[1] if changed else math.nan


@pytest.mark.table(("action", "mode"), [(2, Mode.AUTO_LOITER), (3, Mode.AUTO_RTL), (5, Mode.AUTO_LAND)])
def test_at_the_greatest_distance_gf_action_flies(action, mode):
    flight = north_at(3.0, GF_MAX_HOR_DIST=25.0, GF_ACTION=action)
    where = reaction(flight)
    assert flight.px4.status.mode is mode
    speed = flight.body.velocity[1]
    nearest = 25.0 - stopping_distance(speed, LIMIT, MOST, JERK)
    assert nearest <= where <= nearest + CHECK_S * speed + 0.1
    assert flight.texts[:2] == [FAR, APPROACHING]
    flight.run(6.0)
    assert flight.body.position[1] < 25.0


def test_hold_stays_well_inside_and_the_client_may_fly_on():
    flight = north_at(3.0, GF_MAX_HOR_DIST=25.0)  # GF_ACTION is 2 by default
    reaction(flight)
    flight.run(12.0)
    # As far from the fence as twice the stopping distance at rest.
    assert flight.body.position[1] == pytest.approx(25.0 - 2.0 * stop_by_steps(0.0), abs=0.3)
    assert flight.px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
    flight.run(0.5)
    assert flight.px4.status.mode is Mode.OFFBOARD


def test_warn_only_says_it_and_none_says_nothing():
    for action, texts in ((1, [FAR, APPROACHING]), (0, [])):
        flight = north_at(4.0, GF_MAX_HOR_DIST=25.0, GF_ACTION=action)
        assert math.isnan(reaction(flight, 6.0))
        assert flight.texts == texts


def test_the_greatest_height_counts_from_home():
    flight = north_at(0.0, GF_MAX_VER_DIST=6.0, GF_ACTION=5)
    flight.stream = Setpoint(velocity=(0.0, 0.0, -1.5), yaw_rate=0.0)
    reaction(flight)
    assert flight.px4.status.mode is Mode.AUTO_LAND
    assert flight.texts[:2] == [HIGH, APPROACHING]
    flight.run(2.0)
    assert flight.body.position[2] < 6.0


def test_terminate_stops_the_rotors():
    flight = north_at(3.0, GF_MAX_HOR_DIST=25.0, GF_ACTION=4)
    assert flight.run(12.0, until=lambda: not flight.px4.commands.any())
    assert flight.texts[:3] == [FAR, APPROACHING, "Geofence violation! Flight terminated"]
    assert flight.px4.status.system_status == 8
    flight.run(1.0)
    assert flight.body.position[2] < 0.1  # 2 m of free fall take 0.6 s


def test_an_uploaded_polygon_is_kept():
    flight = north_at(3.0, GF_ACTION=2)
    square = Places(flight).polygon((-20, -20), (-20, 20), (20, 20), (20, -20))
    flight.px4.plan.replace(PlanKind.FENCE, square)
    where = reaction(flight)
    assert flight.px4.status.mode is Mode.AUTO_LOITER
    assert 20.0 - stopping_distance(3.3, LIMIT, MOST, JERK) <= where < 20.0
    assert flight.texts[0] == APPROACHING
    flight.run(8.0)
    assert flight.body.position[1] == pytest.approx(20.0 - 2.0 * stop_by_steps(0.0), abs=0.6)
    flight.px4.plan.replace(PlanKind.FENCE, ())
    flight.stream = Setpoint(velocity=(3.0, 0.0, 0.0), yaw_rate=0.0)
    flight.px4.request_mode(Mode.OFFBOARD)
    assert flight.run(8.0, until=lambda: flight.body.position[1] > 22.0)


def test_hold_does_not_go_to_a_place_outside():
    flight = hovering()
    flight.px4.parameters.set("GF_MAX_HOR_DIST", 25.0)
    flight.px4.request_mode(Mode.AUTO_LOITER)
    latitude, longitude = flight.px4.origin.to_global(30.0, 0.0)
    nan = math.nan
    flight.texts.clear()
    assert flight.px4.command(192, (nan, 1.0, 0.0, nan, latitude, longitude, nan)) is Result.ACCEPTED
    assert flight.texts == [FAR, "Reposition is outside geofence"]
    flight.run(3.0)
    assert np.hypot(*flight.body.position[:2]) < 0.1


def test_while_the_battery_fails_the_fence_does_nothing():
    flight = north_at(3.0, GF_MAX_HOR_DIST=25.0, GF_ACTION=5, SIM_BAT_MIN_PCT=0.0, SIM_BAT_DRAIN=2.0)
    assert math.isnan(reaction(flight, 7.0))
    assert APPROACHING in flight.texts


def test_a_disarmed_uav_hears_of_no_fence():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.px4.parameters.set("GF_MAX_HOR_DIST", 1.0)
    flight.run(2.0)
    assert APPROACHING not in flight.texts


# What counts as inside


@pytest.fixture(scope="module")
def places():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(0.1)
    return Places(flight), flight.px4.origin


def test_a_polygon_that_is_not_convex(places):
    make, origin = places
    # An L: 10 x 10 m without its north-east quarter.
    areas = areas_of(make.polygon((0, 0), (10, 0), (10, 5), (5, 5), (5, 10), (0, 10)), origin)
    inside = [(2, 2), (8, 2), (2, 8), (4.9, 9.9)]
    outside = [(8, 8), (5.1, 5.1), (-1, 2), (2, 11), (11, 2)]
    assert all(is_inside(areas, *point) for point in inside)
    assert not any(is_inside(areas, *point) for point in outside)


def test_inclusions_add_up_and_exclusions_win(places):
    make, origin = places
    items = [
        *make.circle(0, 0, 10),
        make.item(Command.FENCE_RETURN_POINT, 50, 50),
        *make.polygon((20, -5), (30, -5), (30, 5), (20, 5)),
        *make.circle(25, 0, 2, inclusion=False),
    ]
    areas = areas_of(items, origin)
    assert is_inside(areas, 0, 9)
    assert is_inside(areas, 21, 0)
    assert not is_inside(areas, 15, 0)  # between both
    assert not is_inside(areas, 25, 1)  # excluded
    assert is_inside(areas_of(make.circle(0, 0, 5, inclusion=False), origin), 100, 0)  # an exclusion alone
    assert is_inside([], NAN, 0.0)  # no fence
