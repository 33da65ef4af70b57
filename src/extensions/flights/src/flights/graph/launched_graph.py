"""A graph of ROS nodes, started by roslaunch and observed from outside: events, CPU time and memory."""

from __future__ import annotations

import json
import os
import queue
import shutil
import signal
import subprocess
import sys
import threading
import time
import uuid
from pathlib import Path
from typing import Sequence

from flights.errors import GraphError
from flights.graph import processes
from flights.graph.free_ports import free_ports

TOKEN = "LAUNCHED_GRAPH"
"""Environment variable that marks all processes of a graph."""

FLIGHT_EVENTS = ("first_scan_through", "hovering", "goal_reached")
"""Events of a flight: CEPA has answered a scan; the UAV hovers and is ready; it is at the goal."""


class LaunchedGraph:
    """One roslaunch with a master of its own, and a probe that listens to it.

    Needs ROS's commands and the workspace's environment.
    """

    def __init__(
        self,
        folder: Path,
        *arguments: str,
        events: Sequence[str] = FLIGHT_EVENTS,
        display: str | None = None,
    ) -> None:
        """Start; arguments: of roslaunch, package and launch file first, or a launch file alone.

        folder: for logs. events: for the probe (`flights_ros.launch.probe`). display: the X server for
        windows.

        Raises:
            GraphError: there is no roslaunch.
        """
        if not shutil.which("roslaunch"):
            raise GraphError("There is no roslaunch; call ./bringup.sh, which loads ROS's environment.")
        self._token = uuid.uuid4().hex
        (port,) = free_ports(1)
        self.master_uri = f"http://localhost:{port}"
        environment = _environment(folder, self.master_uri, display)
        self._probe = subprocess.Popen(
            [sys.executable, "-m", "flights_ros.launch.probe", *events],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self._events: queue.Queue = queue.Queue()
        self._happened: dict[str, float] = {}
        threading.Thread(target=self._read_events, daemon=True).start()
        self._output = (folder / "roslaunch.txt").open("w+")
        self.started_s = time.monotonic()
        self.launch = subprocess.Popen(
            ["roslaunch", "-p", str(port), *arguments],
            env={**environment, TOKEN: self._token},
            stdout=self._output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )

    def wait_for(self, event: str, timeout_s: float) -> float:
        """Wait for an event. Return its time in seconds since the start; GraphError if it does not come."""
        end = time.monotonic() + timeout_s
        while event not in self._happened:
            if time.monotonic() > end or self.launch.poll() is not None:
                raise GraphError(f"The graph never came to {event}; it said:\n{self.said()}")
            try:
                name, when_s = self._events.get(timeout=0.1)
            except queue.Empty:
                continue
            self._happened[name] = when_s - self.started_s
        return self._happened[event]

    def processes(self) -> list[int]:
        """Return the process ids of roslaunch and everything that it has started."""
        mark = f"{TOKEN}={self._token}".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            try:
                ours = mark in (path / "environ").read_bytes().split(b"\0")
            except OSError:
                continue
            if ours and not processes.has_ended(int(path.name)):
                found.append(int(path.name))
        return found

    def cpu_s(self) -> float:
        """Return the CPU time of all processes so far; the checks that roslaunch made at first count, too."""
        before_s = processes.ended_children_cpu_s(self.launch.pid) or 0.0
        return before_s + sum(processes.cpu_s(pid) or 0.0 for pid in self.processes())

    def memory_gb(self) -> float:
        """Return the memory of all processes. Shared memory counts once."""
        return sum(processes.shared_out_memory_gb(pid) for pid in self.processes())

    def interrupt(self) -> float:
        """Press Ctrl-C. Return the seconds until all processes have ended."""
        began_s = time.monotonic()
        os.killpg(self.launch.pid, signal.SIGINT)
        while self.processes():
            self.launch.poll()
            if time.monotonic() - began_s > 30.0:
                raise GraphError("The graph did not end within 30 s of Ctrl-C.")
            time.sleep(0.02)
        return time.monotonic() - began_s

    def wait_for_end(self, timeout_s: float) -> None:
        """Wait until roslaunch has ended by itself; GraphError if it does not."""
        try:
            self.launch.wait(timeout_s)
        except subprocess.TimeoutExpired:
            sentence = f"The graph did not end within {timeout_s:g} s; it said:\n{self.said()}"
            raise GraphError(sentence) from None

    def said(self) -> str:
        """Return the last output of roslaunch and its nodes."""
        self._output.flush()
        return Path(self._output.name).read_text(errors="replace")[-2000:]

    def close(self) -> None:
        """End all remaining processes, with the probe."""
        for pid in self.processes():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.launch.wait()
        if self._probe.stdin:
            self._probe.stdin.close()
        try:
            self._probe.wait(5.0)
        except subprocess.TimeoutExpired:
            self._probe.kill()
            self._probe.wait()
        self._output.close()

    def _read_events(self) -> None:
        for line in self._probe.stdout or ():
            self._events.put(json.loads(line))


def _environment(folder: Path, master_uri: str, display: str | None) -> dict[str, str]:
    found = {
        **os.environ,
        "ROS_MASTER_URI": master_uri,
        "ROS_HOME": str(folder / "ros"),
        "ROS_LOG_DIR": str(folder / "ros/log"),
    }
    found.pop("ROS_HOSTNAME", None)
    if display is not None:
        found.update(DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1")
    return found
