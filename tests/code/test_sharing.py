"""How conftest.py shares the machine among tests, and that an interrupted run leaves no process behind."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

SOME_ALONE = """
import time, pytest

def note(name, act):
    began = time.monotonic()
    act()
    with open("times", "a") as file:
        file.write(f"{name} {began} {time.monotonic()}\\n")

@pytest.mark.parametrize("n", range(2))
def test_among_others(n):
    note("shared", lambda: time.sleep(0.4))

@pytest.mark.realtime
def test_alone():
    note("alone", lambda: time.sleep(0.2))
"""
ONE_THAT_WAITS = """
import time
from pathlib import Path

def test_waits(processes):
    child = processes.start("sleep", "600")
    Path("pid.new").write_text(str(child.pid))
    Path("pid.new").rename("pid")
    time.sleep(600)
"""


@pytest.fixture
def start(tmp_path, processes):
    """Start pytest on these tests in a workspace of their own; returns the process."""

    def run(tests: str) -> subprocess.Popen:
        for name in ("conftest.py", "pyproject.toml"):
            shutil.copy(ROOT / name, tmp_path)
        (tmp_path / "tests").mkdir()
        # One file a process, as `loadfile` shares them out
        for number in range(2):
            (tmp_path / f"tests/test_{number}.py").write_text(tests)
        for name in [
            name for name in processes.environment if name.startswith(("PYTEST_", "WORKSPACE_TEST_RUN"))
        ]:
            del processes.environment[name]
        options = ("-n", "2", "--dist", "loadfile", "--no-loadscope-reorder", "-p", "no:cacheprovider")
        command = (sys.executable, "-m", "pytest", *options, "tests")
        return processes.start(*command, cwd=tmp_path, stdout=subprocess.DEVNULL)

    return run


def test_nobody_runs_beside_a_test_of_wall_time(start, tmp_path):
    assert start(SOME_ALONE).wait(100.0) == 0
    lines = (tmp_path / "times").read_text().splitlines()
    times = [(name, float(began), float(ended)) for name, began, ended in map(str.split, lines)]
    assert len(times) == 6
    beside = {
        frozenset((name, other))
        for index, (name, began, ended) in enumerate(times)
        for other, other_began, other_ended in times[index + 1 :]
        if began < other_ended and other_began < ended
    }
    assert beside == {frozenset(("shared",))}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
def test_an_interrupted_run_leaves_nothing_behind(start, tmp_path, number):
    run = start(ONE_THAT_WAITS)
    end_s = time.monotonic() + 60.0
    while not (tmp_path / "pid").exists():
        assert time.monotonic() < end_s, "the test does not start"
        time.sleep(0.05)
    if number == signal.SIGINT:
        os.killpg(run.pid, number)  # a terminal tells all of them
    else:
        run.send_signal(number)
    assert run.wait(60.0) == pytest.ExitCode.INTERRUPTED
    assert not Path("/proc", (tmp_path / "pid").read_text()).exists()
