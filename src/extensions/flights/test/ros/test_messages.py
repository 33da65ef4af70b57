"""What ROS messages become in a flight's log; messages that are no poses are refused, not recorded."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

messages = pytest.importorskip("flights_ros.drivers.messages", reason="needs the workspace's environment")


def pose(x=1.0, y=2.0, z=3.0, qw=1.0):
    return SimpleNamespace(
        position=SimpleNamespace(x=x, y=y, z=z), orientation=SimpleNamespace(x=0.0, y=0.0, z=0.0, w=qw)
    )


def test_a_pose_is_its_position_and_quaternion():
    assert messages.pose_values(pose()) == (1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("bad", [{"x": 1e300}, {"y": -math.inf}, {"z": math.nan}, {"qw": math.nan}])
def test_a_pose_beyond_every_world_is_refused(bad):
    with pytest.raises(ValueError, match="it lies at"):
        messages.pose_values(pose(**bad))


@pytest.mark.parametrize(("told", "counts"), [({"cpu_time_ms": "3.1"}, 3.1), ({}, 7.5)])
def test_a_decision_has_its_processor_time_or_else_how_long_it_took(told, counts):
    values = {
        **{"computation_time_ms": "7.5", "directions_tested": "195", "cost": "-0.3"},
        **{"emergency": "False", "reason": "steered", **told},
    }
    status = SimpleNamespace(values=[SimpleNamespace(key=key, value=value) for key, value in values.items()])
    stamp = SimpleNamespace(to_sec=lambda: 1.5)
    message = SimpleNamespace(header=SimpleNamespace(stamp=stamp), status=[status])
    assert messages.decision_rows(message) == [(1.5, counts, 195, -0.3, False, "steered")]
