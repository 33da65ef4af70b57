"""A pilot at a terminal: keys become reference velocities, and the terminal is given back as it was."""

from __future__ import annotations

import os
import re
import subprocess
import termios
import time

import pytest

pytestmark = [pytest.mark.ros, pytest.mark.timeout(600)]
PATIENCE_S = 200.0


@pytest.fixture
def terminal():
    """A pseudo-terminal: the pilot's side and the node's."""
    pilot, node = os.openpty()
    yield pilot, node
    os.close(pilot)
    os.close(node)


@pytest.fixture
def listen(ros_master, tmp_path):
    """Start to write down what is published on the topic; returns a function that waits for a pattern."""
    heard = tmp_path / "heard.txt"
    with heard.open("w") as file:
        ros_master.start("rostopic", "echo", "-p", "/vel_setpoint_out", stdout=file)

    def wait_for(pattern):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if re.search(pattern, heard.read_text()):
                return
            time.sleep(0.05)
        raise AssertionError(f"nothing like {pattern!r} in\n{heard.read_text()[-2000:]}")

    return wait_for


def row(ahead, left):
    """Return the pattern of one row of `rostopic echo -p`: ..., frame, linear x, y, z, angular x, y, z."""
    return rf"base_frame,{re.escape(str(ahead))},{re.escape(str(left))},0\.0,"


def test_keys_fly_and_letting_go_hovers(ros_master, listen, terminal):
    pilot, node = terminal
    before = termios.tcgetattr(node)
    teleop = ros_master.start_node("inspection_tools", "teleop", "_speed:=2.0", stdin=node)
    listen(row(0.0, 0.0))
    os.write(pilot, b"i")
    listen(row(2.0, 0.0) + r"[^\n]*\n(.*\n)*?.*" + row(0.0, 0.0))  # ahead, and then zero again
    os.write(pilot, b"l")
    listen(row(0.0, -2.0))
    ros_master.stop()
    teleop.wait(PATIENCE_S)
    assert termios.tcgetattr(node) == before


def test_without_a_terminal_it_ends_with_a_sentence(ros_master):
    ended = ros_master.start_node(
        "inspection_tools",
        "teleop",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    said, _ = ended.communicate(timeout=PATIENCE_S)
    assert ended.returncode == 1
    assert "standard input is not a terminal" in said
    assert "Traceback" not in said
