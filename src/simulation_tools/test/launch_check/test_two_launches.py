"""Of two launches that start the same master together, the later one is refused before it starts anything."""

from __future__ import annotations

import socket
import threading
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from simulation_tools.launch_check.launch_files import LaunchError

pytestmark = pytest.mark.ros
OWN = 300
SIMULATOR = ("/usr/bin/python3", "/usr/bin/roslaunch", "simulation_tools", "sitl.launch")


@pytest.fixture
def processes(tmp_path):
    """A folder /proc with one roslaunch, number OWN, which started at tick 500."""
    return add(tmp_path, OWN, 500, SIMULATOR, {}, "own-run")


@pytest.fixture
def check():
    module = pytest.importorskip(
        "simulation_tools_ros.two_launches", reason="the workspace is not built, or not sourced"
    )
    return module.check_is_alone


def add(proc, pid, tick, words, environment, run_id="", network="net:[1]"):
    """Add a process to a folder /proc; run_id: of its open log."""
    folder = proc / str(pid)
    (folder / "fd").mkdir(parents=True)
    (folder / "ns").mkdir()
    (folder / "ns/net").symlink_to(network)
    (folder / "cmdline").write_text("".join(f"{word}\0" for word in words))
    (folder / "environ").write_text("".join(f"{name}={value}\0" for name, value in environment.items()))
    (folder / "stat").write_text(f"{pid} (ros (launch)) S {' '.join(['0'] * 18)} {tick} 0 0")
    if run_id:
        (folder / "fd/5").symlink_to(f"/root/.ros/log/{run_id}/roslaunch-machine-{pid}.log")
    return proc


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


@pytest.fixture
def master():
    """A master whose run is called another-run; its URI."""
    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as served:
        served.register_function(lambda _caller, _key: [1, "", "another-run"], "getParam")
        threading.Thread(target=served.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{served.server_address[1]}"
        served.shutdown()


@pytest.mark.parametrize(
    ("pid", "tick", "words", "network", "is_refused"),
    [
        (200, 499, SIMULATOR, "net:[1]", True),
        (200, 499, ("/usr/bin/python3", "/usr/bin/roscore"), "net:[1]", True),
        (299, 500, SIMULATOR, "net:[1]", True),
        (301, 500, SIMULATOR, "net:[1]", False),
        (200, 501, SIMULATOR, "net:[1]", False),
        (200, 499, SIMULATOR, "net:[2]", False),
        (200, 499, ("/usr/bin/vim", "a.launch"), "net:[1]", False),
        (200, 499, (*SIMULATOR, "-p", "1"), "net:[1]", False),
    ],
    ids=["older", "a core", "same tick", "same tick, later", "younger", "a container's", "no launch", "port"],
)
def test_the_older_of_two_launches_without_a_master_goes_on(
    check, processes, pid, tick, words, network, is_refused
):
    uri = f"http://localhost:{free_port()}"
    add(processes, pid, tick, words, {"ROS_MASTER_URI": uri}, network=network)
    if is_refused:
        with pytest.raises(LaunchError, match=f"process {pid}.*{uri}"):
            check(OWN, uri, processes)
    else:
        check(OWN, uri, processes)


def test_a_launch_that_asked_before_the_master_was_there_is_refused(check, processes, master):
    with pytest.raises(LaunchError, match="has just started"):
        check(OWN, master, processes)


def test_a_launch_that_asked_the_running_master_goes_on(check, processes, master):
    (processes / str(OWN) / "fd/5").unlink()
    (processes / str(OWN) / "fd/5").symlink_to(f"/root/.ros/log/another-run/roslaunch-machine-{OWN}.log")
    add(processes, 200, 400, SIMULATOR, {"ROS_MASTER_URI": master})
    check(OWN, master, processes)
