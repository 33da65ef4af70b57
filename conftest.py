"""What all tests share: the libraries on the path, the `ros` marker, a ROS master of one's own."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import uuid
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent
TOKEN = "WORKSPACE_TEST"  # environment variable by which everything that a test has started is found again

# Libraries are tested where nothing is built, too; a built workspace comes first, it has messages as well.
sys.path += sorted(str(path) for path in ROOT.glob("src/*/src"))


def why_no_ros() -> str | None:
    """Return why tests that need ROS cannot run here, or None."""
    if not shutil.which("roslaunch"):
        return "needs ROS, which is not installed: ./bringup.sh setup"
    if not (ROOT / "devel/setup.bash").exists():
        return "needs the built workspace: ./bringup.sh setup"
    if str(ROOT / "devel") not in os.environ.get("CMAKE_PREFIX_PATH", "").split(":"):
        return "needs the workspace's environment: source devel/setup.bash"
    return None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip the tests marked `ros` where there is no ROS, and say so."""
    reason = why_no_ros()
    for item in items:
        if reason and item.get_closest_marker("ros"):
            item.add_marker(pytest.mark.skip(reason=reason))


def free_port() -> int:
    """Return a TCP port that nobody uses at this moment."""
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def heed_interrupts() -> None:
    """Let SIGINT count again: tests run in a shell's background would inherit that it is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Processes:
    """Starts commands in one environment; `stop` ends them and all that they started, in any group."""

    def __init__(self, environment: dict[str, str]) -> None:
        self._token = uuid.uuid4().hex
        # Unbuffered: a test that waits for a node's words must not wait for a full buffer.
        self.environment = {**os.environ, "PYTHONUNBUFFERED": "1", **environment, TOKEN: self._token}

    def start(self, *command: str, **options) -> subprocess.Popen:
        """Start a command; options are Popen's."""
        return subprocess.Popen(
            command, env=self.environment, start_new_session=True, preexec_fn=heed_interrupts, **options
        )

    def run(self, *command: str, timeout_s: float) -> subprocess.CompletedProcess:
        """Run a command to its end; returns its code, and all that it said as `stdout`.

        Raises:
            subprocess.TimeoutExpired: it took longer; `output` then holds what it said until then.
        """
        child = self.start(
            *command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        )
        try:
            said, _ = child.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired as error:
            self.stop()
            error.output, _ = child.communicate()
            raise
        return subprocess.CompletedProcess(command, child.returncode, said)

    def stop(self) -> None:
        """End everything: asked with SIGINT, then SIGTERM, then killed."""
        for number, patience_s in ((signal.SIGINT, 5.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 2.0)):
            for pid in self._alive():
                try:
                    os.kill(pid, number)
                except ProcessLookupError:
                    continue
            end = time.monotonic() + patience_s
            while self._alive() and time.monotonic() < end:
                time.sleep(0.05)

    def _alive(self) -> list[int]:
        mark = f"{TOKEN}={self._token}".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            try:
                ours = mark in (path / "environ").read_bytes().split(b"\0")
                zombie = (path / "stat").read_text().rpartition(")")[2].split()[0] == "Z"
            except OSError:
                continue
            if ours and not zombie:
                found.append(int(path.name))
        return found


@pytest.fixture
def processes(tmp_path):
    """Start commands that leave nothing behind: no process, and no file outside the test's own folder."""
    started = Processes({"ROS_HOME": str(tmp_path / "ros"), "ROS_LOG_DIR": str(tmp_path / "ros/log")})
    yield started
    started.stop()


@pytest.fixture(scope="module")
def processes_of_module(tmp_path_factory):
    """Like `processes`, for what several tests of one file look at."""
    folder = tmp_path_factory.mktemp("ros")
    started = Processes({"ROS_HOME": str(folder), "ROS_LOG_DIR": str(folder / "log")})
    yield started
    started.stop()


@pytest.fixture
def ros_master(processes):
    """Like `processes`, with a ROS master of their own, which `environment` leads to."""
    port = free_port()
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{port}"
    master = processes.start("rosmaster", "--core", "-p", str(port), stdout=subprocess.DEVNULL)
    end = time.monotonic() + 20.0
    while time.monotonic() < end:
        with socket.socket() as sock:
            if sock.connect_ex(("127.0.0.1", port)) == 0:
                return processes
        assert master.poll() is None, "rosmaster ended"
        time.sleep(0.05)
    raise TimeoutError("rosmaster did not answer within 20 s")
