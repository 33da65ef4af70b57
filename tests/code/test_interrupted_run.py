"""An interrupted run of the tests leaves no process behind."""

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

ONE_THAT_WAITS = """
import time
from pathlib import Path

def test_waits(processes):
    child = processes.start("sleep", "600")
    Path("pid.new").write_text(str(child.pid))
    Path("pid.new").rename("pid")
    time.sleep(600)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
def test_an_interrupted_run_leaves_nothing_behind(processes, tmp_path, number):
    for name in ("conftest.py", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests/test_one.py").write_text(ONE_THAT_WAITS)
    for name in tuple(processes.environment):
        if name.startswith(("PYTEST_", "WORKSPACE_TEST_RUN")):
            del processes.environment[name]
    command = (sys.executable, "-m", "pytest", "-n", "1", "-p", "no:cacheprovider", "tests")
    run = processes.start(*command, cwd=tmp_path, stdout=subprocess.DEVNULL)
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
