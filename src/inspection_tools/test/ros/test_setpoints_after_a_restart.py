"""A position controller that starts again obeys the node in charge, whatever others had sent before."""

import queue
import subprocess
import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("rosgraph", reason="needs ROS")
pytestmark = pytest.mark.ros

PROBE = Path(__file__).with_name("setpoint_probe.py")
PATIENCE_S = 200.0
STARTS = 3


class Node:
    """A probe: one line in, one line out."""

    def __init__(self, master, *words):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self._process = master.start(sys.executable, str(PROBE), *words, **pipes)
        self._said = queue.Queue()
        lines, said = self._process.stdout, self._said
        threading.Thread(target=lambda: [said.put(line.strip()) for line in lines], daemon=True).start()

    def ask(self, line):
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()
        return self._said.get(timeout=PATIENCE_S)


@pytest.fixture
def controller(ros_master):
    """Starts a position controller, anew if there is one, and returns where it flies to when all is sent."""
    listener, nodes = Node(ros_master, "listens"), []

    def start():
        for node in nodes:
            node.kill()
            node.wait(PATIENCE_S)
        nodes[:] = [
            ros_master.start_node("inspection_tools", "position_controller", "__name:=position_controller")
        ]
        return listener.ask("again")

    start.flies_to = listener.ask
    return start


@pytest.mark.parametrize("old", ["sends", "latches"])
def test_it_obeys_the_node_in_charge_and_not_the_one_before(ros_master, controller, old):
    # Given two nodes that have sent a setpoint, one after the other
    controller()
    before = Node(ros_master, old)
    assert before.ask("1") == "sent"
    assert controller.flies_to("1") == "1"
    # Not earlier: to a node that starts meanwhile, a first message is an old one
    now = Node(ros_master, "sends")
    assert now.ask("2") == "sent"
    assert controller.flies_to("2") == "2"
    # When the controller starts again, then it flies to the newer one each time
    assert [controller() for _ in range(STARTS)] == ["2"] * STARTS
