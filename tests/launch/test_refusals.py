"""What cannot be flown ends the launch, and the experiment's node, with a sentence."""

from __future__ import annotations

import socket
import time
from pathlib import Path
from subprocess import PIPE, STDOUT

import pytest
from launched_flight import Flight

from flights.graph.free_ports import free_ports

rosgraph = pytest.importorskip("rosgraph", reason="needs ROS")

ROOT = Path(__file__).resolve().parents[2]
WORLDS = ROOT / "src/extensions/flights/worlds"

pytestmark = pytest.mark.ros


def test_a_world_that_cannot_be_read_ends_the_launch_with_a_sentence(processes, tmp_path):
    world = tmp_path / "broken.world"
    world.write_text('<?xml version="1.0"?>\n<sdf version="1.6"><world')
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", is_checked=False, world=world, goal="9 0 2")
    flight.wait(200.0)
    assert "broken.world:2: " in flight.said
    assert "Traceback" not in flight.said


REFUSED = {
    "algorithm": (
        "_algorithm:=best",
        "There is no algorithm 'best'; choose algorithm:=improved|original|dynamic.",
    ),
    "results": ("_results:=/proc", "Cannot make a results folder in /proc/"),
    "relative results": ("_results:=out", "for example results:=$PWD/out."),
}
"""src/master_thesis/test/launch_arguments looks at all other arguments."""


@pytest.fixture(scope="module")
def refusals(master_of_module):
    """Start the experiment's node with each fault, all at a time; returns (exit code, output) of each."""
    started = {}
    for number, (case, (arg, _)) in enumerate(REFUSED.items()):
        words = (f"__name:=refused_{number}", f"_world:={WORLDS / 'empty.world'}", arg)
        started[case] = master_of_module.start_node(
            "flights", "goal_flight", *words, stdout=PIPE, stderr=STDOUT, text=True
        )
    said = {case: process.communicate(timeout=200.0)[0] for case, process in started.items()}
    return {case: (started[case].returncode, said[case]) for case in REFUSED}


@pytest.mark.parametrize("case", REFUSED)
def test_the_experiment_refuses_in_a_sentence(refusals, case):
    code, said = refusals[case]
    assert code == 1
    assert REFUSED[case][1] in said
    assert "Traceback" not in said


KEPT_TRYING = {
    "mavros": ("simulation_tools", "fcu_url", "serial:/dev/ttyUSB0", "udp://:{port}@127.0.0.1:9"),
    "yaw_regulator": ("inspection_tools", "gain", -1.0, "1.0"),
    "cepa": ("cepa", "algorithm", "best", "original"),
}
"""Nodes by their names: package, a parameter that is wrong, its value, and what mends it."""


def test_a_node_that_keeps_trying_says_so_and_starts_once_it_is_mended(ros_master, tmp_path):
    """As the launch files start the nodes that are respawned: no end, and no flood of messages."""
    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])
    started, logs = {}, {node: tmp_path / f"{node}.log" for node in KEPT_TRYING}
    for node, (package, parameter, wrong, _) in KEPT_TRYING.items():
        words = (f"_{parameter}:={wrong}", "_keep_trying:=true")
        with logs[node].open("w") as log:
            started[node] = ros_master.start_node(package, node, *words, stdout=log, stderr=STDOUT)
    for node, log in logs.items():
        wait_for(lambda log=log: "[FATAL]" in log.read_text(), f"{node} does not say what is wrong")
    (port,) = free_ports(1)
    for node, (_, parameter, _, right) in KEPT_TRYING.items():
        value = float(right) if parameter == "gain" else right.format(port=port)
        master.setParam(f"/{node}/{parameter}", value)
    publishes = {"mavros": "/mavros/state", "yaw_regulator": "/vel_setpoint_out", "cepa": "/vel_setpoint_out"}
    for node, topic in publishes.items():
        wait_for(
            lambda node=node, topic=topic: f"/{node}" in dict(master.getSystemState()[0]).get(topic, ()),
            f"{node} does not start",
        )
    for node, log in logs.items():
        assert started[node].poll() is None
        assert "Traceback" not in log.read_text(), node


def wait_for(condition, otherwise: str) -> None:
    end_s = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end_s, otherwise
        time.sleep(0.05)


@pytest.mark.long
def test_a_node_that_cannot_start_ends_the_launch_with_its_sentence(processes, tmp_path):
    """MAVROS's port is taken since the check; it would be tried for ever, and the UAV never ready."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]
        args = {"world": WORLDS / "empty.world", "goal": "9 0 2", "offboard_port": port}
        flight = Flight(processes, tmp_path, "fly_to_goal.launch", **args)
        flight.wait(200.0)
    failure = flight.result["failure"]
    assert failure == (
        f"Cannot bind UDP 127.0.0.1:{port} for MAVROS: Address already in use; "
        "stop the program that uses the port (another simulator?) or choose another port."
    )
    assert failure in flight.said
    assert flight.said.count("[FATAL]") <= 4, flight.said  # reminders after 2, 6, 14 and 24 s, no flood
    assert "mavros-3] process has died" not in flight.said
    assert "Traceback" not in flight.said
