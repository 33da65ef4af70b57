"""A disk that fills while a flight is recorded on it: the flight goes on, and somebody says so."""

from __future__ import annotations

import contextlib
import json
import subprocess
from pathlib import Path

import pytest
from launched_flight import READY_PATIENCE_S, Flight

ROOT = Path(__file__).resolve().parents[1]

pytestmark = [pytest.mark.ros, pytest.mark.flight, pytest.mark.timeout(400)]

SIZE = "230M"  # rosbag does not begin with less than 200 MB


@pytest.fixture
def small_disk(tmp_path):
    """A disk of its own, which goes when the test is over."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)]
    mounted = subprocess.run(mount, capture_output=True, text=True, check=False)
    if mounted.returncode != 0:
        pytest.skip(f"needs to mount a small disk: {mounted.stderr.strip()}")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def test_a_disk_that_fills_up_ends_the_recording_only(processes, tmp_path, small_disk):
    args = {"world": ROOT / "src/master_thesis/worlds/empty.world", "goal": "16 0 2", "record": "true"}
    in_step = {"lockstep": "true", "lockstep_timeout": 30, "real_time_factor": 0}
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", **args, **in_step, results=small_disk)
    flight.wait_until_said("is sent to the goal", READY_PATIENCE_S)
    filler = small_disk / "filler"
    with contextlib.suppress(OSError), filler.open("wb") as file:
        while True:
            file.write(bytes(1 << 20))
    flight.wait_until_said("told to land", 200.0)
    filler.unlink()  # there is room for the results again
    flight.wait(200.0)
    (result,) = small_disk.glob("*/*/result.json")
    assert json.loads(result.read_text())["success"]
    assert "flight.bag" in flight.said.split("told to land")[1]
    assert "Traceback" not in flight.said
