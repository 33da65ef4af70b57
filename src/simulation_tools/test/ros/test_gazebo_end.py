"""How the simulator's node ends with an error."""

from __future__ import annotations

import pytest

pytest.importorskip("rospy", reason="needs ROS")

from simulation_tools.autopilot import AutopilotError
from simulation_tools_ros.gazebo import heard_end


@pytest.mark.parametrize(
    ("heard_by", "has_begun", "waited"),
    [("experiment", False, ["experiment"]), ("", False, []), ("experiment", True, [])],
    ids=["an experiment", "the simulator alone", "in flight"],
)
def test_an_error_that_comes_at_once_waits_for_who_writes_it_down(monkeypatch, heard_by, has_begun, waited):
    """ArduPilot's program ended before explore's driver had started, and no result was left."""
    done = []

    def fail(_should_stop):
        raise AutopilotError("ArduPilot has ended.")

    monkeypatch.setattr(heard_end.rospy, "get_param", lambda name, default: heard_by)
    monkeypatch.setattr(heard_end, "wait_for_listener", lambda name, should_stop: done.append(name))
    with pytest.raises(AutopilotError):
        heard_end.run_heard(fail, lambda: False, lambda: has_begun)
    assert done == waited
