"""The pictures of a running graph: who is drawn, who is not, and that graphviz can read them."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

from doctor.drawing import MANY_EARS, Wire, node_graph, tf_tree
from doctor.snapshot import Graph, Node, Recording, Topic, Transform

TOPICS = (
    Topic("/scan", "sensor_msgs/LaserScan", ("/gazebo",), ("/filter", "/watcher", "/recorder")),
    Topic("/scan/filtered", "sensor_msgs/LaserScan", ("/filter",), ("/padding",)),
    Topic("/clock", "rosgraph_msgs/Clock", ("/gazebo",), ("/filter",)),
    Topic("/rosout", "rosgraph_msgs/Log", ("/filter",), ("/rosout",)),
    Topic("/filter/parameter_updates", "dynamic_reconfigure/Config", ("/filter",), ("/watcher",)),
    Topic("/debug", "std_msgs/Bool", ("/filter",), ("/recorder",)),
    *(Topic(f"/told_{number}", "std_msgs/Bool", ("/gazebo",), ("/watcher",)) for number in range(MANY_EARS)),
)
GRAPH = Graph(
    Recording({topic.name: topic for topic in TOPICS}),
    (
        Node("/filter", True, "inspection_tools"),
        Node("/padding", True, "inspection_tools"),
        Node("/gazebo", True, "simulation_tools"),
        Node("/watcher"),
        Node("/recorder"),
        Node("/rosout"),
    ),
)
STATIC = Transform("base_frame", "hokuyo", "/tf_publisher", True, (1.0,), (1.0,))
MOVING = Transform("odom", "base_frame", "/tf_publisher", False, (1.0, 1.5, 2.0), (1.0, 1.5, 2.0))
TREE = tf_tree(Recording(transforms=(STATIC, MOVING)))
WIRE = Wire("/padding", "fcu", 'flight "controller"\nMAVLink')
PICTURE = node_graph(GRAPH, (WIRE,), observers=("/recorder",))


def arrows(source: str) -> set[tuple[str, str]]:
    return set(re.findall(r'"([^"]+)" -> "([^"]+)"', source))


def test_arrows_lead_from_node_to_topic_to_node():
    assert arrows(PICTURE) == {
        ("/gazebo", "topic /scan"),
        ("topic /scan", "/filter"),
        ("/filter", "topic /scan/filtered"),
        ("topic /scan/filtered", "/padding"),
        ("/padding", "fcu"),
    }


@pytest.mark.table("hidden", ["/clock", "/rosout", "parameter_updates", "/debug", "/recorder"])
def test_what_says_nothing_is_left_out(hidden):
    assert hidden not in PICTURE


def test_who_hears_everything_has_words_in_place_of_arrows():
    label = next(line for line in PICTURE.splitlines() if "subscribes to" in line)
    assert all(f"/told_{number}<" in label for number in range(MANY_EARS))
    assert "/scan<" in label


def test_nodes_of_a_package_that_talk_among_themselves_stand_in_one_frame():
    frames = re.findall(r"subgraph cluster_\d+ \{(.*?)\n  \}", PICTURE, re.DOTALL)
    tools = next(frame for frame in frames if "inspection_tools" in frame)
    assert tools.count("[label") == 3  # two nodes and their topic
    assert len(frames) == 3


def test_the_tree_tells_who_publishes_and_how_often():
    assert arrows(TREE) == {("odom", "base_frame"), ("base_frame", "hokuyo")}
    assert "tf_publisher, 2 Hz" in TREE
    assert "tf_publisher, static" in TREE
    assert '"base_frame" -> "hokuyo" [style=dashed]' in TREE


@pytest.mark.skipif(not shutil.which("dot"), reason="needs graphviz: ./bringup.sh setup")
@pytest.mark.parametrize("source", [PICTURE, TREE], ids=["nodes", "tf"])
def test_graphviz_draws_it(source):
    done = subprocess.run(["dot", "-Tsvg"], input=source, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "</svg>" in done.stdout
