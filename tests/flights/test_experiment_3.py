"""Experiment 3's beginning through the whole graph: the flight waits for SLAM, and its map is written."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import pytest
from launched_flight import READY_PATIENCE_S, Flight

pytestmark = [pytest.mark.ros, pytest.mark.flight]

DURATION_S = 5.0
ATE_MAX_M = 0.1
"""What the experiment asks for over four minutes."""


def slam_of(environment: dict) -> int:
    """Return the process of the SLAM node under a ROS master, as soon as there is one."""
    port = environment["ROS_MASTER_URI"].rpartition(":")[2]
    master = re.compile(rf"\0ROS_MASTER_URI=http://[^\0]*:{port}/?\0".encode())  # by the machine's own name
    end_s = time.monotonic() + READY_PATIENCE_S
    while time.monotonic() < end_s:
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                is_slam = b"/slam_gridslam\0" in (folder / "cmdline").read_bytes()
                if is_slam and master.search(b"\0" + (folder / "environ").read_bytes()):
                    return int(folder.name)
            except OSError:  # it has ended
                continue
        time.sleep(0.05)
    raise AssertionError(f"no SLAM node was started within {READY_PATIENCE_S} s")


@pytest.mark.long
def test_the_mission_begins_when_slam_does_and_the_map_is_true(processes, tmp_path):
    flight = Flight(
        processes, tmp_path, "experiment_3.launch", lidar="urg", headless="true", duration=DURATION_S, seed=2
    )
    # given a SLAM node that is still not ready when the UAV is
    slam = slam_of(processes.environment)
    os.kill(slam, signal.SIGSTOP)
    try:
        flight.wait_until_said("SLAM has not begun yet", READY_PATIENCE_S)
        assert "begins its mission" not in flight.said
    finally:
        os.kill(slam, signal.SIGCONT)
    # when it comes
    flight.wait_until_said("begins its mission", READY_PATIENCE_S)
    flight.wait_until_said("Measuring the clearance", READY_PATIENCE_S)  # SLAM's files and numbers are there
    flight.interrupt()
    flight.wait(200.0)
    # then the mission is flown for as long as was asked for, and the map is that of the room
    result = flight.result
    assert result["success"], result["failure"]
    assert "Traceback" not in flight.said
    assert result["flight_time_s"] == pytest.approx(DURATION_S, abs=1.0)
    assert result["slam"]["ate_rmse_m"] < ATE_MAX_M
    assert result["slam"]["map_error_mean_m"] < ATE_MAX_M
    assert {"map.pgm", "map.yaml", "map.png"} <= {path.name for path in flight.results.iterdir()}
