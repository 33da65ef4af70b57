"""Draws the running graph into a folder: nodes and topics, and the TF tree, each as SVG and PNG."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

import rospy

from doctor import drawing
from doctor.snapshot import Graph
from doctor_ros import live
from flights.errors import FlightsError

OBSERVERS = ("rosout", "experiment_recorder", "rviz", "record_")
DOTS_PER_INCH = 160
DRAWING_S = 120.0
"""Wall time in which graphviz draws a graph."""


def main() -> int:
    """Look at the graph and draw it; returns the exit code."""
    parser = argparse.ArgumentParser(prog="rosrun doctor draw_graph", description=__doc__)
    parser.add_argument("folder", type=Path, help="folder for nodes.svg, nodes.png, tf.svg and tf.png")
    parser.add_argument("--listen", type=float, default=5.0, metavar="S", help="seconds (default 5)")
    parser.add_argument("--hide", nargs="*", default=(), metavar="NODE", help="nodes to leave out")
    arguments = parser.parse_args(rospy.myargv()[1:])
    try:
        for path in _draw(arguments):
            print(path)
    except FlightsError as error:
        print(f"draw_graph: {error}", file=sys.stderr)
        return 1
    return 0


def _draw(arguments: argparse.Namespace) -> list[Path]:
    if not shutil.which("dot"):
        raise FlightsError("graphviz is missing: sudo apt-get install graphviz.")
    graph = live.look(arguments.listen)
    hidden = {f"/{name.lstrip('/')}" for name in arguments.hide}
    observers = {node.name for node in graph.nodes if node.name.lstrip("/").startswith(OBSERVERS)} | hidden
    sources = {
        "nodes": drawing.node_graph(graph, _wires(graph), observers),
        "tf": drawing.tf_tree(graph.recording),
    }
    try:
        arguments.folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FlightsError(f"Cannot write to {arguments.folder}: {error.strerror}.") from None
    return [
        _render(source, arguments.folder / f"{name}.{kind}")
        for name, source in sources.items()
        for kind in ("svg", "png")
    ]


def _wires(graph: Graph) -> list[drawing.Wire]:
    """Return MAVROS's link to its flight controller, from the parameters."""
    if not any(node.name == "/mavros" for node in graph.nodes):
        return []
    url = rospy.get_param("/mavros/fcu_url", "") or f"udp {rospy.get_param('/mavros/offboard_port', '')}"
    who = {"standin": "\nPX4 stand-in,\nwithin gazebo", "px4": "\nPX4 SITL"}
    kind = who.get(rospy.get_param("/gazebo/autopilot", ""), "")
    return [drawing.Wire("/mavros", "fcu", f"flight controller{kind}\n(MAVLink 2, {url})")]


def _render(source: str, path: Path) -> Path:
    """Let graphviz draw a file in the format of its suffix."""
    resolution = () if path.suffix == ".svg" else (f"-Gdpi={DOTS_PER_INCH}",)
    command = ["dot", f"-T{path.suffix[1:]}", *resolution, "-o", str(path)]
    try:
        done = subprocess.run(
            command, input=source, text=True, stderr=subprocess.PIPE, check=False, timeout=DRAWING_S
        )
    except subprocess.TimeoutExpired:
        raise FlightsError(f"dot did not draw {path} within {DRAWING_S:g} s.") from None
    if done.returncode != 0:
        raise FlightsError(f"dot could not draw {path}: {done.stderr.strip()}.")
    return path
