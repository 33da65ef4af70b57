"""RViz starts where it can be seen; elsewhere one sentence, and no failure."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[1] / "nodes/rviz_if_display"


def start(*arguments, before=(), path=None, **environment):
    kept = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    return subprocess.run(
        [*before, sys.executable, str(PROGRAM), *arguments],
        env={**kept, **environment, "PATH": path or kept["PATH"]},
        capture_output=True,
        text=True,
        timeout=30.0,
    )


@pytest.mark.table(
    ("environment", "why"), [({}, "DISPLAY is not set"), ({"DISPLAY": ":9876"}, "DISPLAY=:9876")]
)
def test_without_a_display_it_says_so_and_ends_well(environment, why):
    run = start("-d", "some.rviz", **environment)
    assert run.returncode == 0
    assert run.stderr.count("\n") == 1
    assert "RViz is left out, the flight goes on" in run.stderr
    assert why in run.stderr


def test_with_a_display_it_becomes_rviz_with_its_arguments(tmp_path):
    if not shutil.which("xvfb-run"):
        pytest.skip("needs xvfb-run")
    fake = tmp_path / "rviz"
    fake.write_text('#!/bin/sh\necho "$0 $*"\n')
    fake.chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    run = start("-d", "some.rviz", "__name:=rviz", before=["xvfb-run", "-a"], path=path)
    assert run.stdout == f"{fake} -d some.rviz __name:=rviz\n", run.stderr
