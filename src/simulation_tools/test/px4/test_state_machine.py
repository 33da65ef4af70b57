"""Each line of the reference's state machine, in flight, without MAVLink (see test_link for the messages)."""

from __future__ import annotations

import math

import pytest
from flight import NO_NOISE, Flight, hovering

from simulation_tools.px4.commands import DO_FLIGHTTERMINATION, DO_REPOSITION
from simulation_tools.px4.modes import LandedState, Mode, Result
from simulation_tools.px4.setpoint import AttitudeSetpoint, Setpoint

NAN = math.nan
ARM, DISARM_BY_FORCE = (1, 0, 0, 0, 0, 0, 0), (0, 21196, 0, 0, 0, 0, 0)
DISARM = (0,) * 7
ZERO = Setpoint(velocity=(0.0, 0.0, 0.0), yaw_rate=0.0)


@pytest.fixture
def ground():
    """On the ground, a second after power-on, nothing streamed."""
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(1.0)
    return flight


def mode(flight):
    return flight.px4.status.mode


def test_boot_is_manual_then_position_then_home_then_loiter():
    flight = Flight.of_iris(noise=NO_NOISE)
    seen = []
    for _ in range(250):
        flight.step()
        px4 = flight.px4
        now = (px4.status.mode, px4.estimate_valid, px4.home is not None)
        if not seen or seen[-1] != now:
            seen.append(now)
    assert seen == [
        (Mode.MANUAL, False, False),
        (Mode.MANUAL, True, False),
        (Mode.MANUAL, True, True),
        (Mode.AUTO_LOITER, True, True),
    ] or seen == [(Mode.MANUAL, False, False), (Mode.MANUAL, True, True), (Mode.AUTO_LOITER, True, True)]


def test_arming_needs_a_local_position():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(0.1)
    assert flight.px4.command(400, ARM) is Result.TEMPORARILY_REJECTED
    assert not flight.px4.status.armed


@pytest.mark.parametrize(
    ("wanted", "base_mode", "custom_mode"),
    [
        (Mode.ALTCTL, 81, 0x00020000),
        (Mode.POSCTL, 81, 0x00030000),
        (Mode.ACRO, 65, 0x00050000),
        (Mode.STABILIZED, 81, 0x00070000),
        (Mode.AUTO_TAKEOFF, 29, 0x02040000),
        (Mode.AUTO_LOITER, 29, 0x03040000),
        (Mode.AUTO_RTL, 29, 0x05040000),
        (Mode.AUTO_LAND, 29, 0x06040000),
        (Mode.OFFBOARD, 17, 0x00060000),
    ],
)
def test_modes_and_their_numbers_disarmed(ground, wanted, base_mode, custom_mode):
    ground.px4.offer_setpoint(ZERO)
    ground.run(0.02)
    assert ground.px4.request_mode(wanted) is Result.ACCEPTED
    ground.run(0.02)
    status = ground.px4.status
    assert (status.base_mode, status.mode.custom_mode) == (base_mode, custom_mode)
    assert status.system_status == 3


def test_unarmed_in_manual_it_waits_in_hold(ground):
    assert (Mode.MANUAL.base_mode, Mode.MANUAL.custom_mode) == (81, 0x00010000)
    assert ground.px4.request_mode(Mode.MANUAL) is Result.ACCEPTED
    ground.run(0.02)
    assert mode(ground) is Mode.AUTO_LOITER


@pytest.mark.parametrize("armed", [False, True])
def test_an_offboard_that_sets_body_rates_is_not_stabilised(ground, armed):
    ground.stream = AttitudeSetpoint(None, rates=(0.0, 0.0, 0.0))
    ground.run(0.1)
    ground.px4.request_mode(Mode.OFFBOARD)
    if armed:
        ground.px4.request_arm()
    assert ground.px4.status.base_mode == (129 if armed else 1)


def test_arming_sets_home_unless_somebody_has_chosen_a_place(ground):
    px4 = ground.px4
    latitude, longitude = px4.origin.to_global(5.0, -2.0)
    chosen, here = (0, 0, 0, 0, latitude, longitude, px4.origin.altitude_m), (1, 0, 0, 0, 0, 0, 0)
    assert px4.command(179, chosen) is Result.ACCEPTED
    px4.command(400, ARM)
    assert px4.home.tolist() == pytest.approx([5.0, -2.0, 0.0], abs=0.01)
    px4.command(400, DISARM)
    assert px4.command(179, here) is Result.ACCEPTED
    px4.command(400, ARM)
    assert px4.home.tolist() == pytest.approx([0.0, 0.0, 0.0], abs=0.01)


def test_on_the_ground_it_may_be_armed_twice(ground):
    for _ in range(2):
        assert ground.px4.command(400, ARM) is Result.ACCEPTED
        assert ground.px4.status.system_status == 4  # active


def test_arming_in_the_air_is_denied():
    flight = hovering()
    assert flight.px4.command(400, ARM) is Result.DENIED
    assert flight.texts[-1] == "Arming denied! Already armed"


