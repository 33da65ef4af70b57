"""PX4's failsafes as measured on PX4 SITL: which mode flies, what is said, and what comes after."""

from __future__ import annotations

import pytest
from flight import NO_NOISE, Flight, hovering

from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint

NO_STICKS = "Failsafe enabled: No manual control stick input"
NO_SETPOINTS = "Failsafe enabled: no RC and no offboard"
ON, OFF = "Failsafe mode activated", "Failsafe mode deactivated"
LANDED_TEXTS = ["Landing detected", "Disarmed by landing"]
MANUAL_MODES = [Mode.MANUAL, Mode.ACRO, Mode.STABILIZED, Mode.ALTCTL, Mode.POSCTL]


@pytest.fixture
def armed():
    """Armed on the ground, in hold, what has been said forgotten."""
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(1.0)
    assert flight.px4.request_arm() is Result.ACCEPTED
    flight.texts.clear()
    return flight


def mode(flight):
    return flight.px4.status.mode


# On the ground


@pytest.mark.parametrize("wanted", MANUAL_MODES)
def test_a_manual_mode_without_sticks_holds_on_the_ground_and_disarms(armed, wanted):
    armed.run(1.0)
    assert armed.px4.request_mode(wanted) is Result.ACCEPTED
    armed.run(0.1)
    status = armed.px4.status
    assert (status.mode, status.wanted_mode, status.system_status) == (Mode.AUTO_LOITER, wanted, 5)
    assert armed.texts == [NO_STICKS, ON]

    assert armed.run(12.0, until=lambda: not armed.px4.status.armed)
    assert armed.time_s == pytest.approx(1.0 + 10.0, abs=0.05)  # since arming, not since the mode
    armed.run(0.1)
    assert armed.body.position == (0.0, 0.0, 0.0)
    assert armed.texts[2:] == ["Disarmed by auto preflight disarming", OFF]
    # MANUAL is left for hold, as at boot; the others stay.
    assert mode(armed) is (Mode.AUTO_LOITER if wanted is Mode.MANUAL else wanted)


def test_a_failsafe_soon_after_another_goes_on_waiting_where_that_was(armed):
    """15 s count from the first one: seen on PX4, armed for the second time after 9 s."""
    px4 = armed.px4
    px4.request_mode(Mode.STABILIZED)
    armed.run(9.0)
    px4.request_arm(False)
    armed.run(0.5)
    px4.request_arm()
    assert armed.run(10.0, until=lambda: mode(armed) is Mode.AUTO_RTL)
    assert armed.time_s == pytest.approx(1.0 + 15.0, abs=0.05)
    assert armed.body.position == (0.0, 0.0, 0.0)


def test_without_setpoints_it_arms_into_a_landing_on_the_ground(armed):
    px4 = armed.px4
    px4.request_arm(False)
    armed.stream = Setpoint.hold((0.0, 0.0, 2.0))
    armed.run(0.1)
    px4.request_mode(Mode.OFFBOARD)
    armed.stream = None
    armed.texts.clear()
    armed.run(2.0)
    assert (mode(armed), px4.status.system_status) == (Mode.AUTO_LAND, 3)
    assert px4.request_arm() is Result.ACCEPTED
    armed.run(2.0)
    assert (mode(armed), px4.status.system_status) == (Mode.AUTO_LAND, 5)
    assert armed.texts == [ON, "Armed by external command"]
    assert armed.body.position == (0.0, 0.0, 0.0)


# The remote control, in the air


def test_a_manual_mode_without_sticks_holds_first_and_returns_later():
    flight = hovering()
    flight.stream = None
    began_s = flight.time_s
    assert flight.px4.request_mode(Mode.POSCTL) is Result.ACCEPTED
    flight.run(0.1)
    assert (mode(flight), flight.px4.status.system_status) == (Mode.AUTO_LOITER, 5)
    assert flight.run(20.0, until=lambda: mode(flight) is Mode.AUTO_RTL)
    assert flight.time_s - began_s == pytest.approx(15.0, abs=0.05)  # COM_RCL_ACT_T
    flight.run(0.1)
    status = flight.px4.status
    assert (status.wanted_mode, status.system_status) == (Mode.AUTO_RTL, 4)  # for good: no failsafe any more
    assert flight.texts[:4] == [NO_STICKS, ON, "RTL HOME activated", "RTL: landing at home position."]
    assert OFF in flight.texts
    assert flight.run(20.0, until=lambda: not flight.px4.status.armed)
    assert mode(flight) is Mode.AUTO_RTL


def test_com_rcl_act_t_is_how_long_it_holds():
    flight = hovering()
    flight.px4.parameters.set("COM_RCL_ACT_T", 3.0)
    flight.px4.request_mode(Mode.ALTCTL)
    flight.run(2.9)
    assert mode(flight) is Mode.AUTO_LOITER
    flight.run(0.2)
    assert mode(flight) is Mode.AUTO_RTL


