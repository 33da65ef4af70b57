"""ROS's own tools know our messages: `rostopic` and `rosservice` run by Debian's Python."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DEBIANS_PYTHON = "/usr/bin/python3"
LOAD = """
import sys
sys.modules["numpy"] = None  # Debian's Python may have no numpy
from roslib.message import get_message_class, get_service_class
kinds = {"msg": get_message_class, "srv": get_service_class}
for given in sys.argv[1:]:
    kind, name = given.split(":")
    assert kinds[kind](name), name
"""

pytestmark = pytest.mark.ros


def interfaces() -> list[str]:
    """Return each message and service of the workspace, as `msg:PACKAGE/NAME`."""
    found = []
    for path in sorted(ROOT.glob("src/**/*.[ms][sr][gv]")):
        found.append(f"{path.suffix[1:]}:{path.parts[-3]}/{path.stem}")
    for path in sorted(ROOT.glob("src/**/action/*.action")):
        kinds = ("Action", "ActionFeedback", "ActionGoal", "ActionResult", "Feedback", "Goal", "Result")
        found += [f"msg:{path.parts[-3]}/{path.stem}{kind}" for kind in kinds]
    return found


def test_debians_python_loads_every_message_without_numpy():
    given = interfaces()
    assert {"msg:gridslam/VoxelTiles", "srv:inspection/LookCloser"} <= set(given)
    run = subprocess.run(
        [DEBIANS_PYTHON, "-c", LOAD, *given], capture_output=True, text=True, check=False, timeout=120.0
    )
    assert run.returncode == 0, run.stderr[-1000:]
