"""The charge from readings that are coarse, wrong or missing."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exploration.energy import Charge, EnergyParameters

P = EnergyParameters()
ANY = st.one_of(st.floats(), st.floats(-0.5, 1.5))


def told(*readings):
    charge = Charge(P)
    sentences = [charge.offer(*reading) for reading in readings]
    return charge, sentences


def test_before_the_first_reading_nothing_is_known():
    charge, _ = told()
    assert (charge.at(5.0), charge.heard_s, charge.rate_per_s) == (None, None, 1.0 / 600.0)


def test_between_readings_it_drains_at_the_supposed_rate():
    charge, _ = told((0.0, 0.9))
    assert charge.at(30.0) == pytest.approx(0.9 - 30.0 / 600.0)
    assert charge.at(1e6) == 0.0


def test_the_rate_is_measured_over_the_window_and_errs_to_the_safe_side():
    """1 % every 4 s; the window of 90 s holds 92 s of it: 23 % and the resolution."""
    charge, _ = told(*((4.0 * i, 1.0 - 0.01 * i) for i in range(51)))
    assert charge.rate_per_s == pytest.approx(0.24 / 92.0)
    assert charge.rate_per_s >= 0.01 / 4.0


def test_a_battery_that_sinks_faster_than_supposed_is_known_before_the_window_is_full():
    """PX4 SITL with SIM_BAT_DRAIN 60: 1 / 60 s. In 20 s it sinks by 33 %, of which 1 % may be rounding."""
    charge, _ = told(*((2.0 * i, round(1.0 - 2.0 * i / 60.0, 2)) for i in range(11)))
    assert 0.31 / 20.0 <= charge.rate_per_s <= 1.0 / 60.0


def test_a_simulated_battery_that_will_stay_at_a_known_charge_sinks_as_fast_as_it_likes():
    """PX4 SITL's own sinks by 50 % in 30 s, and never further: no reason to come home."""
    charge = Charge(EnergyParameters(held_at=0.5))
    rates = []
    for i in range(16):
        charge.offer(2.0 * i, 1.0 - 2.0 * i / 60.0)
        rates.append(charge.rate_per_s)
    assert set(rates) == {1.0 / 600.0}


def test_neither_a_step_nor_the_first_seconds_make_a_rate():
    """A step of 1 % in 10 s may be 0.1 %; a voltage that sags by 4 % under load is no loss."""
    assert told((0.0, 0.9), (10.0, 0.89))[0].rate_per_s == 1.0 / 600.0
    assert told((0.0, 0.9), (2.0, 0.86))[0].rate_per_s == 1.0 / 600.0


def test_a_frozen_charge_drains_on_at_no_less_than_half_the_supposed_rate():
    charge, sentences = told(*((2.0 * i, 0.8) for i in range(200)))
    assert not any(sentences)
    assert charge.at(398.0) <= 0.8 - 398.0 * 0.5 / 600.0


def test_a_simulated_battery_that_stays_at_a_known_charge_is_not_frozen():
    """PX4 SITL sinks to SIM_BAT_MIN_PCT and stays there for ever; elsewhere it may be frozen as any other."""
    charge = Charge(EnergyParameters(held_at=0.5))
    for i in range(400):
        charge.offer(2.0 * i, max(1.0 - 2.0 * i / 60.0, 0.5))
    assert charge.at(798.0) == 0.5
    assert charge.rate_per_s == 1.0 / 600.0
    charge.held_at = 0.3
    assert charge.at(798.0) < 0.1


@pytest.mark.table("value", [math.nan, math.inf, -0.01, 1.2])
def test_what_is_no_charge_is_told_and_does_not_count(value):
    charge, sentences = told((0.0, 0.9), (2.0, value))
    assert sentences[0] == ""
    assert sentences[1].endswith("not a number from 0 to 1, so the last good one counts.")
    assert charge.heard_s == 0.0


def test_a_jump_up_is_told_and_does_not_count():
    charge, sentences = told((0.0, 0.31), (2.0, 0.8), (4.0, 0.34))
    assert (
        sentences[1] == "The battery's charge jumped up from 31% to 80% in flight, so the lower one counts."
    )
    assert sentences[2] == ""  # a battery's voltage recovers a little
    assert charge.heard_s == 4.0
    assert charge.at(4.0) < 0.31


def test_an_old_reading_does_not_count():
    _, sentences = told((10.0, 0.5), (9.0, 0.4))
    assert sentences[1] == "The battery's reading is older than one before it, so it does not count."


@pytest.mark.table("wrong", [0.0, 0.11, 0.64])
def test_a_single_reading_that_falls_all_at_once_does_not_count(wrong):
    charge, sentences = told((0.0, 0.7), (2.0, wrong), (4.0, 0.69))
    assert sentences == [
        "",
        f"The battery's charge fell from 70% to {wrong:.0%} all at once, so it counts when the next reading "
        "confirms it.",
        "",
    ]
    assert charge.at(4.0) == 0.69


def test_a_fall_that_the_next_reading_confirms_counts():
    charge, sentences = told((0.0, 0.7), (2.0, 0.0), (4.0, 0.0))
    assert sentences[2] == ""
    assert charge.at(4.0) == 0.0
    assert charge.heard_s == 4.0


def test_two_readings_that_fall_apart_confirm_the_higher_one():
    charge, _ = told((0.0, 0.7), (2.0, 0.4), (4.0, 0.0))
    assert charge.at(4.0) == 0.4
    assert told((0.0, 0.7), (2.0, 0.0), (4.0, 0.4))[0].at(4.0) == 0.4


def test_wrong_readings_that_come_now_and_then_never_count():
    charge, _ = told(*((float(i), 0.0 if i % 2 else 0.9 - 0.001 * i) for i in range(100)))
    assert charge.at(99.0) > 0.75


def test_a_charge_that_fell_while_nothing_was_heard_counts_at_once():
    """It sinks by 1 / 600 in a second, so 10 % in a minute are no surprise."""
    charge, sentences = told((0.0, 0.7), (60.0, 0.58))
    assert sentences[1] == ""
    assert charge.at(60.0) == 0.58


@given(st.lists(st.tuples(st.floats(0.0, 20.0), ANY), max_size=60))
def test_the_charge_never_exceeds_a_reading_that_is_believed(steps):
    charge, now_s, least = Charge(P), 0.0, 1.0
    for dt_s, value in steps:
        now_s += dt_s
        if not charge.offer(now_s, value):
            least = min(least, value)
        present = charge.at(now_s)
        assert present is None or 0.0 <= present <= least
        assert 0.5 / P.endurance <= charge.rate_per_s < math.inf