@pytest.mark.table(("action", "flown"), [(1, Mode.AUTO_LOITER), (3, Mode.AUTO_LAND), (0, Mode.OFFBOARD)])
def test_nav_rcl_act_is_what_it_does_then(action, flown):
    flight = hovering()
    flight.px4.parameters.set("COM_RCL_ACT_T", 0.0)
    flight.px4.parameters.set("NAV_RCL_ACT", action)
    flight.px4.request_mode(Mode.STABILIZED)
    flight.run(0.1)
    status = flight.px4.status
    assert (status.mode, status.wanted_mode, status.failsafe) == (flown, Mode.STABILIZED, True)


def test_another_mode_ends_the_hold():
    flight = hovering()
    flight.px4.request_mode(Mode.POSCTL)
    flight.run(5.0)
    assert flight.px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
    flight.run(0.1)
    assert (mode(flight), flight.px4.status.failsafe) == (Mode.OFFBOARD, False)
    assert flight.texts == [NO_STICKS, ON, OFF]


# The ground station


def test_without_a_ground_station_hold_may_become_return():
    flight = hovering()
    flight.px4.request_mode(Mode.AUTO_LOITER)
    flight.run(0.1)
    assert mode(flight) is Mode.AUTO_LOITER  # NAV_DLL_ACT is 0
    flight.px4.parameters.set("NAV_DLL_ACT", 2)
    flight.run(0.1)
    assert flight.texts[:2] == ["Failsafe enabled: no datalink", ON]
    assert (mode(flight), flight.px4.status.failsafe) == (Mode.AUTO_RTL, False)
    flight.px4.ground_station_heard()
    flight.run(0.1)
    assert mode(flight) is Mode.AUTO_RTL  # a return is for good


def test_with_a_ground_station_it_holds():
    flight = hovering()
    flight.px4.parameters.set("NAV_DLL_ACT", 3)
    flight.px4.ground_station_heard()
    flight.px4.request_mode(Mode.AUTO_LOITER)
    flight.run(9.9)
    assert mode(flight) is Mode.AUTO_LOITER
    flight.run(0.2)  # COM_DL_LOSS_T is 10 s
    assert mode(flight) is Mode.AUTO_LAND
    flight.px4.ground_station_heard()
    flight.run(0.1)
    assert (mode(flight), flight.px4.status.failsafe) == (Mode.AUTO_LOITER, False)


# Offboard setpoints


def test_losing_the_stream_lands_and_its_return_brings_offboard_back():
    flight = hovering()
    flight.stream = None
    lost_s = flight.time_s
    assert flight.run(2.0, until=lambda: mode(flight) is Mode.AUTO_LAND)
    assert flight.time_s - lost_s == pytest.approx(1.0, abs=0.05)
    status = flight.px4.status
    assert (status.failsafe, status.system_status, status.armed) == (True, 5, True)
    flight.run(1.0)
    assert flight.body.velocity[2] < -0.3
    flight.stream = Setpoint.hold((0.0, 0.0, 2.0))
    flight.run(0.1)
    assert mode(flight) is Mode.OFFBOARD
    assert flight.px4.status.system_status == 4
    assert flight.texts == [NO_SETPOINTS, ON, OFF]
    flight.run(8.0)
    assert flight.body.position[2] == pytest.approx(2.0, abs=0.1)


def test_after_a_failsafe_landing_it_stays_in_land_until_setpoints_come():
    flight = hovering()
    flight.stream = None
    assert flight.run(15.0, until=lambda: not flight.px4.status.armed)
    assert flight.body.position[2] == pytest.approx(0.0, abs=0.01)
    assert flight.texts == [NO_SETPOINTS, ON, *LANDED_TEXTS]
    flight.run(10.0)
    status = flight.px4.status
    assert (status.mode, status.base_mode, status.system_status) == (Mode.AUTO_LAND, 29, 3)
    flight.stream = Setpoint.hold((0.0, 0.0, 2.0))
    flight.run(0.1)
    assert (mode(flight), flight.texts[-1]) == (Mode.OFFBOARD, OFF)


@pytest.mark.table(
    ("action", "flown"),
    [(-1, Mode.OFFBOARD), (0, Mode.AUTO_LAND), (1, Mode.AUTO_LOITER), (2, Mode.AUTO_RTL)],
)
def test_com_obl_act_is_what_it_does_without_setpoints(action, flown):
    flight = hovering()
    flight.px4.parameters.set("COM_OBL_ACT", action)
    flight.stream = None
    flight.run(1.2)
    status = flight.px4.status
    assert (status.mode, status.wanted_mode, status.failsafe) == (flown, Mode.OFFBOARD, True)
