"""What a user asks for: numbers, choices and paths are taken, or refused in one sentence."""

from pathlib import Path

import pytest

from flights.errors import ScenarioError
from flights.worlds import scenario


@pytest.mark.table(("given", "expected"), [(3, 3), (3.0, 3), ("7", 7), (0, 0)])
def test_a_whole_number_is_taken_however_it_is_written(given, expected):
    value = scenario.whole_number("seed", given, *scenario.SEEDS)
    assert value == expected
    assert isinstance(value, int)


@pytest.mark.table("given", ["abc", 1.5, -1, 2**31, float("nan"), float("inf"), True, None, [1], ""])
def test_what_is_no_whole_number_is_refused(given):
    with pytest.raises(ScenarioError, match=r"' is no seed; give a whole number from 0 to 2147483647\."):
        scenario.whole_number("seed", given, *scenario.SEEDS)


@pytest.mark.table("given", ["abc", 0, -1.0, 15.1, float("nan"), True, None])
def test_what_is_no_speed_is_refused(given):
    with pytest.raises(ScenarioError, match=r"' is no speed; give a number from 0\.05 to 15\."):
        scenario.number("speed", given, *scenario.SPEEDS_M_S)


def test_a_speed_is_taken():
    assert scenario.number("speed", "0.5", *scenario.SPEEDS_M_S) == 0.5


def test_a_path_must_not_depend_on_where_a_node_runs():
    assert scenario.absolute("world", "/a/my.world") == Path("/a/my.world")
    sentence = r"world:=my\.world is not an absolute path; give one, for example world:=\$PWD/my\.world\."
    with pytest.raises(ScenarioError, match=sentence):
        scenario.absolute("world", "my.world")
    with pytest.raises(ScenarioError, match=r"for example world:=\$HOME/my\.world\."):
        scenario.absolute("world", "~/my.world")


def test_a_yaw_in_degrees_is_refused_with_its_radians():
    sentence = r"yaw is in radians, from -6\.28 to 6\.28; 90 degrees are 1\.571\."
    with pytest.raises(ScenarioError, match=sentence):
        scenario.place_and_yaw("start", "0 0 0 90")
    assert scenario.place_and_yaw("start", "0 0 0 -6.28") == (0.0, 0.0, 0.0, -6.28)


@pytest.mark.table("given", ["16 -4 1.2", "16,-4,1.2", "(16, -4, 1.2)", "[16, -4, 1.2]"])
def test_a_place_is_read_however_it_was_copied(given):
    assert scenario.place("goal", given) == (16.0, -4.0, 1.2)


@pytest.mark.table("given", ["ballast-tank", "/home/me/ballast-tank", "/worlds/none.world"])
def test_a_world_that_is_not_there_lists_the_names(given):
    with pytest.raises(
        ScenarioError, match=r"choose world:=hold_3d\|hold_3d_cargo\|ballast_tank, or the path"
    ):
        scenario.named_world(given)


def test_a_worlds_path_must_not_depend_on_where_a_node_runs():
    with pytest.raises(ScenarioError, match="is not an absolute path"):
        scenario.named_world("my.world")
