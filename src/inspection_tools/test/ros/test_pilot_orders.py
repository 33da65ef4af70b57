"""A pilot's orders reach whoever leads the UAV, and an empty battery lands it."""

from __future__ import annotations

import threading
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("flight_basics_ros.pose_source", reason="needs the workspace's environment")

from geometry_msgs.msg import Point
from inspection_tools_ros import leaders

from inspection_tools.charge_thresholds import ChargeWatch
from inspection_tools.pilot_buttons import Order, PilotButtons
from node_tools import ending, services


def kept_parameter():
    """A parameter that outlives the node."""
    kept = SimpleNamespace(values={})
    kept.keep = lambda values: setattr(kept, "values", dict(values))
    return kept


NODE = Path(__file__).resolve().parents[2] / "nodes/pilot_orders"


@pytest.fixture(scope="module")
def program():
    """The node's program as a module.

    Its `Ending` would block SIGINT and SIGTERM in the process that runs the tests, and in all that it starts.
    """
    loader = SourceFileLoader("pilot_orders", str(NODE))
    module = module_from_spec(spec_from_loader("pilot_orders", loader))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ending, "Ending", SimpleNamespace)
        loader.exec_module(module)
    return module


@pytest.fixture
def node(program, monkeypatch):
    """A node whose services and topics are lists: what it called, what it sent."""
    made = object.__new__(program.PilotOrders)
    made.leaders, made.called, made.sent, made.kept = {}, [], [], kept_parameter()

    def service(name, _kind):
        def call():
            made.called.append(name)
            leader = name.split("/")[1]
            if leader not in made.leaders:
                raise services.NoServiceError("there is no such service")
            if made.leaders[leader] is None:
                raise program.rospy.ServiceException("it gave no answer within 5 s")
            return SimpleNamespace(success=made.leaders[leader], message=f"{leader} says so.")

        return call

    def set_mode(_base, mode):
        made.called.append(mode)
        return SimpleNamespace(mode_sent=True)

    monkeypatch.setattr(leaders, "ServiceCall", service)
    monkeypatch.setattr(leaders.time, "monotonic", lambda: made.wall_s)
    made.wall_s = 0.0
    for say in ("loginfo", "logwarn", "logerr"):
        monkeypatch.setattr(program.rospy, say, lambda *_: None)
    made._lock, made._landing_mode, made._steers = threading.RLock(), "AUTO.LAND", True
    made._watch, made._buttons, made._set_mode = ChargeWatch(), PilotButtons(), set_mode
    made._flight = made.kept
    made._here, made._goal = Point(0.0, 0.0, 2.0), Point(9.0, 0.0, 2.0)
    made._on_ready(SimpleNamespace(data=True))
    made._here, made._is_armed = Point(4.0, 0.0, 2.0), True
    made._leaders = leaders.Leaders(on_change=lambda name: made._keep("leads", name))
    made._on_status = made._leaders.note
    made._setpoints = SimpleNamespace(send=lambda pose: made.sent.append(pose.position.x))
    made._in_background = lambda order: made._on_order(order, None)
    return made


@pytest.mark.parametrize(
    ("order", "service"),
    [(Order.PAUSE, "pause"), (Order.RESUME, "resume"), (Order.HOME, "abort")],
)
def test_the_node_that_leads_gets_the_order(node, order, service):
    node.leaders = {"inspect": True}
    answer = node._on_order(order, None)
    assert (answer.success, answer.message) == (True, "inspect says so.")
    assert node.called == [f"/explore/{service}", f"/inspect/{service}"]
    assert node.sent == []


def statuses(*codes):
    return SimpleNamespace(status_list=[SimpleNamespace(status=code) for code in codes])


def test_a_refusal_is_passed_on_and_no_setpoint_disturbs_a_leader(node):
    node.leaders = {"explore": False}
    node._on_status("explore", statuses(3, 1))
    assert not node._on_order(Order.HOME, None).success
    assert node.sent == []


def test_nodes_that_wait_for_an_order_do_not_refuse_those_by_setpoints(node):
    node.leaders = {"explore": False, "inspect": False}
    node._on_status("explore", statuses(1))
    node._on_status("explore", statuses(3))  # its exploration has ended
    for order in (Order.PAUSE, Order.RESUME, Order.HOME):
        assert node._on_order(order, None).success
    assert node.sent == [4.0, 9.0, 0.0]


