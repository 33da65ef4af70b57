"""The ways home of `bench explore --rows way_home`, summed up. The values are counted by hand."""

import math

import pytest

from benchmarks.explore_rows.way_home import summary


def flight(reckoned_m, reckoned_s, flown_s, contact=False):
    return {"reckoned_m": reckoned_m, "reckoned_s": reckoned_s, "flown_s": flown_s, "contact": contact}


def test_a_way_is_longer_than_allowed_beyond_1_3_times_the_reckoned_time_and_10_s_for_the_landing():
    found = summary([flight(9.0, 10.0, 23.0), flight(9.0, 10.0, 23.1), flight(9.0, 10.0, 5.0, contact=True)])
    assert (found["flights"], found["longer_than_allowed"], found["contacts"]) == (3, 1, 1)
    assert (found["ratio_median"], found["ratio_greatest"]) == pytest.approx((2.3, 2.31))


def test_a_uav_that_did_not_come_home_or_had_no_way_counts_as_longer():
    found = summary([flight(9.0, 10.0, math.nan), flight(math.nan, math.nan, 4.0)])
    assert found["longer_than_allowed"] == 2
    assert math.isnan(found["ratio_greatest"])


def test_short_ways_do_not_count_for_the_ratio():
    found = summary([flight(1.0, 1.0, 9.0), flight(8.0, 10.0, 10.0)])
    assert (found["ways"], found["ratio_greatest"], found["longest_m"]) == (1, 1.0, 8.0)
