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

from inspection_tools.charge_thresholds import ChargeWatch
from inspection_tools.pilot_buttons import Order, PilotButtons
from node_tools import ending

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
    made.leaders, made.called, made.sent = {}, [], []

    def service(name, _kind):
        def call():
            made.called.append(name)
            leader = name.split("/")[1]
            if leader not in made.leaders:
                raise program.rospy.ServiceException("there is no such service")
            return SimpleNamespace(success=made.leaders[leader], message=f"{leader} says so.")

        return call

    def set_mode(_base, mode):
        made.called.append(mode)
        return SimpleNamespace(mode_sent=True)

    monkeypatch.setattr(program, "ServiceCall", service)
    for say in ("loginfo", "logwarn", "logerr"):
        monkeypatch.setattr(program.rospy, say, lambda *_: None)
    made._lock, made._landing_mode, made._steers = threading.RLock(), "AUTO.LAND", True
    made._watch, made._buttons, made._set_mode = ChargeWatch(), PilotButtons(), set_mode
    made._here, made._home, made._goal = Point(4.0, 0.0, 2.0), Point(0.0, 0.0, 2.0), Point(9.0, 0.0, 2.0)
    made._is_armed, made._leading = True, {"explore": False, "inspect": False}
    made._setpoints = SimpleNamespace(publish=lambda pose: made.sent.append(pose.position.x))
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
    node._explore = SimpleNamespace(get_num_connections=lambda: 1, publish=begun.append)
    node._time_max_s = 600.0
    assert node._begin_to_explore().success
    node._on_status("explore", statuses(1))
    answer = node._begin_to_explore()
    assert (answer.success, answer.message.split(";")[0]) == (False, "The node explore leads already")
    assert len(begun) == 1


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
