"""How processes end that use `Ending`, and nodes while they start: at once and without a traceback."""

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
SOURCES = PACKAGE.parents[1]
PATIENCE_S = 30.0  # what is not ended takes a minute; how fast it ends is for benchmarks to say
NODES = (
    "cepa/nodes/cepa",
    "cepa/nodes/cepa_visualiser",
    "gridslam/nodes/slam_gridslam",
    "inspection_tools/nodes/mission",
    "simulation_tools/nodes/gazebo",
    "simulation_tools/nodes/mavros",
    "simulation_tools/nodes/mavros_publisher",
    "simulation_tools/nodes/tf_publisher",
)
BEGIN = f"""
import sys, time
sys.path.insert(0, {str(PACKAGE / "src")!r})
from node_tools.ending import Ending, leave
ending = Ending()
print("begun", flush=True)
"""


def watches_for_signals(pid):
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    blocked = next(int(line.split()[1], 16) for line in lines if line.startswith("SigBlk:"))
    return bool(blocked & 1 << (signal.SIGINT - 1))


def end(arguments, number=signal.SIGINT, after_s=0.0, line=None, **environment):
    """Start a process, signal it some time after its first line, or after it watches for signals.

    Returns (exit code, output, seconds until it ended).
    """
    process = subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **environment
    )
    try:
        if line:
            assert process.stdout.readline().strip() == line
        while not watches_for_signals(process.pid):  # Python itself takes a moment to start
            assert process.poll() is None, process.stdout.read()
            time.sleep(0.005)
        time.sleep(after_s)
        began = time.monotonic()
        process.send_signal(number)
        output, _ = process.communicate(timeout=200.0)
        return process.returncode, output, time.monotonic() - began
    finally:
        process.kill()
        process.wait()


@pytest.mark.table("number", [signal.SIGINT, signal.SIGTERM])
def test_before_anything_is_open_it_ends_on_the_spot(number):
    code, output, seconds = end([sys.executable, "-c", BEGIN + "time.sleep(60)"], number, line="begun")
    assert code == 128 + number
    assert output == ""
    assert seconds < PATIENCE_S


