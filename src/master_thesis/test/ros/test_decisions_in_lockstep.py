"""In lockstep the simulator waits for each decision, so a decision waits for nothing that it need not."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy", reason="needs ROS")
flight_node = pytest.importorskip(
    "master_thesis_ros.experiments.flight_node", reason="the workspace is not built, or not sourced"
)
driver = pytest.importorskip("master_thesis_ros.experiment_1.driver")


@pytest.mark.parametrize(("has_begun", "slept"), [(False, [flight_node.UNSTAMPED_S]), (True, [])])
def test_only_the_start_waits_for_messages_without_a_stamp(monkeypatch, has_begun, slept):
    # Given a node that has heard every stamped message of the scan's instant
    node = object.__new__(driver.Experiment1Node)
    node._lock, node._finished, node._armed = threading.Lock(), False, None
    node._heard = threading.Condition(node._lock)
    node._monitor = SimpleNamespace(has_begun=has_begun, decide=lambda: [])
    monkeypatch.setattr(node, "_has_heard", lambda t_s: True, raising=False)
    waits = []
    monkeypatch.setattr(flight_node.time, "sleep", waits.append)
    # When it decides, then it waits for `ready` before the start, and for nothing in flight
    assert node._decide_at(SimpleNamespace(stamp=SimpleNamespace(to_sec=lambda: 3.0))) is True
    assert waits == slept
