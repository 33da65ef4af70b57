"""The low-battery failsafe: what PX4 says and flies when the charge passes BAT_LOW_THR and the others.

Expected texts and modes are those of PX4 1.12 (`battery_failsafe` of its commander).
"""

from __future__ import annotations

import pytest
from flight import hovering

from simulation_tools.px4.modes import Mode

LOW = "Low battery level! Return advised"
CRITICAL, DANGEROUS = "Critical battery level!", "Dangerous battery level!"
DRAIN_S = 5.0


@pytest.fixture
def emptying():
    """Up at 2 m, with a battery that empties in seconds."""
    flight = hovering()
    flight.px4.parameters.set("SIM_BAT_MIN_PCT", 0.0)
    flight.px4.parameters.set("SIM_BAT_DRAIN", DRAIN_S)
    return flight


def until_below(flight, share):
    """Fly until the charge is just below a share."""
    assert flight.run(DRAIN_S, until=lambda: flight.px4.status.battery.remaining < share - 0.001)


@pytest.mark.parametrize(
    ("action", "at_critical", "says", "at_emergency", "says_then"),
    [
        (0, Mode.OFFBOARD, f"{CRITICAL}, landing advised", Mode.OFFBOARD, f"{DANGEROUS}, please land!"),
        (1, Mode.AUTO_RTL, f"{CRITICAL}, executing RTL", Mode.AUTO_RTL, None),
        (2, Mode.AUTO_LAND, f"{CRITICAL}, landing", Mode.AUTO_LAND, None),
        (3, Mode.AUTO_RTL, f"{CRITICAL}, executing RTL", Mode.AUTO_LAND, f"{DANGEROUS}, landing"),
    ],
)
def test_com_low_bat_act_is_what_flies(emptying, action, at_critical, says, at_emergency, says_then):
    px4 = emptying.px4
    px4.parameters.set("COM_LOW_BAT_ACT", action)
    until_below(emptying, 0.16)
    assert (px4.status.mode, emptying.texts) == (Mode.OFFBOARD, [])
    until_below(emptying, 0.15)
    assert (px4.status.mode, emptying.texts) == (Mode.OFFBOARD, [LOW])
    until_below(emptying, 0.07)
    assert px4.status.mode is at_critical
    assert says in emptying.texts
    emptying.texts.clear()
    until_below(emptying, 0.05)
    emptying.run(0.1)
    assert px4.status.mode is at_emergency
    dangerous = [text for text in emptying.texts if text.startswith(DANGEROUS)]
    assert dangerous == ([says_then] if says_then else [])


def test_an_empty_battery_lands_the_uav_on_the_ground(emptying):
    emptying.px4.parameters.set("COM_LOW_BAT_ACT", 2)
    assert emptying.run(20.0, until=lambda: not emptying.px4.status.armed)
    assert emptying.body.position[2] == pytest.approx(0.0, abs=0.01)


def test_the_thresholds_are_the_parameters(emptying):
    for name, share in (("BAT_LOW_THR", 0.5), ("BAT_CRIT_THR", 0.25), ("COM_LOW_BAT_ACT", 1)):
        emptying.px4.parameters.set(name, share)
    until_below(emptying, 0.5)
    assert emptying.texts == [LOW]
    until_below(emptying, 0.25)
    assert emptying.px4.status.mode is Mode.AUTO_RTL


def test_a_long_way_home_counts_as_used():
    """2 m at MPC_Z_VEL_MAX_DN of 1 m/s take 2 s; with RTL_FLT_TIME 0.1 min that is a third of the battery."""
    flight = hovering()
    flight.px4.parameters.set("SIM_BAT_MIN_PCT", 30.0)
    flight.px4.parameters.set("SIM_BAT_DRAIN", DRAIN_S)
    flight.px4.parameters.set("RTL_FLT_TIME", 0.1)
    way = flight.body.position[2] / 6.0
    until_below(flight, 0.15 + way + 0.02)
    assert flight.texts == []
    until_below(flight, 0.15 + way - 0.02)
    assert flight.texts == [LOW]


def test_the_default_battery_never_gets_so_low():
    flight = hovering()
    flight.px4.parameters.set("SIM_BAT_DRAIN", DRAIN_S)
    flight.run(DRAIN_S)
    assert flight.px4.status.battery.remaining == 0.5
    assert (flight.px4.status.mode, flight.texts) == (Mode.OFFBOARD, [])
