"""How processes end that use `StopSignals`, and nodes while they start: at once and without a traceback."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1]
PATIENCE_S = 10.0  # what is not ended takes a minute; how fast it ends is for benchmarks to say
BEGIN = f"""
import sys, time
sys.path.insert(0, {str(PACKAGE / "src")!r})
from simulation_tools.stop_signals import StopSignals, leave
stop = StopSignals()
print("begun", flush=True)
"""


def end(arguments, number=signal.SIGINT, after_s=0.0, line=None, **environment):
    """Start a process, signal it after its first line or some time; returns (exit code, output, seconds)."""
    process = subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **environment
    )
    try:
        if line:
            assert process.stdout.readline().strip() == line
        time.sleep(after_s)
        began = time.monotonic()
        process.send_signal(number)
        output, _ = process.communicate(timeout=60.0)
        return process.returncode, output, time.monotonic() - began
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_before_anything_is_watched_it_ends_on_the_spot(number):
    code, output, seconds = end([sys.executable, "-c", BEGIN + "time.sleep(60)"], number, line="begun")
    assert code == 128 + number
    assert output == ""
    assert seconds < PATIENCE_S


def test_a_main_thread_that_watches_ends_by_itself_and_closes():
    body = """
stop.watched()
while not stop.wait(0.1):
    pass
leave(3, lambda: print("closed"))
"""
    code, output, seconds = end([sys.executable, "-c", BEGIN + body], line="begun", after_s=0.2)
    assert (code, output) == (3, "closed\n")
    assert seconds < PATIENCE_S


@pytest.mark.parametrize("body", ["time.sleep(60)", "leave(0, lambda: time.sleep(60))"])
def test_nothing_that_hangs_is_waited_for_long(body):
    code, output, seconds = end(
        [sys.executable, "-c", BEGIN + "stop.watched()\n" + body], line="begun", after_s=0.2
    )
    assert (code, output) == (0, "")
    assert seconds < PATIENCE_S


@pytest.mark.ros
@pytest.mark.parametrize("after_s", [0.5, 0.8, 1.2])
def test_a_node_interrupted_while_it_starts_is_gone_at_once_without_a_traceback(after_s):
    """All at the same time: none waits for another."""
    pytest.importorskip("rospy")
    nobodys = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"}  # a user's own graph has the usual one
    nodes = [
        str(PACKAGE / "nodes" / name) for name in ("gazebo", "mavros", "mavros_publisher", "tf_publisher")
    ]
    with ThreadPoolExecutor(len(nodes)) as pool:
        ends = pool.map(lambda node: end([sys.executable, node], after_s=after_s, env=nobodys), nodes)
    for node, (_, output, seconds) in zip(nodes, ends):
        assert "Traceback" not in output, node
        assert seconds < PATIENCE_S, node
