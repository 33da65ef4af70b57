"""Who is in charge of pos_setpoint: without a graph."""

from types import SimpleNamespace

import pytest

pytestmark = pytest.mark.ros

setpoints = pytest.importorskip("flight_basics_ros.setpoints", reason="needs ROS")

from geometry_msgs.msg import Point, Pose  # noqa: E402

from flight_basics.errors import ContradictionError  # noqa: E402

ME = "/position_controller"


def setpoint(sender, x=0.0, latching=False):
    pose = Pose(position=Point(x, 0.0, 2.0))
    pose._connection_header = {"callerid": sender, "latching": "1" if latching else "0"}
    return pose


@pytest.fixture
def graph(monkeypatch):
    """A master that knows some senders. `wall_s`: the time; `published`: all that was published."""
    graph = SimpleNamespace(senders=[], wall_s=0.0, published=[], parameters={}, name=ME)
    state = lambda: [[["/pos_setpoint", list(graph.senders)], ["/scan", ["/other"]]], [], []]  # noqa: E731
    publisher = SimpleNamespace(publish=graph.published.append)
    monkeypatch.setattr(
        setpoints.rosgraph, "Master", lambda _: SimpleNamespace(getSystemState=lambda: state())
    )
    monkeypatch.setattr(setpoints.time, "monotonic", lambda: graph.wall_s)
    fake = {
        "get_name": lambda: graph.name,
        "resolve_name": lambda name: f"/{name}",
        "Publisher": lambda *_, **__: publisher,
        "Subscriber": lambda *_, **__: None,
        "get_param": lambda name, default=None: graph.parameters.get(name, default),
        "set_param": graph.parameters.__setitem__,
    }
    for name, function in fake.items():
        monkeypatch.setattr(setpoints.rospy, name, function)
    return graph


def newcomer(sender):
    """What a new listener gets."""
    got = []
    sender.peer_subscribe("/pos_setpoint", "/new", got.append)
    return [pose.position.x for pose in got]


def test_a_sender_is_in_charge_until_another_one_sends(graph):
    sender = setpoints.SetpointSender()
    assert newcomer(sender) == []
    sender.send(setpoint(ME, 1.0))
    assert [pose.position.x for pose in graph.published] == [1.0]
    sender._on_setpoint(setpoint(ME, 1.0))  # it hears itself
    assert newcomer(sender) == [1.0]
    sender._on_setpoint(setpoint("/explore", 5.0))
    assert newcomer(sender) == []
    sender.send(setpoint(ME, 2.0))
    assert newcomer(sender) == [2.0]


def test_what_others_had_sent_before_the_start_takes_no_charge(graph):
    graph.senders = ["/explore", ME]
    sender = setpoints.SetpointSender()
    sender.send(setpoint(ME, 1.0))
    sender._on_setpoint(setpoint("/explore", 5.0))
    assert newcomer(sender) == [1.0]
    sender._on_setpoint(setpoint("/explore", 6.0))
    assert newcomer(sender) == []


def test_a_sender_that_was_silent_for_long_takes_charge(graph):
    graph.senders = ["/explore"]
    sender = setpoints.SetpointSender()
    graph.wall_s = setpoints.FIRST_S + 0.1
    sender.send(setpoint(ME, 1.0))
    sender._on_setpoint(setpoint("/explore", 5.0))
    assert newcomer(sender) == []


@pytest.mark.parametrize("order", [("/old", "/new"), ("/new", "/old")])
def test_a_listener_that_died_obeys_whom_it_obeyed(graph, order):
    graph.senders = ["/old", "/new"]
    before = setpoints.SetpointsInCharge()
    graph.wall_s = 60.0
    assert before.count(setpoint("/old", latching=True))
    assert before.count(setpoint("/new", latching=True))
    again = setpoints.SetpointsInCharge()
    obeyed = [sender for sender in order if again.count(setpoint(sender, latching=True))]
    assert obeyed == ["/new"]
    assert again.count(setpoint("/old", latching=True))  # a new one


@pytest.mark.parametrize("order", [("/latches", "/explore"), ("/explore", "/latches")])
def test_a_sender_in_charge_counts_and_one_that_latches_does_not(graph, order):
    graph.senders = ["/latches", "/explore"]
    listener = setpoints.SetpointsInCharge()
    obeyed = [s for s in order if listener.count(setpoint(s, latching=s == "/latches"))]
    assert obeyed[-1] == "/explore"


def test_two_latched_setpoints_from_before_the_first_start_contradict_each_other(graph):
    graph.senders = ["/one", "/two"]
    listener = setpoints.SetpointsInCharge()
    assert listener.count(setpoint("/one", latching=True))
    with pytest.raises(ContradictionError, match="/one and /two"):
        listener.count(setpoint("/two", latching=True))
    assert listener.count(setpoint("/two", latching=True))  # sent again


def test_a_sender_that_starts_later_is_obeyed_at_once(graph):
    graph.senders = ["/one"]
    listener = setpoints.SetpointsInCharge()
    assert listener.count(setpoint("/one", latching=True))
    assert listener.count(setpoint("/later", latching=True))
