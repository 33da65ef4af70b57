"""Ctrl-C ends what a user has started, without a traceback; so does a master that is not there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flights.graph.free_ports import free_ports

rosgraph = pytest.importorskip("rosgraph", reason="needs ROS")

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.ros


RUN = """
import runpy, sys
print("Python has started", flush=True)
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


@pytest.mark.parametrize("delay_s", [0.3, 1.0])
def test_the_summary_is_interrupted_without_a_traceback(processes, tmp_path, delay_s):
    """At any moment of its imports; a pipe without end keeps it from its own."""
    path = tmp_path / "result.json"
    subprocess.run(["mkfifo", str(path)], check=True)
    command = (sys.executable, "-c", RUN, str(ROOT / "scripts/summarise.py"), str(path))
    child = processes.start(*command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    child.stdout.readline()  # while Python itself starts, it answers an interrupt in its own way
    time.sleep(delay_s)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=200.0)
    assert child.returncode == -signal.SIGINT
    assert "Traceback" not in said


def test_a_node_that_works_takes_leave_of_the_master(ros_master):
    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])

    def services() -> list[str]:
        return [name for name, _ in master.getSystemState()[2] if name.startswith("/cepa/")]

    node = ros_master.start_node("cepa", "cepa", stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60.0
    while "/cepa/set_parameters" not in services():
        assert time.monotonic() < deadline, "it never came up"
        time.sleep(0.1)
    node.send_signal(signal.SIGINT)
    _, said = node.communicate(timeout=200.0)
    assert node.returncode == 0, said
    assert "Traceback" not in said
    assert not services()
    log = Path(ros_master.environment["ROS_LOG_DIR"], "cepa.log").read_text()
    assert f"signal_shutdown [SIGINT from process {os.getpid()} (" in log


def test_who_sets_a_parameter_hears_that_the_node_refuses_it(ros_master):
    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])
    ros_master.start("rosrun", "rosout", "rosout", stdout=subprocess.DEVNULL)
    ros_master.start_node("inspection_tools", "position_controller", stderr=subprocess.DEVNULL)
    needed = {"/position_controller/set_parameters", "/rosout/get_loggers"}
    deadline = time.monotonic() + 60.0
    while needed - {name for name, _ in master.getSystemState()[2]}:
        assert time.monotonic() < deadline, "it never came up"
        time.sleep(0.1)

    def set_parameters(*words: str, of: str = "/position_controller") -> tuple[int, str]:
        command = str(ROOT / "devel/lib/node_tools/set_parameter")
        done = ros_master.run(command, of, *words, timeout_s=200.0)
        return done.returncode, done.stdout

    assert set_parameters("max_speed", "1.5", "gain", "1") == (
        0,
        "/position_controller uses max_speed = 1.5, gain = 1.\n",
    )
    assert master.getParam("/position_controller/max_speed") == 1.5
    assert set_parameters("max_speed", "99") == (
        1,
        "max_speed must be from 0 to 15: 99 is refused, the old value stays.\n",
    )
    code, said = set_parameters("braking_deceleration", "3")  # above max_acceleration, as only the node knows
    assert code == 1
    assert said.endswith("The change is refused; the old parameters stay.\n")
    what = "don't know parameter: max_sped"
    assert set_parameters("max_sped", "1") == (1, f"/position_controller takes no max_sped: {what}.\n")
    assert set_parameters("max_speed", "1", of="/position_controler") == (
        1,
        "There is no node /position_controler with live parameters. These have some: /position_controller.\n",
    )
    assert master.getParam("/position_controller/max_speed") == 1.5


def test_map_saver_without_a_master_says_so(processes):
    processes.environment["ROS_MASTER_URI"] = uri = f"http://localhost:{free_ports(1)[0]}"
    saver = processes.start_node(
        "gridslam", "map_saver", stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    said, _ = saver.communicate(timeout=200.0)
    assert saver.returncode == 1
    assert said == f"map_saver: no ROS master answers at {uri}; start one, or set ROS_MASTER_URI.\n"


def test_map_saver_is_interrupted_without_a_traceback(ros_master):
    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])
    child = ros_master.start_node("gridslam", "map_saver", stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60.0
    while "/map" not in dict(master.getSystemState()[1]):
        assert time.monotonic() < deadline, "it does not wait for a map"
        time.sleep(0.05)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=200.0)
    assert "Traceback" not in said
