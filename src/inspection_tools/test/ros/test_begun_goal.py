"""Which goal is the same after a restart, and which only looks like it: without a graph."""

from types import SimpleNamespace

import pytest

pytestmark = pytest.mark.ros

begun_goal = pytest.importorskip("flight_basics_ros.begun_goal", reason="needs ROS")
rospy = pytest.importorskip("rospy")

from geometry_msgs.msg import Point, Pose  # noqa: E402

from inspection_tools.msg import MissionActionGoal  # noqa: E402
from node_tools.restarts import kept_parameter  # noqa: E402


def goal(name="one", places=((1.0, 2.0, 3.0),), sender="/planner", stamp_s=5.0):
    message = MissionActionGoal()
    message.goal_id.id, message.header.stamp = name, rospy.Time(stamp_s)
    message.goal.waypoints = [Pose(position=Point(*place)) for place in places]
    message._connection_header = {"callerid": sender}
    return SimpleNamespace(goal=message)


@pytest.fixture(autouse=True)
def master(monkeypatch):
    """A master with parameters, and addresses of its nodes."""
    parameters, addresses = {}, {"/planner": "http://robot:1/", "/console": "http://robot:2/"}
    lookup = SimpleNamespace(lookupNode=addresses.__getitem__)
    monkeypatch.setattr(begun_goal.rosgraph, "Master", lambda _: lookup)
    monkeypatch.setattr(begun_goal.rospy, "get_name", lambda: "/mission")
    fake = {
        "get_param": lambda name, default=None: parameters.get(name, default),
        "set_param": parameters.__setitem__,
        "on_shutdown": lambda _: None,
    }
    for name, function in fake.items():
        monkeypatch.setattr(kept_parameter.rospy, name, function)
    return addresses


def begun():
    return begun_goal.begun_goal(SimpleNamespace(received=False))


def test_a_latched_goal_that_comes_again_is_the_same():
    again = goal()
    again.goal.header.seq = 7  # rospy counts what it sends
    again.goal.goal_id.stamp = rospy.Time(9.0)  # actionlib has set it
    assert begun_goal.identity_of(goal()) == begun_goal.identity_of(again)


@pytest.mark.parametrize(
    "other", [{"name": "two"}, {"places": ((1.0, 2.0, 4.0),)}, {"sender": "/console"}, {"stamp_s": 6.0}]
)
def test_a_goal_of_another_name_content_sender_or_time_is_another_one(other):
    assert begun_goal.identity_of(goal()) != begun_goal.identity_of(goal(**other))


def test_a_goal_of_a_sender_that_has_started_again_is_another_one(master):
    before = begun_goal.identity_of(goal())
    master["/planner"] = "http://robot:3/"
    assert begun_goal.identity_of(goal()) != before


def test_what_the_goal_s_file_holds_counts():
    assert begun_goal.identity_of(goal(), "a mission") != begun_goal.identity_of(goal(), "an edited one")


def test_a_node_that_died_goes_on_with_what_is_flown_and_not_with_what_has_ended():
    first = begun()
    first.begin("one", {"home": [1.0, 2.0, 3.0]})
    first.keep({"reached": 2})
    again = begun()
    assert again.flown == "one"
    assert not again.had_ended("one")
    assert (again.known["home"], again.known["reached"]) == ([1.0, 2.0, 3.0], 2)
    again.end()
    assert again.flown == ""
    assert not again.had_ended("one")  # its sender may mean it
    assert begun().had_ended("one")
