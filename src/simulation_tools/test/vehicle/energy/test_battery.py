"""The battery: charge counted exactly, its voltage by the published curve, cold, and what it refuses."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.vehicle.energy.battery import (
    Battery,
    BatteryParameters,
    BatteryStart,
    cell_voltage_v,
)

IRIS = BatteryParameters(capacity_ah=5.1, initial_charge_ah=5.1, resistance_ohm=0.02)
LINEAR = BatteryParameters(2.0, 2.0, resistance_ohm=0.0, linear_voltage_v=(10.0, 0.0))
"""10 V whatever its charge: then the current of a power is constant."""


@pytest.mark.table(("share", "volts"), [(1.0, 4.1029), (0.5, 3.8034), (0.0, 2.654)])
def test_the_cells_curve_is_chens_and_rincon_moras(share, volts):
    """Their equation 2, worked out by hand."""
    assert cell_voltage_v(share) == pytest.approx(volts, abs=2e-4)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_fuller_cell_has_the_higher_voltage(one, other):
    low, high = sorted((one, other))
    assert cell_voltage_v(low) <= cell_voltage_v(high)


@given(st.floats(0.0, 400.0), st.floats(0.05, 1.0))
def test_the_terminals_give_the_power(power_w, charge):
    battery = Battery(IRIS, BatteryStart(charge))
    current = battery.current_at(power_w)
    voltage = IRIS.open_circuit_voltage_v(charge) - IRIS.resistance_ohm * current
    assert voltage * current == pytest.approx(power_w, abs=1e-9)
    assert voltage >= 0.5 * IRIS.open_circuit_voltage_v(charge)  # the solution with the smaller current


def test_more_than_it_can_give_is_its_greatest_power():
    battery = Battery(IRIS)
    assert battery.current_at(1e6) == pytest.approx(0.5 * 3 * cell_voltage_v(1.0) / 0.02)


def test_charge_is_counted_exactly():
    """60 W at 10 V are 6 A: 0.6 Ah of 2 Ah in 6 minutes, and 14 minutes are left."""
    battery = Battery(LINEAR)
    for _ in range(90_000):
        battery.draw(60.0, 0.004)
    reading = battery.reading
    assert reading.consumed_mah == pytest.approx(600.0, rel=1e-9)
    assert reading.remaining == pytest.approx(0.7, rel=1e-9)
    assert reading.current_a == pytest.approx(6.0)
    assert reading.time_remaining_s == pytest.approx(14 * 60.0)


@given(st.lists(st.tuples(st.floats(0.0, 500.0), st.floats(0.001, 30.0)), max_size=40))
def test_what_is_drawn_and_what_is_left_are_the_whole(draws):
    battery = Battery(IRIS)
    before = battery.remaining
    for power_w, dt_s in draws:
        battery.draw(power_w, dt_s)
        assert 0.0 <= battery.remaining <= before
        before = battery.remaining
    reading = battery.reading
    assert 1e-3 * reading.consumed_mah + reading.remaining * 5.1 == pytest.approx(5.1)
    assert reading.voltage_v > 0.0


def test_an_empty_battery_gives_nothing_more_until_it_is_swapped():
    battery = Battery(LINEAR, BatteryStart(0.01))
    battery.draw(100.0, 7.2)  # 10 A for 7.2 s: the 0.02 Ah that are left
    battery.draw(100.0, 1.0)
    assert battery.is_empty
    assert battery.reading.consumed_mah == pytest.approx(20.0)
    battery.swap()
    assert (battery.remaining, battery.reading.consumed_mah, battery.reading.current_a) == (1.0, 0.0, 0.0)
    battery.reset()
    assert battery.remaining == pytest.approx(0.01)


@pytest.mark.table(("celsius", "share"), [(60.0, 1.0), (20.0, 1.0), (0.0, 0.8), (-20.0, 0.6)])
def test_a_cold_battery_is_empty_sooner(celsius, share):
    battery = Battery(LINEAR, BatteryStart(temperature_c=celsius))
    battery.draw(10.0, 3600.0)  # 1 Ah
    assert battery.remaining == pytest.approx(1.0 - 0.5 / share)
    assert battery.reading.temperature_c == celsius


def test_the_current_is_told_smoothed():
    """A first-order lag: 63 % of the step after one time constant."""
    battery = Battery(LINEAR)
    for _ in range(250):
        battery.draw(60.0, 0.004)
    assert battery.reading.current_a == pytest.approx(6.0 * (1.0 - math.exp(-1.0)), rel=2e-3)
