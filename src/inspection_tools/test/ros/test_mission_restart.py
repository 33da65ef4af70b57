"""A mission node that is killed in flight goes on where it was when roslaunch has started it again."""

from __future__ import annotations

import queue
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("rosgraph", reason="needs ROS")

FOLDER = Path(__file__).resolve().parent
START = "0 0 2"
FIRST, SECOND = "10 0 2", "10 5 2"  # of mission.yaml
PATIENCE_S = 200.0

pytestmark = pytest.mark.ros


class Flight:
    """A mission node, and a probe that sends it a latched goal and is where it is told to be."""

    def __init__(self, master):
        self._master = master
        self.start_node()
        self.start_probe()

    def start_node(self):
        file = f"_file:={FOLDER / 'mission.yaml'}"
        self._node = self._master.start_node("inspection_tools", "mission", "__name:=mission", file)

    def start_probe(self):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self._probe = self._master.start(sys.executable, str(FOLDER / "mission_probe.py"), **pipes)
        self._setpoints: queue.Queue = queue.Queue()
        lines, setpoints = self._probe.stdout, self._setpoints
        threading.Thread(target=lambda: [setpoints.put(line.strip()) for line in lines], daemon=True).start()

    def setpoint(self):
        """The next one."""
        return self._setpoints.get(timeout=PATIENCE_S)

    def setpoint_after(self, last):
        """The next one that is another: a listener that the node finds late gets the last one twice."""
        while (setpoint := self.setpoint()) == last:
            pass
        return setpoint

    def be_at(self, place):
        self._probe.stdin.write(place + "\n")
        self._probe.stdin.flush()

    def end_node(self, how):
        self._node.send_signal(how)
        self._node.wait(PATIENCE_S)

    def end_probe(self):
        self._probe.stdin.close()
        self._probe.wait(PATIENCE_S)


@pytest.fixture
def flight(ros_master):
    """A UAV that has reached the first of two waypoints, and was blown away from there since."""
    flight = Flight(ros_master)
    assert flight.setpoint() == FIRST
    flight.be_at(FIRST)
    assert flight.setpoint_after(FIRST) == SECOND
    flight.be_at(START)
    return flight


def test_a_node_that_was_killed_goes_on_after_the_reached_waypoints(flight):
    flight.end_node(signal.SIGKILL)
    flight.start_node()  # it hears of the same goal, which is latched
    assert flight.setpoint() == SECOND


def test_a_node_that_was_told_to_end_begins_at_the_first_waypoint(flight):
    flight.end_node(signal.SIGTERM)
    flight.start_node()
    assert flight.setpoint_after(SECOND) == FIRST


def test_a_goal_of_another_sender_begins_at_the_first_waypoint_though_it_has_the_same_name(flight):
    flight.end_node(signal.SIGKILL)
    flight.end_probe()
    flight.start_node()
    flight.start_probe()
    assert flight.setpoint() == FIRST