def test_a_second_order_to_explore_does_not_begin_anew(node):
    begun = []
    node._begins = {"explore": SimpleNamespace(get_num_connections=lambda: 1, publish=begun.append)}
    node._time_max_s = 600.0
    assert not node._begin_to_explore().success  # it may lead already: nothing was heard of it
    node._on_status("explore", statuses())
    assert node._begin_to_explore().success
    node._on_status("explore", statuses(1))
    answer = node._begin_to_explore()
    assert (answer.success, answer.message.split(";")[0]) == (False, "The node explore leads already")
    assert len(begun) == 1


@pytest.mark.parametrize("is_known", [True, False])
def test_a_leader_that_is_silent_leads_all_the_same(node, is_known):
    if is_known:
        node._on_status("explore", statuses(1))
    node.leaders = {"explore": None}
    node.wall_s = 3600.0
    answer = node._on_order(Order.HOME, None)
    assert not answer.success
    assert "explore" in answer.message
    assert node.sent == []


def test_a_leader_that_died_goes_on_when_it_has_started_again_and_then_is_asked(node):
    node._on_status("inspect", statuses(1))
    assert not node._on_order(Order.HOME, None).success  # its node is gone, but not for long
    node.leaders = {"inspect": False}
    node._on_status("inspect", statuses())  # it has started again, and got no goal
    assert node._on_order(Order.HOME, None).success
    assert node.sent == [0.0]


def test_a_leader_that_is_gone_for_long_leads_no_more(node):
    node._on_status("inspect", statuses(1))
    node.wall_s = leaders.RESTART_S + 1.0
    assert node._on_order(Order.HOME, None).success
    assert node.sent == [0.0]


def test_a_node_that_starts_again_in_flight_knows_home_goal_and_leader(program, node):
    node._on_status("explore", statuses(1))
    node._on_status("explore", statuses(3))
    assert node._on_order(Order.PAUSE, None).success
    again = object.__new__(program.PilotOrders)
    again.__dict__.update(node.__dict__)
    again._goal, again._here, again._is_armed = None, Point(20.0, 0.0, 2.0), None
    again._on_ready(SimpleNamespace(data=True))  # it is latched
    again._on_state(SimpleNamespace(armed=True))
    for order in (Order.RESUME, Order.HOME):
        assert again._on_order(order, None).success
    assert node.sent == [4.0, 9.0, 0.0]
    node._on_status("explore", statuses(1))
    assert leaders.Leaders(node.kept.values["leads"]).leading == "explore"
    again._on_state(SimpleNamespace(armed=False))  # the next flight has another home
    again._on_ready(SimpleNamespace(data=True))
    assert again._place("home") == Point(20.0, 0.0, 2.0)


def test_home_is_a_place_of_one_map(node):
    for name in ("one", "one"):
        node._on_map_id(SimpleNamespace(data=name))
    assert node._on_order(Order.HOME, None).success
    node._on_map_id(SimpleNamespace(data="two"))
    assert not node._on_order(Order.HOME, None).success


def test_without_a_leader_it_hovers_goes_on_and_comes_home_by_setpoints(node):
    for order in (Order.PAUSE, Order.RESUME, Order.HOME):
        assert node._on_order(order, None).success
    assert node.sent == [4.0, 9.0, 0.0]


def test_where_a_pilot_steers_it_sends_no_setpoint_but_lands(node):
    node._steers = False
    assert not node._on_order(Order.HOME, None).success
    assert node._on_order(Order.LAND, None).success
    assert (node.sent, node.called[-1]) == ([], "AUTO.LAND")


def test_an_empty_battery_lands_the_uav_once_and_only_in_flight(node):
    for percent in (0.5, 0.06, 0.06, 0.04, 0.04, 0.04):
        node._on_battery(SimpleNamespace(percentage=percent))
    assert node.called == ["AUTO.LAND"]
    node._on_state(SimpleNamespace(armed=False))
    node._on_battery(SimpleNamespace(percentage=0.04))
    node._on_battery(SimpleNamespace(percentage=0.04))
    assert node.called == ["AUTO.LAND"]


def test_a_button_lands(node):
    node._on_joy(SimpleNamespace(buttons=(0, 0, 0, 0)))
    node._on_joy(SimpleNamespace(buttons=(0, 0, 1, 0)))
    assert node.called == ["AUTO.LAND"]


@pytest.mark.parametrize(
    ("status", "end", "lands"), [(3, "explored", True), (4, "", False), (3, "searching", False)]
)
def test_it_lands_when_the_errand_is_over(node, status, end, lands):
    result = SimpleNamespace(end=end, reason="Nothing is unknown.")
    node._on_result(SimpleNamespace(status=SimpleNamespace(status=status), result=result))
    assert node.called == (["AUTO.LAND"] if lands else [])