@pytest.mark.table("number", [signal.SIGINT, signal.SIGTERM])
def test_its_temporary_folders_go_and_those_of_others_stay(number, tmp_path):
    other = tmp_path / f"meshes_of_process_{os.getpid()}_x"
    other.mkdir()
    body = """
from mesh_files.scratch import scratch_folder
ending.closes_by(lambda: None)
folder = scratch_folder("meshes")
open(folder.name + "/0.obj", "w").close()
print("loading", flush=True)
time.sleep(60)
"""
    begin = BEGIN.replace('print("begun", flush=True)', "")
    code, output, _ = end(
        [sys.executable, "-c", begin + body],
        number,
        line="loading",
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    assert (code, output) == (0, "")
    assert list(tmp_path.iterdir()) == [other]


@pytest.mark.table("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_open_is_closed_whatever_the_main_thread_does(number):
    body = """
ending.closes_by(lambda: print("closed"))
while True:
    pass
"""
    code, output, seconds = end([sys.executable, "-c", BEGIN + body], number, line="begun", after_s=0.2)
    assert (code, output) == (0, "closed\n")
    assert seconds < PATIENCE_S


def test_a_main_thread_that_watches_ends_by_itself_and_closes():
    body = """
ending.main_thread_closes()
while not ending.wait(0.1):
    pass
leave(3, lambda: print("closed"))
"""
    code, output, seconds = end([sys.executable, "-c", BEGIN + body], line="begun", after_s=0.2)
    assert (code, output) == (3, "closed\n")
    assert seconds < PATIENCE_S


def test_a_main_thread_may_first_take_its_time_then_leave_it_to_the_signal():
    body = """
ending.main_thread_closes(within_s=None)
while not ending.wait(0.1):
    pass
time.sleep(2.2)  # longer than CLOSING_S
leave(3, lambda: print("written"))
"""
    assert end([sys.executable, "-c", BEGIN + body], line="begun", after_s=0.2)[:2] == (3, "written\n")
    body = """
ending.main_thread_closes(within_s=None)
ending.closes_by(lambda: print("left out"), code=1)
time.sleep(60)
"""
    assert end([sys.executable, "-c", BEGIN + body], line="begun", after_s=0.2)[:2] == (1, "left out\n")


def test_it_tells_which_signal_came_from_whom():
    body = """
ending.main_thread_closes()
while not ending.wait(0.1):
    pass
leave(0, lambda: print(ending.cause))
"""
    _, output, _ = end([sys.executable, "-c", BEGIN + body], signal.SIGTERM, line="begun")
    words = Path("/proc/self/cmdline").read_text().split("\0")
    assert output == f"SIGTERM from process {os.getpid()} ({' '.join(words).strip()})\n"


def test_the_log_names_the_signal_even_if_the_main_thread_hangs():
    body = """
import logging
logging.basicConfig(stream=sys.stdout, level=logging.INFO, format="%(message)s")
ending.main_thread_closes()
time.sleep(60)
"""
    code, output, _ = end([sys.executable, "-c", BEGIN + body], line="begun", after_s=0.2)
    assert code == 0
    assert output.startswith(f"This process ends: SIGINT from process {os.getpid()} (")


def test_while_it_ends_a_node_keeps_quiet_about_others_that_end():
    """rospy warns if a node connects and ends before it has said a word."""
    body = """
import logging
def close():
    for words in ("Inbound TCP/IP connection failed: %s", "a warning of its own: %s"):
        logging.getLogger("rosout").warning(words, "x")
leave(0, close)
"""
    ended = subprocess.run([sys.executable, "-c", BEGIN + body], capture_output=True, text=True, check=True)
    assert ended.stderr == "a warning of its own: x\n"


@pytest.mark.table("body", ["time.sleep(60)", "leave(0, lambda: time.sleep(60))"])
def test_nothing_that_hangs_is_waited_for_long(body):
    code, output, seconds = end(
        [sys.executable, "-c", BEGIN + "ending.main_thread_closes()\n" + body], line="begun", after_s=0.2
    )
    assert (code, output) == (0, "")
    assert seconds < PATIENCE_S


@pytest.mark.ros
@pytest.mark.parametrize("after_s", [0.0, 0.4, 1.0])
def test_a_node_interrupted_at_its_start_ends_without_a_traceback(after_s):
    """All at the same time: none waits for another."""
    pytest.importorskip("rospy")
    nobodys = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"}  # a user's own graph has the usual one
    nodes = [str(SOURCES / path) for path in NODES]
    with ThreadPoolExecutor(len(nodes)) as pool:
        ends = pool.map(lambda node: end([sys.executable, node], after_s=after_s, env=nobodys), nodes)
    for node, (_, output, seconds) in zip(nodes, ends):
        assert "Traceback" not in output, node
        assert seconds < PATIENCE_S, node


@pytest.mark.ros
def test_no_node_says_that_rosdep_was_never_initialised(tmp_path):
    """Where rosdep is installed, rospkg tells everybody who imports dynamic_reconfigure."""
    pytest.importorskip("dynamic_reconfigure", reason="needs ROS")
    package = tmp_path / "rosdep2"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "rospack.py").write_text(
        "def init_rospack_interface(): return object()\n"
        "def is_view_empty(view): return True\n"
        "is_ros_package = is_system_dependency = None\n"
    )
    folders = (tmp_path, PACKAGE / "src", *sys.path)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, folders))}

    def said(code):
        command = [sys.executable, "-c", code]
        run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return run.stderr

    assert "rosdep view is empty" in said("import dynamic_reconfigure.server")
    assert said("import node_tools.ending; import dynamic_reconfigure.server") == ""
