"""A goal waits for what is missing, and for the battery of a UAV whose pose is known longer."""

import time

import pytest

new_goal = pytest.importorskip("flight_basics_ros.new_goal", reason="needs the workspace's environment")


@pytest.mark.parametrize(
    ("missing", "left_s", "longer_s", "is_due"),
    [
        ("", 10.0, 15.0, True),
        ("The place is not known yet.", 10.0, 0.0, False),
        ("The place is not known yet.", -1.0, 0.0, True),
        ("The battery has told nothing yet.", -1.0, 15.0, False),
        ("The battery has told nothing yet.", -16.0, 15.0, True),
    ],
)
def test_a_goal_is_answered_when_nothing_is_missing_or_its_time_is_over(missing, left_s, longer_s, is_due):
    goal = new_goal.NewGoal(None, "x", time.monotonic() + left_s)
    assert goal.is_due(missing, longer_s) is is_due
