"""The ways home of `bench explore --rows way_home`, summed up. The values are counted by hand."""

import math

import pytest

from benchmarks.explore_rows.way_home import summary


def flight(reckoned_m, reckoned_s, flown_s, contact=False, up_m=0.0, down_m=0.0, flown_wh=1.0):
    wh = {"reckoned_wh": 1.0, "flown_wh": flown_wh}
    way = {"reckoned_m": reckoned_m, "up_m": up_m, "down_m": down_m}
    times = {"reckoned_s": reckoned_s, "flown_s": flown_s, "landing_s": 6.0}
    return {**way, **times, **wh, "contact": contact}


def test_a_way_is_longer_than_allowed_beyond_1_3_times_the_reckoned_time_and_8_s():
    found = summary([flight(9.0, 10.0, 21.0), flight(9.0, 10.0, 21.5), flight(9.0, 10.0, 5.0, contact=True)])
    assert (found["flights"], found["longer_than_allowed"], found["contacts"]) == (3, 1, 1)
    assert found["least_to_spare_s"] == pytest.approx(-0.5)
    assert found["longer_than_factor"] == 2
    assert (found["ratio_median"], found["ratio_greatest"]) == pytest.approx((2.1, 2.15))


def test_a_uav_that_did_not_come_home_or_had_no_way_counts_as_longer():
    found = summary([flight(9.0, 10.0, math.nan), flight(math.nan, math.nan, 4.0)])
    assert found["longer_than_allowed"] == 2
    assert math.isnan(found["ratio_greatest"])


def test_short_ways_do_not_count_for_the_ratio():
    found = summary([flight(1.0, 1.0, 9.0), flight(8.0, 10.0, 10.0)])
    assert (found["ways"], found["ratio_greatest"], found["longest_m"]) == (1, 1.0, 8.0)


def test_ways_up_and_down_and_the_energy_are_told_apart():
    found = summary([flight(8.0, 10.0, 11.0, up_m=5.0), flight(8.0, 10.0, 12.0, down_m=5.0, flown_wh=1.5)])
    assert (found["up_ratio_greatest"], found["down_ratio_greatest"]) == pytest.approx((1.1, 1.2))
    assert found["energy_ratio_greatest"] == 1.5
