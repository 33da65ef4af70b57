"""Without GNSS no launch file lets the truth reach a node that flies the UAV."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip("roslaunch", reason="ROS is not installed")
from launch_files import load

pytestmark = pytest.mark.ros

ROOT = Path(__file__).resolve().parents[2]
MADE_OF_TRUTH = {"/UAV/ground_truth", "/gazebo/odometry", "/imu", "/gazebo/model_states"}
SOURCE, JUDGE_AND_WORLD_EDGE = "gazebo", {"experiment", "tf_publisher"}
NEEDED = {"fly_to_goal.launch": ("world:=/x.world", "goal:=1 0 2")}
FLIGHTS = {"fly_to_goal.launch", "teleop.launch", "sitl.launch"} | {
    f"experiment_{n}.launch" for n in (1, 2, 3, 4)
}


def has_argument(path: Path) -> bool:
    return any(
        arg.get("name") == "gnss" and arg.get("default") for arg in ElementTree.parse(path).iter("arg")
    )


FILES = sorted(path for path in ROOT.glob("src/**/launch/*.launch") if has_argument(path))


def test_every_flight_can_be_flown_without_gnss():
    assert {path.name for path in FILES} >= FLIGHTS


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_truth_reaches_nobody_but_the_judge_and_the_world_edge(path, monkeypatch):
    monkeypatch.setenv("LAUNCH_CHECKED", "1")
    config = load(path, "gnss:=false", *NEEDED.get(path.name, ()))
    parameters = {name: parameter.value for name, parameter in config.params.items()}
    for node in config.nodes:
        topics = {topic for _, topic in node.remap_args}
        if node.name == SOURCE:
            assert "/UAV/odometry" not in topics, "the simulator's odometry is made of the truth"
        elif topics & MADE_OF_TRUTH and node.name not in JUDGE_AND_WORLD_EDGE:
            # These listen to the pose of their `pose_source` alone.
            assert parameters[f"/{node.name}/pose_source"] in ("odometry", "slam"), node.name
