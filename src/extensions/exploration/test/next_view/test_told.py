"""What an exploration tells of its height."""

import math

import pytest

from exploration.next_view import Explored


@pytest.mark.table("untold", [math.nan, math.inf, -1.0, 1e4])
def test_a_height_that_nobody_tells_is_neither_known_nor_wrong(untold):
    explored = Explored()
    assert explored.note_height(untold) == ""
    assert math.isnan(explored.height_uncertain_m)
    assert explored.height_words == ""


def test_the_greatest_standard_deviation_stays_and_is_said_beyond_the_limit():
    explored = Explored()
    assert explored.note_height(0.02) == explored.note_height(0.3) == ""
    assert (explored.height_uncertain_m, explored.height_words) == (0.3, "")
    assert "its standard deviation is 0.8 m" in explored.note_height(0.8)
    assert explored.note_height(0.1) == ""
    assert explored.height_uncertain_m == 0.8
    assert "its standard deviation reached 0.8 m" in explored.height_words
