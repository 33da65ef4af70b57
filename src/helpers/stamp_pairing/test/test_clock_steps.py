"""A clock that is set, and time that passes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stamp_pairing.clock_steps import (
    BACK_S,
    LONGEST_GAP_S,
    LONGEST_SPARSE_GAP_S,
    SharedSteadyTime,
    SteadyTime,
    clock_step_s,
)

YEAR_S = 31_536_000.0
STEPS_S = [-YEAR_S, -600.0, -0.6, 2.5, 600.0, YEAR_S]


@pytest.mark.table("gap_s", [-BACK_S, -0.01, 0.0, 0.02, 1.0, LONGEST_GAP_S])
def test_time_that_passes_and_stamps_out_of_order_are_no_step(gap_s):
    assert clock_step_s(100.0, 100.0 + gap_s) == 0.0


@pytest.mark.table("step_s", STEPS_S)
def test_what_is_longer_is_a_step(step_s):
    assert clock_step_s(100.0, 100.0 + step_s) == pytest.approx(step_s)


def test_it_begins_with_the_first_stamp():
    time = SteadyTime()
    assert time.now_s == -math.inf
    assert time.at(100.0) == 100.0


@pytest.mark.table("step_s", STEPS_S)
def test_a_step_is_no_time(step_s):
    time = SteadyTime()
    time.at(1e9)
    assert time.at(1e9 + 0.1) == pytest.approx(1e9 + 0.1)
    assert time.at(1e9 + 0.1 + step_s) == pytest.approx(1e9 + 0.1)
    assert time.step_s == pytest.approx(step_s)
    assert time.at(1e9 + 0.2 + step_s) == pytest.approx(1e9 + 0.2)
    assert time.step_s == 0.0


def test_it_stands_still_until_a_trimmed_clock_has_caught_up():
    time = SteadyTime()
    told = [time.at(stamp_s) for stamp_s in (10.0, 9.6, 9.9, 10.1)]
    assert told == [10.0, 10.0, 10.0, 10.1]


@pytest.mark.table("step_s", STEPS_S)
def test_another_stream_of_either_clock_has_the_time_at_which_it_came(step_s):
    time = SteadyTime()
    time.at(1000.0)
    assert time.of_other(999.5) == 999.5
    assert time.of_other(1000.2 + step_s) == pytest.approx(
        1000.0, abs=LONGEST_GAP_S
    )  # the step comes with it
    time.at(1000.0 + step_s)
    assert time.of_other(999.9 + step_s) == pytest.approx(999.9)
    assert time.of_other(1000.0) == pytest.approx(1000.0, abs=LONGEST_GAP_S)  # it comes after the step
    assert time.of_other(0.0) == pytest.approx(1000.0)  # it has no stamp


@given(st.lists(st.floats(-2.0 * YEAR_S, 2.0 * YEAR_S), min_size=1, max_size=50))
def test_it_never_goes_back_and_never_leaps(stamps_s):
    time, before_s = SteadyTime(), None
    for stamp_s in stamps_s:
        now_s = time.at(stamp_s)
        assert before_s is None or -1e-6 <= now_s - before_s <= LONGEST_GAP_S + 1e-6
        before_s = now_s


@pytest.mark.table("clock_s", [100.0, 0.0, 50.0 * YEAR_S])
def test_while_it_is_silent_any_other_stream_leads_the_time_by_its_own_clock(clock_s):
    time = SteadyTime()
    time.at(100.0)
    for second in range(31):
        time.passes("battery", clock_s + second)
        time.passes("frozen", clock_s)
    assert time.silent_s == 30.0
    assert time.now_s == 130.0
    assert time.at(130.4) == pytest.approx(130.4)  # and the stream's return is no step
    assert (time.step_s, time.silent_s) == (0.0, 0.0)


def test_streams_of_a_clock_that_is_set_or_paused_tell_no_time():
    time = SteadyTime()
    time.at(100.0)
    for stamp_s in (0.0, 600.0, 600.0, 600.0, -YEAR_S):
        time.passes("clock", stamp_s)
    assert (time.now_s, time.silent_s) == (100.0, 0.0)


@given(st.lists(st.tuples(st.sampled_from(["leads", "one", "two"]), st.floats(-300.0, 300.0)), max_size=50))
def test_it_never_goes_back_whoever_leads(told):
    time, before_s = SteadyTime(), 0.0
    time.at(before_s)
    for stream, stamp_s in told:
        _ = time.at(stamp_s) if stream == "leads" else time.passes(stream, stamp_s)
        assert -1e-6 <= time.now_s - before_s <= LONGEST_SPARSE_GAP_S + 1e-6
        before_s = time.now_s


@pytest.mark.table("step_s", [2.5, 600.0, YEAR_S])
def test_streams_of_both_clocks_keep_their_order_while_it_is_set_ahead(step_s):
    time = SharedSteadyTime()
    assert [time.at(stamp_s) for stamp_s in (100.0, 99.98, 100.1)] == [100.0, 99.98, 100.1]
    assert time.at(100.2 + step_s) == pytest.approx(100.12)
    assert time.at(100.15) == pytest.approx(100.15)  # a late one of the clock before
    assert time.at(100.3 + step_s) == pytest.approx(100.22)


def test_a_clock_that_is_set_back_takes_the_shared_time_along():
    time = SharedSteadyTime()
    assert [time.at(stamp_s) for stamp_s in (100.0, 50.0, 50.1)] == [100.0, 50.0, 50.1]
