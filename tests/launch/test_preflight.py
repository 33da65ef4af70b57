"""real.launch and the checks of the bench, beside the simulator in the place of the hardware's drivers."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest

from flights.graph.free_ports import free_ports

pytestmark = pytest.mark.ros

ROOT = Path(__file__).resolve().parents[2]
PREFLIGHT = str(ROOT / "devel/lib/doctor/preflight")
HALLWAY = ROOT / "src/extensions/flights/worlds/hallway.world"
BESIDE_WALL = "y:=1.1"
"""The hallway is 3 m wide, so the left wall is at 0.4 m."""
PATIENCE_S = 120.0


@pytest.mark.long
@pytest.mark.timeout(600)
def test_the_bench_passes_with_our_nodes_and_gives_way_to_a_board(ros_master):
    ports = (f"{name}:={port}" for name, port in zip(("offboard_port", "gcs_port"), free_ports(2)))
    ros_master.start(
        *["roslaunch", "simulation_tools", "sitl.launch"], f"world:={HALLWAY}", BESIDE_WALL, *ports
    )
    said = checked(ros_master, "passed  lidar:", "--listen", "2")
    assert "failed  avoidance: 0 messages a second on /scan/padded" in said
    assert "failed  frames: TF does not lead from base_frame to hokuyo." in said
    ros_master.start("roslaunch", "flights", "real.launch", "lidar:=ust")
    said = all_passed(ros_master, "--listen", "3")
    assert "passed  avoidance:" in said
    assert "passed  commands:" in said
    assert "passed  flight controller: MAVROS is connected, the UAV is disarmed" in said
    said = checked(ros_master, "passed  board:", "--board", "--listen", "3")
    assert "CEPA gives way to a board to the left." in said


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["90"], "passed  turn: odometry and the lidar's view turned by the same 90 degrees."),
        (["90", "mirrored"], "failed  turn: odometry turned by 90 degrees, the view by -90. -> Do not fly."),
    ],
    ids=["to the left", "mirrored"],
)
def test_a_turn_by_hand(ros_master, words, wanted):
    ros_master.start(sys.executable, str(Path(__file__).with_name("turning_uav.py")), *words)
    checked(ros_master, wanted, "--turn", "--listen", "4")


@pytest.mark.parametrize(
    ("check", "silent"),
    [
        ("--board", "/scan and /UAV/vel_setpoint/safe/body"),
        ("--turn", "/scan and /UAV/odometry"),
    ],
)
def test_without_drivers_the_missing_topics_are_named(ros_master, check, silent):
    run = ros_master.run(PREFLIGHT, check, "--listen", "0.5", timeout_s=PATIENCE_S)
    assert f"preflight: Nothing came on {silent} in 0.5 s. Let all other checks pass first: " in run.stdout
    assert run.returncode == 2


def test_a_board_without_cepa_names_its_commands(ros_master):
    ros_master.start(sys.executable, str(Path(__file__).with_name("turning_uav.py")), "90")
    checked(ros_master, "Nothing came on /UAV/vel_setpoint/safe/body in 2 s.", "--board", "--listen", "2")


def checked(ros_master, wanted: str, *words: str) -> str:
    """Call preflight until it says what is wanted: the nodes need a while to start, in any order."""
    return _said_at_last(ros_master, lambda said: wanted in said, words)


def all_passed(ros_master, *words: str) -> str:
    """Call preflight until all passes. What else this machine does is no fault of the bench."""
    return _said_at_last(
        ros_master, lambda said: "failed" not in said.replace("failed  computer:", "busy"), words
    )


def _said_at_last(ros_master, is_enough, words) -> str:
    end_s = time.monotonic() + PATIENCE_S
    while True:
        said = ros_master.run(PREFLIGHT, *words, timeout_s=PATIENCE_S).stdout
        if is_enough(said):
            return said
        assert time.monotonic() < end_s, said
