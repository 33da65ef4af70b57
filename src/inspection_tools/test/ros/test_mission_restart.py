"""A mission node that is killed in flight goes on where it was when roslaunch has started it again."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("rosgraph", reason="needs ROS")

FOLDER = Path(__file__).resolve().parent
FIRST, SECOND = "10 0 2", "10 5 2"  # of mission.yaml
PATIENCE_S = 60.0

pytestmark = pytest.mark.ros


def test_a_restarted_mission_goes_on_after_the_reached_waypoints(ros_master):
    def start_node():
        file = f"_file:={FOLDER / 'mission.yaml'}"
        return ros_master.start_node("inspection_tools", "mission", "__name:=mission", file)

    node = start_node()
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    probe = ros_master.start(sys.executable, str(FOLDER / "mission_probe.py"), **pipes)
    setpoints: queue.Queue = queue.Queue()
    threading.Thread(
        target=lambda: [setpoints.put(line.strip()) for line in probe.stdout], daemon=True
    ).start()
    assert setpoints.get(timeout=PATIENCE_S) == FIRST
    probe.stdin.write(FIRST + "\n")  # the UAV is there
    probe.stdin.flush()
    assert setpoints.get(timeout=PATIENCE_S) == SECOND
    # When the node is killed and started anew, it hears of the same goal, which is latched
    node.kill()
    node.wait(PATIENCE_S)
    start_node()
    assert setpoints.get(timeout=PATIENCE_S) == SECOND
