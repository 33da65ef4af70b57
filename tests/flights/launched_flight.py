"""A flight of the whole graph, started as a user starts it: with roslaunch or with bringup.sh."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path

import numpy as np

from flights.graph.free_ports import free_ports

ROOT = Path(__file__).resolve().parents[2]
READY_PATIENCE_S = 200.0  # quiet machines need 12 s


class Flight:
    """One flight with ports and a results folder of its own.

    by_bringup: start `bringup.sh` in the folder, with a relative path for the results; else `roslaunch`.
    is_checked: leave out the checks of roslaunch's arguments, as for bringup.sh, which has made them.
    """

    def __init__(
        self,
        processes,
        folder: Path,
        launch_file: str,
        by_bringup: bool = False,
        is_checked: bool = True,
        **args,
    ) -> None:
        master, offboard, ground = free_ports(3)
        processes.environment["ROS_MASTER_URI"] = f"http://localhost:{master}"
        if is_checked and not by_bringup:
            processes.environment["LAUNCH_CHECKED"] = "1"
        self.folder = folder
        results = "results" if by_bringup else folder / "results"
        ports = {"offboard_port": offboard, "gcs_port": ground, "results": results}
        words = [f"{name}:={value}" for name, value in {**ports, **args}.items()]
        self._log = (folder / "roslaunch.log").open("w")
        package = "master_thesis" if launch_file.startswith("experiment_") else "flights"
        roslaunch = ("roslaunch", "-p", str(master), package)
        command = (str(ROOT / "bringup.sh"),) if by_bringup else roslaunch
        self.started_s = time.monotonic()
        self._process = processes.start(
            *command, launch_file, *words, cwd=folder, stdout=self._log, stderr=self._log
        )

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

    def end_without_pictures(self, patience_s: float) -> None:
        """Wait for the numbers of the flight; then interrupt it. Clearance and pictures take long."""
        end_s = time.monotonic() + patience_s
        while self._process.poll() is None and not list((self.folder / "results").glob("*/*/hits.csv")):
            assert time.monotonic() < end_s, f"no numbers were written within {patience_s} s:\n{self.said}"
            time.sleep(0.05)
        self.interrupt()
        self.wait(200.0)

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
