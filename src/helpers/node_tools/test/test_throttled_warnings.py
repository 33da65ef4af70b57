"""When and how often a fault is told."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.ros

throttled_warnings = pytest.importorskip(
    "node_tools.throttled_warnings", reason="needs the workspace's environment: source devel/setup.bash"
)


def test_a_fault_is_told_every_5_s_of_wall_time_whatever_the_clock_does(monkeypatch):
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


class Told:
    """What is logged of faults, each with the time in s at which it comes."""

    def __init__(self, monkeypatch):
        self.now_s, self.sentences = 0.0, []
        monkeypatch.setattr(throttled_warnings.time, "monotonic", lambda: self.now_s)
        monkeypatch.setattr(throttled_warnings.rospy, "get_time", lambda: self.now_s)
        monkeypatch.setattr(
            throttled_warnings.rospy, "logwarn", lambda _, sentence: self.sentences.append(sentence)
        )
        self.warnings = throttled_warnings.ThrottledWarnings()

    def lasting(self, *times_s):
        """A fault at each time, as a node tells it that others may mend."""
        self.sentences.clear()
        for self.now_s in times_s:
            self.warnings.say_if_it_lasts(f"no transform for {self.now_s:g} s")
        return self.sentences


@pytest.fixture
def told(monkeypatch):
    return Told(monkeypatch)


def test_sentences_that_differ_in_numbers_are_one_fault(told):
    for told.now_s, number in ((0.0, "0"), (0.1, "0.028"), (0.2, "12.5")):
        told.warnings.say(f"no transform for {number} s")
    assert told.sentences == ["no transform for 0 s"]


def test_what_the_start_mends_is_not_told(told):
    assert told.lasting(0.0, 0.0, 0.028, 0.9) == []


def test_what_lasts_is_told_once_in_five_seconds(told):
    times_s = [0.5 * i for i in range(16)]
    assert told.lasting(*times_s) == ["no transform for 1 s", "no transform for 6 s"]


def test_what_comes_now_and_then_does_not_last(told):
    assert told.lasting(0.0, 2.0, 4.0, 6.0) == []


def test_a_clock_that_jumps_back_begins_anew(told):
    assert told.lasting(100.0, 0.0, 0.9) == []
    assert told.lasting(1.0) == ["no transform for 1 s"]
