"""A flight of the whole graph, started as a user starts it: with roslaunch."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path

import numpy as np

from master_thesis.graph.free_ports import free_ports

READY_PATIENCE_S = 150.0  # quiet machines need 12 s
OWN_MACHINE = 0.2  # share of the processors that somebody else may use on a machine of one's own


def busy() -> str | None:
    """Return why times of the wall clock say nothing now, or None on a machine of one's own; takes 0.5 s.

    To be asked while the flight in question is not there.
    """
    before = processor_times()
    time.sleep(0.5)
    busy_s, all_s = (after - earlier for after, earlier in zip(processor_times(), before))
    share = busy_s / max(all_s, 1)
    return f"others use {100 * share:.0f} % of the processors" if share > OWN_MACHINE else None


def processor_times() -> tuple[int, int]:
    """Return (time at work, time in all) of all processors since the machine started, in ticks."""
    times = [int(word) for word in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
    return sum(times) - sum(times[3:5]), sum(times)  # less idle and waiting for the disk


class Flight:
    """One `roslaunch master_thesis ...` with ports and a results folder of its own."""

    def __init__(self, processes, folder: Path, launch_file: str, **args) -> None:
        master, offboard, ground = free_ports(3)
        processes.environment["ROS_MASTER_URI"] = f"http://localhost:{master}"
        self.folder = folder
        ports = {"offboard_port": offboard, "gcs_port": ground, "results": folder / "results"}
        words = [f"{name}:={value}" for name, value in {**ports, **args}.items()]
        self._log = (folder / "roslaunch.log").open("w")
        command = ("roslaunch", "-p", str(master), "master_thesis", launch_file, *words)
        self.started_s = time.monotonic()
        self._process = processes.start(*command, stdout=self._log, stderr=self._log)

    @property
    def said(self) -> str:
        """What roslaunch and the nodes have printed so far."""
        return (self.folder / "roslaunch.log").read_text(errors="replace")

    def wait_until_said(self, words: str, patience_s: float) -> None:
        end_s = time.monotonic() + patience_s
        while words not in self.said:
            assert self._process.poll() is None, f"it ended before it said '{words}':\n{self.said}"
            assert time.monotonic() < end_s, f"it did not say '{words}' within {patience_s} s:\n{self.said}"
            time.sleep(0.05)

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def wait(self, patience_s: float) -> float:
        """Wait for its end; returns how long that took, s."""
        started_s = time.monotonic()
        self._process.wait(patience_s)
        return time.monotonic() - started_s

    @property
    def results(self) -> Path:
        (folder,) = (self.folder / "results").glob("*/*")
        return folder

    @property
    def result(self) -> dict:
        return json.loads((self.results / "result.json").read_text())

    def series(self, name: str) -> np.ndarray:
        return np.genfromtxt(
            self.results / f"{name}.csv", delimiter=",", names=True, dtype=None, encoding=None
        )
