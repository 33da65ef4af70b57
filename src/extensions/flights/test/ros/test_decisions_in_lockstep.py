"""In lockstep the simulator waits for each decision, so a decision waits for nothing that it need not."""

from __future__ import annotations

import queue
import threading
from types import SimpleNamespace

import pytest

from flights.flight.course import Action

pytest.importorskip("rospy", reason="needs ROS")
flight_node = pytest.importorskip(
    "flights_ros.drivers.flight_node", reason="the workspace is not built, or not sourced"
)
driver = pytest.importorskip("flights_ros.goal_flight.driver")


@pytest.mark.parametrize(("has_begun", "slept"), [(False, [flight_node.UNSTAMPED_S]), (True, [])])
def test_only_the_start_waits_for_messages_without_a_stamp(monkeypatch, has_begun, slept):
    # Given a node that has heard every stamped message of the scan's instant
    node = object.__new__(driver.Experiment1Node)
    node._lock, node._finished, node._armed = threading.Lock(), False, None
    node._heard = threading.Condition(node._lock)
    node._monitor = SimpleNamespace(has_begun=has_begun, decide=lambda: [])
    monkeypatch.setattr(node, "_has_heard", lambda t_s: True, raising=False)
    node._setpoint_s = 3.0
    waits = []
    monkeypatch.setattr(flight_node.time, "sleep", waits.append)
    # When it decides, then it waits for `ready` before the start, and for nothing in flight
    assert node._decide_at(SimpleNamespace(stamp=SimpleNamespace(to_sec=lambda: 3.0))) is True
    assert waits == slept


def test_a_decision_to_land_waits_until_mavros_has_answered(monkeypatch):
    """Else the scan at which the UAV begins to land would depend on how busy the machine is."""
    # Given a MAVROS that answers when the test wants it
    asked, answer = threading.Event(), threading.Event()

    def set_mode(*_):
        asked.set()
        answer.wait(60.0)
        return SimpleNamespace(mode_sent=True)

    node = object.__new__(driver.Experiment1Node)
    node._lock, node._finished, node._armed = threading.Lock(), False, None
    node._heard, node._actions = threading.Condition(node._lock), queue.Queue()
    node._monitor = SimpleNamespace(has_begun=True, decide=lambda: [Action.LAND])
    node._set_mode, node._landing, node._carried_out = set_mode, "AUTO.LAND", threading.Semaphore(0)
    monkeypatch.setattr(node, "_has_heard", lambda t_s: True, raising=False)
    monkeypatch.setattr(flight_node, "SETTLE_S", 0.0)
    node._setpoint_s = 3.0
    header = SimpleNamespace(stamp=SimpleNamespace(to_sec=lambda: 3.0))
    decision = threading.Thread(target=node._decide_at, args=(header,), daemon=True)
    # When it decides to land, and its main thread carries that out
    decision.start()
    node._carry_out(node._actions.get(timeout=60.0))
    assert asked.wait(60.0)
    # Then it has not decided before the answer
    decision.join(0.3)
    assert decision.is_alive()
    answer.set()
    decision.join(60.0)
    assert not decision.is_alive()


def test_nothing_is_decided_before_the_setpoint_of_the_scan_s_instant(monkeypatch):
    """`ready` has no stamp, and comes before it; on a busy machine that is later than UNSTAMPED_S."""
    node = object.__new__(driver.Experiment1Node)
    node._lock, node._finished, node._armed = threading.Lock(), False, None
    node._heard = threading.Condition(node._lock)
    decided = threading.Event()
    node._monitor = SimpleNamespace(has_begun=False, decide=lambda: decided.set() or [])
    monkeypatch.setattr(node, "_has_heard", lambda t_s: True, raising=False)
    node._setpoint_s = 2.975
    header = SimpleNamespace(stamp=SimpleNamespace(to_sec=lambda: 3.0))
    decision = threading.Thread(target=node._decide_at, args=(header,), daemon=True)
    decision.start()
    assert not decided.wait(0.5)
    with node._heard:
        node._setpoint_s = 3.0
        node._heard.notify_all()
    assert decided.wait(60.0)
    decision.join(60.0)
