"""The whole ROS graph of Experiment 1 as its user sees it: start, hover, load, memory, end, and top speed."""

from __future__ import annotations

import json
import os
import queue
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from benchmarks._report import ROOT

TOKEN = "SIM_BENCHMARK"
"""Environment variable by which everything that belongs to a graph is found."""

HOVER_PATIENCE_S = 90.0
END_PATIENCE_S = 240.0
LOAD_S = 15.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


class GraphError(RuntimeError):
    """A graph did not do what was to be measured."""


class Graph:
    """One roslaunch with a master of its own, and a probe that listens to it."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        """Start; arguments: of roslaunch, package and launch file first."""
        self._token = uuid.uuid4().hex
        port = _free_port()
        environment = {
            **os.environ,
            "ROS_MASTER_URI": f"http://localhost:{port}",
            "ROS_HOME": str(folder / "ros"),
            "ROS_LOG_DIR": str(folder / "ros/log"),
        }
        environment.pop("ROS_HOSTNAME", None)
        self._probe = subprocess.Popen(
            [sys.executable, "-m", "benchmarks._sim_probe"],
            cwd=ROOT,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self._events: queue.Queue = queue.Queue()
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
        """Return when an event happened, in seconds since the start; GraphError when it does not."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end and self.launch.poll() is None:
            try:
                name, when_s = self._events.get(timeout=0.1)
            except queue.Empty:
                continue
            if name == event:
                return when_s - self.started_s
        raise GraphError(f"The graph never came to {event}; it said:\n{self.said()}")

    def processes(self) -> list[int]:
        """Return the process ids of everything that roslaunch has started, and its own."""
        mark = f"{TOKEN}={self._token}".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            try:
                ours = mark in (path / "environ").read_bytes().split(b"\0")
                dead = (path / "stat").read_text().rpartition(")")[2].split()[0] == "Z"
            except OSError:
                continue
            if ours and not dead:
                found.append(int(path.name))
        return found

    def cpu_s(self) -> float:
        """Return the CPU time of all processes so far."""
        ticks = 0
        for pid in self.processes():
            try:
                fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            ticks += int(fields[11]) + int(fields[12])
        return ticks / TICKS_PER_S

    def memory_gb(self) -> float:
        """Return the memory of all processes; what several share counts once (proportional set size)."""
        kilobytes = 0
        for pid in self.processes():
            try:
                lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
            except OSError:
                continue
            kilobytes += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
        return kilobytes / 2**20

    def interrupt(self) -> float:
        """Press Ctrl-C; return the seconds until nothing is left."""
        began_s = time.monotonic()
        os.killpg(self.launch.pid, signal.SIGINT)
        while self.processes():
            self.launch.poll()
            if time.monotonic() - began_s > 30.0:
                raise GraphError("The graph did not end within 30 s of Ctrl-C.")
            time.sleep(0.02)
        return time.monotonic() - began_s

    def wait_for_end(self, timeout_s: float) -> None:
        """Return when roslaunch has ended by itself; GraphError when it does not."""
        try:
            self.launch.wait(timeout_s)
        except subprocess.TimeoutExpired:
            sentence = f"The graph did not end within {timeout_s:g} s; it said:\n{self.said()}"
            raise GraphError(sentence) from None

    def said(self) -> str:
        """Return the last that roslaunch and its nodes printed."""
        self._output.flush()
        return Path(self._output.name).read_text(errors="replace")[-2000:]

    def close(self) -> None:
        """End whatever is left, the probe included."""
        for pid in self.processes():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.launch.wait()
        self._probe.stdin.close()
        try:
            self._probe.wait(5.0)
        except subprocess.TimeoutExpired:
            self._probe.kill()
            self._probe.wait()
        self._output.close()

    def _read_events(self) -> None:
        for line in self._probe.stdout:
            self._events.put(json.loads(line))


def measure_start() -> dict:
    """Fly in real time; return how long start, hover and end took, CPU and memory."""
    with _experiment() as (graph, _):
        launch_s = graph.wait_for("first_scan_through", HOVER_PATIENCE_S)
        launch_cpu_s = graph.cpu_s()
        hover_s = graph.wait_for("hovering", HOVER_PATIENCE_S)
        cpu_s, began_s = graph.cpu_s(), time.monotonic()
        time.sleep(LOAD_S)
        cores = (graph.cpu_s() - cpu_s) / (time.monotonic() - began_s)
        memory_gb = graph.memory_gb()
        return {
            "launch_s": launch_s,
            "launch_cpu_s": launch_cpu_s,
            "hover_s": hover_s,
            "cpu_cores_at_rtf1": cores,
            "memory_gb": memory_gb,
            "shutdown_s": graph.interrupt(),
        }


def measure_speed() -> dict:
    """Fly in lockstep, as fast as possible; return the real-time factor from goal sent to goal reached.

    cpu_s_per_s: CPU time of the whole graph for a simulated second, which other load changes less.
    """
    with _experiment("lockstep:=true", "real_time_factor:=0") as (graph, results):
        graph.wait_for("hovering", END_PATIENCE_S)
        cpu_s = -graph.cpu_s()
        graph.wait_for("goal_reached", END_PATIENCE_S)
        cpu_s += graph.cpu_s()
        graph.wait_for_end(END_PATIENCE_S)
        found = sorted(results.glob("experiment_1/*/result.json"))
        if not found:
            raise GraphError(f"The flight in lockstep left no result; it said:\n{graph.said()}")
        result = json.loads(found[-1].read_text())
        if not result["success"]:
            raise GraphError(f"The flight in lockstep failed: {result['failure']}")
        return {
            "rtf": result["real_time_factor"],
            "cpu_s_per_s": cpu_s / result["flight_time_s"],
            "lockstep_misses": result["lockstep_misses"],
            "latency_ms": result["latency_ms"]["median"],
        }


@contextmanager
def _experiment(*arguments: str) -> Iterator[tuple[Graph, Path]]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ports = (f"offboard_port:={_free_port(udp=True)}", f"gcs_port:={_free_port(udp=True)}")
        graph = Graph(
            folder,
            *("master_thesis", "experiment_1.launch", "scenario:=forest", "headless:=true"),
            *(f"results:={folder / 'results'}", *ports, *arguments),
        )
        try:
            yield graph, folder / "results"
        finally:
            graph.close()


def _free_port(udp: bool = False) -> int:
    with socket.socket(type=socket.SOCK_DGRAM if udp else socket.SOCK_STREAM) as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]