def test_disarming_in_the_air_is_denied_but_by_force():
    flight = hovering()
    assert flight.px4.command(400, DISARM) is Result.DENIED
    assert flight.texts[-1] == "Disarming denied! Not landed"
    assert flight.px4.status.armed
    assert flight.px4.command(400, DISARM_BY_FORCE) is Result.ACCEPTED
    assert not flight.px4.status.armed
    flight.run(0.05)
    assert (flight.px4.commands == 0.0).all()


def test_auto_disarm_ten_seconds_after_arming_without_take_off(ground):
    ground.px4.command(400, ARM)
    armed_s = ground.time_s
    assert ground.run(15.0, until=lambda: not ground.px4.status.armed)
    assert ground.time_s - armed_s == pytest.approx(10.0, abs=0.05)


def test_it_is_in_the_air_about_two_seconds_after_arming():
    flight = Flight.of_reference_quad(noise=NO_NOISE)
    flight.stream = Setpoint.hold((0.0, 0.0, 2.0), 0.0)
    flight.run(1.0)
    flight.px4.request_mode(Mode.OFFBOARD)
    flight.px4.request_arm()
    armed_s = flight.time_s
    assert flight.run(5.0, until=lambda: flight.px4.status.landed_state is LandedState.IN_AIR)
    # The reference says about 1.9 s, seen through a 5 Hz stream.
    assert 1.5 <= flight.time_s - armed_s <= 2.1


def test_landing_sinks_at_its_speed_and_disarms_two_seconds_after():
    flight = hovering(4.0, seconds=14.0)
    assert flight.px4.command(21, (0,) * 7) is Result.ACCEPTED
    rows = flight.record(4.0)
    middle = (rows[:, 0] > 2.0) & (rows[:, 0] < 4.0)
    assert rows[middle, 6].mean() == pytest.approx(-0.72, abs=0.05)
    assert flight.px4.status.landed_state is LandedState.LANDING
    assert flight.run(10.0, until=lambda: flight.px4.status.landed_state is LandedState.ON_GROUND)
    landed_s = flight.time_s
    assert flight.run(5.0, until=lambda: not flight.px4.status.armed)
    assert flight.time_s - landed_s == pytest.approx(2.0, abs=0.05)
    assert math.hypot(*flight.body.position[:2]) < 0.2


@pytest.mark.table(("rate_hz", "holds"), [(2.0, True), (1.25, True), (0.9, False)])
def test_how_slow_a_stream_holds_offboard(rate_hz, holds):
    flight = hovering()
    flight.stream_period_us = round(1e6 / rate_hz)
    lost = flight.run(8.0, until=lambda: mode(flight) is not Mode.OFFBOARD)
    assert lost is not holds


@pytest.mark.parametrize(
    "nothing",
    [
        Setpoint(yaw=1.0),
        Setpoint(),
        Setpoint(velocity=(math.inf, 0.0, 0.0)),
        AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), thrust=NAN),
        AttitudeSetpoint(None, thrust=0.5),
    ],
)
def test_what_asks_for_nothing_is_no_setpoint(ground, nothing):
    assert not ground.px4.offer_setpoint(nothing)
    ground.run(0.02)
    assert ground.px4.request_mode(Mode.OFFBOARD) is Result.TEMPORARILY_REJECTED


@pytest.mark.parametrize("altitude_m", [NAN, 488.0, 490.45])
def test_the_take_off_command_rises_by_the_least_height_and_holds(ground, altitude_m):
    """Armed before or after, as on PX4. 488 m is the ground; 5 cm too low is not worth a word."""
    ground.px4.command(400, ARM)
    ground.run(1.0)
    assert mode(ground) is Mode.AUTO_LOITER
    assert ground.px4.command(22, (0, 0, 0, NAN, NAN, NAN, altitude_m)) is Result.ACCEPTED
    ground.run(0.02)
    assert mode(ground) is Mode.AUTO_TAKEOFF
    told = "Using minimum takeoff altitude: 2.50 m" in ground.texts
    assert told is (altitude_m != 490.45)
    assert ground.run(15.0, until=lambda: ground.px4.status.landed_state is LandedState.TAKEOFF)
    assert ground.run(20.0, until=lambda: mode(ground) is Mode.AUTO_LOITER)
    ground.run(8.0)
    assert ground.body.position[2] == pytest.approx(2.5, abs=0.1)


def test_a_take_off_command_in_the_air_rises_by_the_least_height_from_there():
    """PX4: from 2.50 m to 4.86 m, in TAKEOFF for 2 to 3 s."""
    flight = hovering(2.5, seconds=12.0)
    flight.px4.request_mode(Mode.AUTO_LOITER)
    flight.run(2.0)
    assert flight.px4.command(22, (0, 0, 0, NAN, NAN, NAN, 0.0)) is Result.ACCEPTED
    flight.run(0.02)
    assert mode(flight) is Mode.AUTO_TAKEOFF
    flight.run(12.0)
    assert mode(flight) is Mode.AUTO_LOITER
    assert flight.body.position[2] == pytest.approx(5.0, abs=0.2)


