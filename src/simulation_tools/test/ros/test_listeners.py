"""A node that must end waits for the one that writes down why."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("rospy", reason="needs ROS")

from simulation_tools_ros.gazebo import listeners


@pytest.fixture
def connections(monkeypatch):
    """Connections of this process's topics, which a test may change; 0.1 s pass with each look."""
    found, clock = [], iter(range(10_000))
    monkeypatch.setattr(
        listeners, "get_topic_manager", lambda: SimpleNamespace(get_pub_sub_info=lambda: list(found))
    )
    monkeypatch.setattr(listeners.rospy, "resolve_name", lambda name: f"/{name}")
    monkeypatch.setattr(listeners.time, "monotonic", lambda: 0.1 * next(clock))
    monkeypatch.setattr(listeners.rospy.rostime, "wallsleep", lambda _: None)
    return found


def connection(node, topic="/rosout"):
    return (3, node, "o", "TCPROS", topic, True, "")


def test_it_waits_until_the_other_node_is_connected_to_rosout(connections):
    connections += [connection("/rosout"), connection("/experiment", "/clock")]
    looks = iter([False, False, True])

    def stop():
        if next(looks):
            connections.append(connection("/experiment"))
        return False

    assert listeners.wait_for_listener("experiment", stop)
    assert next(looks, "all looks were needed") == "all looks were needed"


def test_it_does_not_wait_for_ever_nor_after_an_order_to_end(connections):
    assert not listeners.wait_for_listener("experiment", lambda: False, patience_s=2.0)
    assert not listeners.wait_for_listener("experiment", lambda: True)
