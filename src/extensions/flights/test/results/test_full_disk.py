"""A disk that is full while the results are written: a sentence, and never a half result with success."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from flights import files
from flights.errors import ResultsError
from flights.flight.course import PhaseLimits
from flights.flight.description import RunDescription
from flights.flight.judging.contacts import UavParts
from flights.flight.monitor import Monitor
from flights.results import run_files, run_pictures
from flights.results.run_folder import INCOMPLETE, RunFolder
from flights.worlds.scenario import scenario

ROOT = Path(__file__).resolve().parents[5]


@pytest.fixture
def folder(tmp_path):
    return RunFolder(tmp_path, "experiment_1", datetime(2026, 11, 28, 12))


def told(folder):
    return json.loads((folder.path / "result.json").read_text())


def landed():
    """A run that stands at its goal, and is landed well."""
    monitor = Monitor(PhaseLimits(), UavParts("iris", frozenset()))
    monitor.course.on_ready(True)
    for step in range(1000):
        monitor.on_truth(0.01 * step, (0.0, 0.0, 0.12), (0.0, 0.0, 0.0, 1.0))
        if step == 500:
            monitor.on_goal_reached(True)
    monitor.on_armed(False)
    assert monitor.course.outcome.success
    return monitor


def write_all(folder, description, monitor):
    """Write everything as the driver does: numbers and series, the rest, and at last the success."""
    flown = folder, description, monitor.log, monitor.course.outcome
    content = run_files.write_numbers(*flown, monitor.wall_metrics(0.0))
    content = run_files.complete_run(*flown, content)
    return folder.write_result(content, is_whole=True)


class FullDisk:
    """Lets so many files be written; then the disk is full."""

    def __init__(self, monkeypatch, room):
        self.room, self._fsync = room, os.fsync
        monkeypatch.setattr(files.os, "fsync", self)

    def __call__(self, handle):
        if self.room == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= 1
        self._fsync(handle)


def test_success_is_the_last_thing_that_is_written_wherever_the_disk_gets_full(
    monkeypatch, tmp_path, worlds_folder
):
    description = RunDescription("experiment_1", scenario("empty", worlds_folder), "improved", "ust", 1)
    nearest, pictures = np.array([[0.0, 1.0], [1.0, 0.9]]), {"flight.png": b"picture", "flight.pdf": b"pages"}
    monkeypatch.setattr(run_files.clearance, "clearances_of_flight", lambda *_: nearest)
    monkeypatch.setattr(run_pictures, "write_pictures", lambda folder, _: folder.write_files(pictures))
    monitor, disk = landed(), FullDisk(monkeypatch, 10_000)
    assert write_all(RunFolder(tmp_path, "whole", datetime.now()), description, monitor)["success"]
    needed = 10_000 - disk.room
    assert needed > 10
    for room in range(needed):
        folder = RunFolder(tmp_path, f"room_{room}", datetime.now())
        disk.room = room
        with pytest.raises(
            ResultsError, match=r"Cannot write .*: No space left on device; free some space or"
        ):
            write_all(folder, description, monitor)
        if room:
            assert told(folder)["success"] is False
            assert told(folder)["failure"] == INCOMPLETE
        assert not [path for path in folder.path.iterdir() if path.name.startswith(".")]


def test_a_success_is_told_when_everything_is_whole(folder):
    content = {"success": True, "failure": None}
    assert folder.write_result(content) == {"success": False, "failure": INCOMPLETE}
    assert told(folder)["success"] is False
    assert folder.write_result(content, is_whole=True) == content
    assert told(folder) == content


def test_a_missing_part_is_no_success_and_says_why(folder):
    folder.lacks("There is no map.bt: the disk is full.")
    found = folder.write_result({"success": True, "failure": None}, is_whole=True)
    assert found == told(folder) == {"success": False, "failure": "There is no map.bt: the disk is full."}
    found = folder.write_result({"success": False, "failure": "The UAV touched a tree."}, is_whole=True)
    assert found["failure"] == "The UAV touched a tree."


def test_what_the_user_leaves_out_by_ctrl_c_is_no_failure_but_what_is_missing_is(folder):
    numbers = {"success": True, "failure": None}
    folder.write_result(numbers)
    folder.write_result({**numbers, "slam": {"ate_m": 0.1}})  # what was computed until then stays
    found = folder.seal(1.0, "pictures")
    assert found == told(folder) == {**numbers, "slam": {"ate_m": 0.1}, "left_out": "pictures"}


def test_a_part_that_is_missing_is_missing_after_ctrl_c_too(folder):
    folder.write_result({"success": True, "failure": None})
    folder.lacks("There is no map.bt: the disk is full.")
    assert folder.seal(1.0, "pictures")["success"] is told(folder)["success"] is False


RESULT = {
    "experiment": "experiment_1",
    "scenario": "empty",
    "algorithm": "improved",
    "lidar": "ust",
    "seed": 1,
    **dict.fromkeys(("cepa_computation_ms", "latency_ms", "flight_time_s", "path_length_m")),
    **dict.fromkeys(("min_clearance_m", "real_time_factor", "landing_error_m", "failure")),
    **dict.fromkeys(("reached_goal", "landed", "success"), True),
    "collision": False,
}


@pytest.mark.table(
    ("success", "launch_code", "code", "words"),
    [
        (True, ("0",), 0, "Results in"),
        (True, ("1",), 1, "roslaunch gave up with code 1, so the run failed"),
        (False, ("0",), 1, "The run failed; see result.json"),
    ],
)
def test_a_failure_of_roslaunch_is_never_outvoted_by_result_json(tmp_path, success, launch_code, code, words):
    path = tmp_path / "result.json"
    path.write_text(json.dumps({**RESULT, "success": success}))
    command = (sys.executable, str(ROOT / "scripts/summarise.py"), str(path), *launch_code)
    folders = [*map(str, ROOT.glob("src/**/src")), *os.environ.get("PYTHONPATH", "").split(":")]
    environment = {**os.environ, "PYTHONPATH": ":".join(folders)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == code, done.stderr
    assert words in done.stdout
