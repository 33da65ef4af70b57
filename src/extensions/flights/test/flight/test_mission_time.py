"""When the time of a mission is over, node and closed loop do the same."""

import math

import pytest

from flights.flight.mission_time import MissionTime, TimeIsOver


@pytest.mark.table(
    ("time", "flying_s", "flies_home", "expected"),
    [
        (MissionTime(10.0), 9.9, False, None),
        (MissionTime(10.0), 10.0, False, TimeIsOver.END_HERE),
        (MissionTime(10.0, returns=True), 10.0, False, TimeIsOver.FLY_HOME),
        (MissionTime(10.0, returns=True), 99.0, True, None),  # it is on its way
        (MissionTime(math.inf), 1e6, False, None),
    ],
)
def test_the_end_by_time(time, flying_s, flies_home, expected):
    assert time.over(flying_s, flies_home) is expected


def test_a_mission_says_when_its_time_is_over():
    time = MissionTime(240.0, returns=True)
    assert time.left_in_words(62.4, flies_home=False) == "; its time is over in 178 s"
    assert time.left_in_words(241.0, flies_home=False) == "; its time is over in 0 s"
    assert time.left_in_words(241.0, flies_home=True) == ""
    assert MissionTime(math.inf).left_in_words(62.4, flies_home=False) == ""
