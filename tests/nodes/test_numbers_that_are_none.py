"""No number of a message is used before it is known to be finite: nodes survive NaN, infinity and 1e308.

Each real number of each message that a node hears takes each of these values once, among messages that make
sense.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

pytest.importorskip("rosgraph", reason="needs ROS")
pytestmark = pytest.mark.ros

PROBE = Path(__file__).with_name("nonsense_probe.py")
NODES = {
    "cepa": "cepa",
    "cepa_visualiser": "cepa",
    "lidar_odometry": "gridslam",
    "slam_gridslam": "gridslam",
    "slam_octomap": "gridslam",
    "explore": "exploration",
    "inspect": "inspection",
    "level_beams": "inspection_tools",
    "lidar_median_filter": "inspection_tools",
    "lidar_padding": "inspection_tools",
    "mission": "inspection_tools",
    "path_planner": "exploration",
    "position_controller": "inspection_tools",
    "survey_coverage": "inspection",
    "vision_pose_publisher": "inspection_tools",
    "yaw_regulator": "inspection_tools",
    "mavros_publisher": "simulation_tools",
    "tf_publisher": "simulation_tools",
}
"""Their packages. gazebo and mavros have tests of their own for what they are sent."""
ALIVE = None  # Popen's code of a process that runs


@pytest.fixture(scope="module")
def nodes(master_of_module, tmp_path_factory):
    """The nodes that run, with what the probe has sent to each and the files of what they say."""
    folder = tmp_path_factory.mktemp("said")
    started = {}
    for node, package in NODES.items():
        with (folder / node).open("w") as said:
            started[node] = master_of_module.start_node(
                package, node, f"__name:={node}", stdout=said, stderr=said
            )
    names = [f"/{node}" for node in NODES]
    probe = master_of_module.run(sys.executable, str(PROBE), *names, timeout_s=400.0)
    assert probe.returncode == 0, probe.stdout
    sent = json.loads(probe.stdout.splitlines()[-1])
    return {node: (started[node], sent[f"/{node}"], (folder / node).read_text()) for node in NODES}


@pytest.mark.long
@pytest.mark.timeout(500.0)
@pytest.mark.parametrize("node", NODES)
def test_a_node_survives_them(nodes, node):
    process, sent, said = nodes[node]
    assert sum(sent.values()) > 0, f"{node} heard nothing: {said}"
    assert process.poll() is ALIVE, said
    assert "Traceback" not in said, said
    assert "bad callback" not in said, said
