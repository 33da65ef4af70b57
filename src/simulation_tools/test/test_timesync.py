"""The filter of clock offsets, on clocks whose offset is known."""

from __future__ import annotations

import pytest

from simulation_tools.timesync import ClockOffset, TimesyncParameters

MS = 1_000_000


def exchange(clock, now_ns, offset_ns, way_out_ns=MS, way_back_ns=MS):
    """An exchange that leaves at now_ns; the remote clock is ours less the offset."""
    return clock.add(now_ns, now_ns + way_out_ns - offset_ns, now_ns + way_out_ns + way_back_ns)


def test_an_exchange_with_equal_ways_tells_the_offset():
    observation = exchange(ClockOffset(), 10**9, 123_456_789)
    assert observation.observed_offset_ns == 123_456_789
    assert observation.estimated_offset_ns == 123_456_789  # the first one counts alone
    assert observation.round_trip_ns == 2 * MS
    assert observation.remote_ns == 10**9 + MS - 123_456_789


def test_it_converges_although_the_ways_differ():
    """Each observation errs by half of (way back - way out): here by 0, -0.5 and -1 ms in turn."""
    clock, offset_ns = ClockOffset(), 5_000 * MS
    for i in range(2000):
        observation = exchange(clock, 10**9 + 100 * MS * i, offset_ns, way_out_ns=MS + (i % 3) * MS)
    assert observation.estimated_offset_ns - offset_ns == pytest.approx(-0.5 * MS, abs=0.2 * MS)


def test_what_was_under_way_too_long_does_not_count():
    clock = ClockOffset()
    exchange(clock, 10**9, 7 * MS)
    late = exchange(clock, 2 * 10**9, 900 * MS, way_out_ns=9 * MS, way_back_ns=2 * MS)
    assert late.estimated_offset_ns == 7 * MS
    assert late.round_trip_ns == 11 * MS


def test_a_clock_that_jumps_is_believed_after_some_exchanges():
    clock = ClockOffset(TimesyncParameters(convergence_window=20))
    for i in range(30):
        exchange(clock, 10**9 + 100 * MS * i, 0)
    jumped = [exchange(clock, 5 * 10**9 + 100 * MS * i, 800 * MS).estimated_offset_ns for i in range(8)]
    assert jumped[:5] == pytest.approx([0] * 5, abs=MS)  # five contradictions are not believed
    assert jumped[-1] == pytest.approx(800 * MS, abs=MS)
