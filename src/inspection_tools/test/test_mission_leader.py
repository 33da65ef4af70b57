"""A mission as the leader of an errand: where it sends the UAV, what it keeps, and how it ends."""

import numpy as np
import pytest

from flight_basics.errand.leader import Here
from flight_basics.errors import MissionError
from inspection_tools import Waypoint
from inspection_tools.mission.leader import MissionLeader

FIRST, SECOND = Waypoint((10.0, 0.0, 2.0), 1.0), Waypoint((10.0, 5.0, 2.0))


def at(stamp_s, *place_m):
    return Here(stamp_s, stamp_s, np.array(place_m))


@pytest.fixture
def leader():
    leader = MissionLeader(lambda goal: goal, patience_s=60.0)
    leader.begin(leader.prepare((FIRST, SECOND)), None, None)
    return leader


def test_one_setpoint_follows_the_other_and_what_is_done_is_kept(leader):
    leader.follow(at(0.0, 0.0, 0.0, 2.0))
    assert leader.setpoint == ((10.0, 0.0, 2.0), 1.0)
    before = leader.setpoint
    leader.follow(at(1.0, 5.0, 0.0, 2.0))
    assert leader.setpoint is before
    leader.follow(at(2.0, 9.9, 0.0, 2.0))
    assert leader.setpoint == ((10.0, 5.0, 2.0), None)
    assert leader.kept == {"reached": 1}
    assert leader.outcome() is None
    leader.follow(at(3.0, 10.0, 4.9, 2.0))
    assert (leader.outcome().end, leader.reached) == ("succeeded", 2)


def test_a_node_that_died_goes_on_after_what_is_done(leader):
    leader.begin((FIRST, SECOND), None, {"reached": 1})
    leader.follow(at(0.0, 0.0, 0.0, 2.0))
    assert leader.setpoint.position_m == SECOND.position_m


def test_a_cancelled_mission_holds_the_place_of_the_next_pose(leader):
    leader.follow(at(0.0, 0.0, 0.0, 2.0))
    leader.abort("")
    assert leader.outcome() is None
    leader.follow(at(0.1, 3.0, 1.0, 2.0))
    assert leader.setpoint == ((3.0, 1.0, 2.0), None)
    assert leader.outcome().end == "canceled"


def test_a_mission_that_stalls_holds_its_place(leader):
    for second in range(62):
        leader.follow(at(float(second), 1.0, 0.0, 2.0))
    assert leader.setpoint == ((1.0, 0.0, 2.0), None)
    assert leader.outcome().end == "aborted"
    assert leader.outcome().words == "The UAV has come no nearer to waypoint 1 of 2 for 60 s."


def test_another_goal_does_not_stop_the_uav_between(leader):
    leader.follow(at(0.0, 0.0, 0.0, 2.0))
    before = leader.setpoint
    leader.give_way()
    leader.follow(at(0.1, 1.0, 0.0, 2.0))
    assert leader.setpoint is before


def test_a_goal_without_waypoints_is_refused(leader):
    with pytest.raises(MissionError, match="no waypoints"):
        leader.prepare(())


@pytest.mark.parametrize(
    ("waypoints", "begins", "ends"),
    [
        ((FIRST,), "A mission of 1 waypoint begins.", "The waypoint is done."),
        ((FIRST, SECOND), "A mission of 2 waypoints begins.", "All 2 waypoints are done."),
    ],
)
def test_one_waypoint_is_told_as_one(leader, waypoints, begins, ends):
    assert leader.begin(waypoints, None, None) == begins
    for stamp_s, waypoint in enumerate(waypoints):
        leader.follow(at(float(stamp_s), *waypoint.position_m))
    assert leader.outcome().log == ends