def test_landing_and_return_commands_say_so(ground):
    assert ground.px4.command(21, (0,) * 7) is Result.ACCEPTED
    assert ground.px4.command(20, (0,) * 7) is Result.ACCEPTED
    assert ground.px4.command(20, (0,) * 7) is Result.TEMPORARILY_REJECTED  # it returns already
    assert ground.texts == ["Landing at current position", "Returning to launch", "Return to launch denied"]


def test_hold_brakes_and_stays():
    flight = hovering()
    flight.stream = Setpoint.fly((3.0, 0.0, 0.0), 0.0)
    flight.run(5.0)
    flight.stream = None
    assert flight.px4.request_mode(Mode.AUTO_LOITER) is Result.ACCEPTED
    flight.run(8.0)
    before = flight.body.position
    flight.run(5.0)
    assert math.dist(before, flight.body.position) < 0.1
    assert mode(flight) is Mode.AUTO_LOITER


def test_reset_is_power_on_again():
    flight = hovering()
    flight.px4.reset()
    flight.body.time_us = 0
    flight.stream = None
    flight.step()
    assert (mode(flight), flight.px4.status.armed) == (Mode.MANUAL, False)
    assert not flight.px4.estimate_valid


def test_attitude_setpoints_tilt_the_vehicle():
    flight = hovering(5.0, seconds=15.0)
    half = math.radians(5.0)
    q = (math.cos(half), 0.0, math.sin(half), 0.0)  # nose up by 10 degrees, heading north
    flight.stream = AttitudeSetpoint(q, thrust=0.75)
    flight.run(2.0)
    w, x, y, z = flight.px4.estimate["attitude"][0].tolist()
    assert math.degrees(math.asin(2.0 * (w * y - z * x))) == pytest.approx(10.0, abs=0.5)


def test_body_rate_setpoints_turn_the_vehicle():
    flight = hovering(5.0, seconds=15.0)
    flight.stream = AttitudeSetpoint(None, rates=(0.0, 0.0, 0.4), thrust=0.73)
    flight.run(1.5)
    assert flight.px4.estimate["rates"][0, 2] == pytest.approx(0.4, abs=0.05)


# Flight termination: as flown on PX4


def test_termination_stops_the_rotors_until_it_is_taken_back():
    flight = hovering()
    assert flight.px4.command(DO_FLIGHTTERMINATION, (1.0, *(0.0,) * 6)) is Result.ACCEPTED
    flight.run(1.0)
    assert not flight.px4.commands.any()
    assert flight.body.position[2] == 0.0  # 2 m take 0.64 s
    status = flight.px4.status
    assert (status.armed, status.mode, status.system_status) == (True, Mode.OFFBOARD, 8)
    assert flight.px4.command(DO_FLIGHTTERMINATION, (0.0,) * 7) is Result.ACCEPTED
    flight.run(1.0)
    assert flight.px4.commands.any()
    assert flight.px4.status.system_status == 4


def test_a_lockdown_disarms_five_seconds_later():
    flight = hovering()
    flight.px4.command(DO_FLIGHTTERMINATION, (2.0, *(0.0,) * 6))
    flight.run(4.9)
    assert flight.px4.status.armed
    flight.run(0.2)
    assert not flight.px4.status.armed
    assert "Disarmed by lockdown" in flight.texts


# A place to hold without a heading


def test_without_a_heading_it_looks_at_the_place_and_then_stays():
    """MPC_YAW_MODE 0: towards the target outside the acceptance radius, inside the heading it has there."""
    flight = hovering()
    flight.px4.request_mode(Mode.AUTO_LOITER)
    latitude, longitude = flight.px4.origin.to_global(-10.0, 0.0)
    nan = math.nan
    flight.px4.command(DO_REPOSITION, (nan, 1.0, 0.0, nan, latitude, longitude, nan))
    flight.run(5.5)
    south = float(flight.px4.estimate["yaw"][0])
    assert abs(south) == pytest.approx(math.pi, abs=0.15)
    flight.run(6.0)
    assert flight.body.position[1] == pytest.approx(-10.0, abs=0.2)
    assert abs(float(flight.px4.estimate["yaw"][0])) == pytest.approx(abs(south), abs=0.2)


def test_a_heading_that_is_given_is_kept():
    flight = hovering()
    flight.px4.request_mode(Mode.AUTO_LOITER)
    latitude, longitude = flight.px4.origin.to_global(-5.0, 0.0)
    flight.px4.command(DO_REPOSITION, (math.nan, 1.0, 0.0, 0.5, latitude, longitude, math.nan))
    flight.run(6.0)
    assert float(flight.px4.estimate["yaw"][0]) == pytest.approx(0.5, abs=0.05)
