"""A real UAV explores and inspects with the nodes and parameters that do so beside the simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("roslaunch", reason="needs the workspace's environment")

import launch_files

LAUNCH = Path(__file__).resolve().parents[2] / "src/extensions/flights/launch"
REAL = ("gnss:=false", "lidar:=puck", "sensors:=range_finder range_finder_up", "fly:=true", "speed:=1.5")
ONLY_SIMULATED = {"gazebo", "mavros", "experiment", "camera", "camera_mavlink"}
OWN = {"explore/lockstep", "inspect/lockstep", "explore/held_by", "inspect/held_by", "inspect/drawing_home"}
"""Parameters that differ because time, battery and start are not simulated."""


def loaded(name, *words):
    """The names of its nodes, and the parameters of those that lead, map and avoid."""
    config = launch_files.load(LAUNCH / name, *words)
    kinds = ("/explore/", "/inspect/", "/cepa/", "/gridslam/", "/slam_octomap/", "/position_controller/")
    values = {key: one.value for key, one in config.params.items() if key.startswith(kinds)}
    return {node.name for node in config.nodes}, values


@pytest.mark.parametrize(
    ("simulated", "real"),
    [
        (("explore.launch", "speed:=1.5"), ("explore:=true",)),
        (
            ("inspection.launch", "drawing:=/a.stl"),
            ("inspection:=true", "drawing:=/a.stl", "time:=3600"),
        ),
    ],
    ids=["explore", "inspection"],
)
def test_it_starts_the_same_nodes_with_the_same_parameters(simulated, real):
    nodes, parameters = loaded(*simulated)
    real_nodes, real_parameters = loaded("real.launch", *REAL, *real)
    assert nodes - ONLY_SIMULATED <= real_nodes
    assert real_nodes - nodes == {"pilot_orders"}
    differing = {
        key.strip("/")
        for key in parameters.keys() | real_parameters.keys()
        if parameters.get(key) != real_parameters.get(key)
    }
    assert differing - OWN == set()


def test_a_model_brings_its_radius_its_margin_and_what_follows_from_them():
    """CEPA's cushions, the planner's distances and the map's voxels are those of explore.launch."""
    small = "model:=small_quad", "lidar:=qt64"
    parameters = loaded("explore.launch", *small, "speed:=1.5")[1]
    real_parameters = loaded("real.launch", *REAL, *small, "explore:=true")[1]
    assert parameters["/explore/planner/radius"] == 0.2
    assert {key: real_parameters[key] for key in parameters if key.strip("/") not in OWN} == {
        key: value for key, value in parameters.items() if key.strip("/") not in OWN
    }


def test_a_recorder_runs_on_request():
    assert "record" in loaded("real.launch", "record:=true")[0]
    assert "record" not in loaded("real.launch")[0]


def test_keep_out_boxes_and_loop_closure_also_count_when_the_pilot_leads(tmp_path):
    limits = tmp_path / "limits.yaml"
    limits.write_text("ceiling: 3.0\n")
    parameters = loaded("real.launch", "slam:=true", f"limits:={limits}", "loop_closure:=false")[1]
    assert parameters["/cepa/limits/ceiling"] == 3.0
    assert parameters["/gridslam/loop_closure"] is False
