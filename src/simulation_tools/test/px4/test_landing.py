"""When PX4 believes that it has landed, as measured on PX4 SITL, and when a landed vehicle is disarmed."""

from __future__ import annotations

from functools import partial

import pytest
from flight import NO_NOISE, Flight, hovering

from simulation_tools.px4.modes import LandedState, Mode
from simulation_tools.px4.setpoint import AttitudeSetpoint, Setpoint

LEVEL = AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), thrust=0.0)
NO_TURN = AttitudeSetpoint(None, rates=(0.0, 0.0, 0.0), thrust=0.0)
BELOW_GROUND = Setpoint.hold((0.0, 0.0, -0.5))
a_metre_up = partial(hovering, 1.0, make=Flight.of_reference_quad)


def sinking(speed_m_s):
    return Setpoint(velocity=(0.0, 0.0, speed_m_s), yaw_rate=0.0)


def armed_on_the_ground(stream):
    flight = Flight.of_reference_quad(noise=NO_NOISE)
    flight.stream = stream
    flight.run(1.0)
    flight.px4.request_mode(Mode.OFFBOARD)
    flight.px4.request_arm()
    return flight


def landed_state(flight):
    return flight.px4.status.landed_state


@pytest.mark.table("stream", [LEVEL, NO_TURN, sinking(0.5), BELOW_GROUND])
def test_who_never_takes_off_is_disarmed_after_ten_seconds(stream):
    flight = armed_on_the_ground(stream)
    assert flight.run(12.0, until=lambda: not flight.px4.status.armed)
    assert flight.time_s == pytest.approx(1.0 + 10.0, abs=0.05)
    assert "Takeoff detected" not in flight.texts


@pytest.mark.table("stream", [LEVEL, NO_TURN])
def test_no_thrust_on_the_ground_is_a_landing(stream):
    """PX4: landed 1.05 s after the thrust is off, disarmed 3.05 s after it."""
    flight = a_metre_up()
    flight.stream = BELOW_GROUND
    flight.run(8.0)
    assert landed_state(flight) is LandedState.IN_AIR
    flight.stream = stream
    off_s = flight.time_s
    assert flight.run(5.0, until=lambda: landed_state(flight) is LandedState.ON_GROUND)
    assert flight.time_s - off_s == pytest.approx(1.05, rel=0.1)
    assert flight.run(5.0, until=lambda: not flight.px4.status.armed)
    assert flight.time_s - off_s == pytest.approx(3.05, rel=0.1)


def test_a_little_thrust_on_the_ground_is_flight():
    """PX4: a thrust of 0.1 is above MPC_MANTHR_MIN and 0.01, so it takes off at once and never lands."""
    flight = armed_on_the_ground(AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), thrust=0.1))
    flight.run(0.5)
    assert landed_state(flight) is LandedState.IN_AIR
    flight.run(16.0)
    assert (landed_state(flight), flight.px4.status.armed) == (LandedState.IN_AIR, True)


@pytest.mark.table("stream", [sinking(0.5), sinking(0.62), BELOW_GROUND, Setpoint.hold((0.0, 0.0, -3.0))])
def test_who_does_not_ask_to_land_stands_in_the_air_for_ever(stream):
    """0.9 MPC_LAND_SPEED, 0.63 m/s, is asking for it; a place below the ground is not."""
    flight = a_metre_up()
    flight.stream = stream
    flight.run(27.0)
    assert flight.body.position[2] == pytest.approx(0.0, abs=0.01)
    assert (landed_state(flight), flight.px4.status.armed) == (LandedState.IN_AIR, True)


def test_sinking_at_nine_tenths_of_the_landing_speed_lands():
    """PX4, at 0.65 m/s from 1 m: landed after 4.2 s, disarmed after 6.2 s."""
    flight = a_metre_up()
    flight.stream = sinking(0.65)
    began_s = flight.time_s
    assert flight.run(8.0, until=lambda: landed_state(flight) is LandedState.ON_GROUND)
    assert flight.time_s - began_s == pytest.approx(4.2, rel=0.1)
    assert flight.run(8.0, until=lambda: not flight.px4.status.armed)
    assert flight.time_s - began_s == pytest.approx(6.2, rel=0.1)


def test_a_faster_landing_speed_moves_the_threshold():
    flight = a_metre_up()
    flight.px4.parameters.set("MPC_LAND_SPEED", 1.0)
    flight.stream = sinking(0.65)
    flight.run(15.0)
    assert landed_state(flight) is LandedState.IN_AIR
