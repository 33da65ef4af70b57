"""How often a fault is told."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.ros

throttled_warnings = pytest.importorskip(
    "node_tools.throttled_warnings", reason="needs the workspace's environment: source devel/setup.bash"
)


def test_a_fault_is_told_every_5_s_of_wall_time_even_if_the_clock_jumps_to_and_fro(monkeypatch):
    """Two simulators publish /clock: each message of the other one is a jump back."""
    wall_s, said = [0.0], []
    monkeypatch.setattr(throttled_warnings.time, "monotonic", lambda: wall_s[0])
    monkeypatch.setattr(throttled_warnings.rospy, "logwarn", lambda form, *words: said.append(form % words))
    # ROS time: at one simulator 100 s, at the other 7 s
    monkeypatch.setattr(throttled_warnings.rospy, "get_time", lambda: (100.0, 7.0)[round(wall_s[0] * 10) % 2])
    warnings = throttled_warnings.ThrottledWarnings()
    for tenth in range(100):
        wall_s[0] = 0.1 * tenth
        warnings.say(f"The clock jumped back by {93 + 0.1 * tenth:.3f} s; starting anew.")
    assert len(said) == 2


def test_each_fault_is_told_on_its_own(monkeypatch):
    said = []
    monkeypatch.setattr(throttled_warnings.rospy, "logwarn", lambda form, *words: said.append(form % words))
    warnings = throttled_warnings.ThrottledWarnings()
    for sentence in ("A scan of 3 beams is dropped.", "A scan of 4 beams is dropped.", "A pose is dropped."):
        warnings.say(sentence)
    assert said == ["A scan of 3 beams is dropped.", "A pose is dropped."]
