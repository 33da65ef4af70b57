"""What users have around them in a shell: another Python, and a folder of their own."""

from __future__ import annotations

import os
import socket
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SETUP_PATIENCE_S = 400.0

pytestmark = pytest.mark.ros


def sourced(command: str, first_on_path: Path) -> subprocess.CompletedProcess:
    """Run a command as in a new shell with nothing but this folder before the system's, after `source`."""
    environment = {"HOME": os.environ.get("HOME", "/"), "PATH": f"{first_on_path}:/usr/bin:/bin"}
    script = f"source {ROOT}/devel/setup.bash && {command}"
    return subprocess.run(
        ["bash", "-c", script], env=environment, capture_output=True, text=True, timeout=60.0, check=False
    )


def python_in(folder: Path, options: str) -> Path:
    """Make a folder with a python3 that is started with these options."""
    folder.mkdir()
    python = folder / "python3"
    python.write_text(f'#!/bin/sh\nexec /usr/bin/python3 {options} "$@"\n')
    python.chmod(0o755)
    return folder


def test_ros_scripts_run_where_another_python_is_first(tmp_path):
    # Given a python3 that, as pyenv's, knows nothing of ROS
    other = python_in(tmp_path / "other", "-I -S")
    run = sourced("rosrun dynamic_reconfigure dynparam --help", other)
    assert "dynparam set " in run.stdout, run.stdout + run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.skipif(
    Path("/opt/ros/noetic").exists(), reason="Ubuntu's python3 knows ROS after its own setup only"
)
def test_a_python_that_knows_ros_stays_first(tmp_path):
    own = python_in(tmp_path / "own", "")
    assert sourced("command -v python3", own).stdout.strip() == str(own / "python3")


@pytest.mark.timeout(SETUP_PATIENCE_S + 120.0)
def test_bringup_takes_paths_as_the_caller_means_them(processes, tmp_path):
    """Relative ones, and ones with spaces; the world is malformed, so that the launch ends at once."""
    folder = tmp_path / "a folder"
    folder.mkdir()
    (folder / "broken.world").write_text('<?xml version="1.0"?>\n<sdf version="1.6"><world')
    sockets = [socket.socket() for _ in range(3)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    master, offboard, ground = (one.getsockname()[1] for one in sockets)
    for one in sockets:
        one.close()
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{master}"
    bringup = str(ROOT / "bringup.sh")
    # Sources that changed since the last set-up are built, and their kernels compiled, before anything starts
    ready = processes.run(bringup, "setup", timeout_s=SETUP_PATIENCE_S)
    assert ready.returncode == 0, ready.stdout
    ports = (f"offboard_port:={offboard}", f"gcs_port:={ground}")
    words = ("fly_to_goal", "world:=broken.world", "goal:=3 0 2", "results:=my results", *ports)
    call = 'cd "$1" && shift && exec "$@"'
    run = processes.run("bash", "-c", call, "-", str(folder), bringup, *words, timeout_s=90.0)
    assert run.returncode != 0
    assert f"{folder}/broken.world:2: " in run.stdout
    assert (folder / "my results").is_dir()
    assert not (ROOT / "my").exists()
    # Nodes end silently, but an interpreter told to end before its first line says KeyboardInterrupt
    assert run.stdout.count("Traceback") == run.stdout.count("\nKeyboardInterrupt"), run.stdout
