"""Whole flights through the whole graph: lockstep, a full disk, tuning, and nodes that die."""

from __future__ import annotations

import contextlib
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from launched_flight import READY_PATIENCE_S, Flight

from master_thesis.graph.free_ports import free_ports

ROOT = Path(__file__).resolve().parents[2]
WORLDS = ROOT / "src/master_thesis/worlds"
FOREST = WORLDS / "forest.world"
LOCKSTEP = {"lockstep": "true", "lockstep_timeout": 30, "real_time_factor": 0}

pytestmark = [pytest.mark.ros, pytest.mark.flight]


# -- lockstep ------------------------------------------------------------------------------------------------

SMALL_DISK = "230M"  # rosbag does not begin with less than 200 MB


@pytest.fixture(scope="module")
def small_disk(tmp_path_factory):
    """A folder on a disk of its own, or None where nobody may mount one."""
    folder = tmp_path_factory.mktemp("flight") / "results"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={SMALL_DISK}", "tmpfs", str(folder)]
    mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    yield folder if mounted else None
    if mounted:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


@pytest.fixture(scope="module")
def twins(processes_of_module, tmp_path_factory, small_disk):
    """The same flight, from the take-off to the landing, flown twice; the second time its disk fills up."""

    def start(folder: Path) -> Flight:
        args = {"world": FOREST, "goal": "9 0 2", "seed": 3, "record": "true", **LOCKSTEP}
        flight = Flight(processes_of_module, folder, "fly_to_goal.launch", **args)
        flight.wait_until_said("is sent to the goal", READY_PATIENCE_S)
        return flight

    first = start(tmp_path_factory.mktemp("flight"))
    first.wait(200.0)
    second = start(small_disk.parent if small_disk else tmp_path_factory.mktemp("flight"))
    if small_disk:
        filler = small_disk / "filler"
        fill(filler)
        second.wait_until_said("told to land", 200.0)
        filler.unlink()  # there is room for the results again
    second.wait(200.0)
    return first, second


def fill(filler: Path) -> None:
    """Make a file as large as its disk allows."""
    with contextlib.suppress(OSError), filler.open("wb") as file:
        while True:
            file.write(bytes(1 << 20))


def test_in_lockstep_a_flight_repeats_bit_for_bit(twins):
    for flight in twins:
        assert flight.result["success"], flight.result["failure"]
        assert flight.result["lockstep_misses"] == 0
        assert "Traceback" not in flight.said
    for series in ("truth", "odometry", "v_safe", "v_final"):
        first, second = ((flight.results / f"{series}.csv").read_bytes() for flight in twins)
        assert first.count(b"\n") > 500
        assert first == second, f"{series}.csv differs"


def test_a_disk_that_fills_up_ends_the_recording_only(twins, small_disk):
    if small_disk is None:
        pytest.skip("needs to mount a small disk")
    flight = twins[1]
    assert flight.result["success"], flight.result["failure"]
    assert "flight.bag" in flight.said.split("told to land")[1]


def test_in_lockstep_a_flight_is_that_of_the_closed_loop(twins):
    """The same algorithms without ROS, compared from the moment each UAV is sent to the goal."""
    from master_thesis.flight.closed_loop import ClosedLoop, ClosedLoopParameters
    from master_thesis.flight.course import Phase
    from simulation_tools.simulation import SimulationParameters

    parameters = ClosedLoopParameters(SimulationParameters(str(FOREST), seed=3), goal_xyz_m=(9.0, 0.0, 2.0))
    with ClosedLoop(parameters) as loop:
        outcome = loop.run()
    ours = np.array(loop.log.truth.rows)[:, :4]
    theirs = np.array(twins[0].series("truth").tolist())[:, :4]
    ours[:, 0] -= outcome.times_s[Phase.FLYING]
    theirs[:, 0] -= twins[0].result["times_s"]["flying"]
    times = np.arange(0.0, 5.0, 0.1)
    apart = [
        np.interp(times, ours[:, 0], ours[:, axis]) - np.interp(times, theirs[:, 0], theirs[:, axis])
        for axis in (1, 2, 3)
    ]
    assert np.linalg.norm(apart, axis=0).max() < 0.05


def test_a_bag_played_into_cepa_alone_gives_every_recorded_answer(twins, processes):
    (port,) = free_ports(1)
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{port}"
    processes.start("roslaunch", "-p", str(port), "cepa", "cepa.launch", "visualiser:=false", "replay:=true")
    bag = str(twins[0].results / "flight.bag")
    run = processes.run(sys.executable, str(ROOT / "tests/flights/playback_probe.py"), bag, timeout_s=200.0)
    assert run.returncode == 0, run.stdout
    figures = json.loads(run.stdout.splitlines()[-1])
    assert figures["recorded"] > 500
    assert figures["moving"] > 150
    assert figures["answered"] == figures["recorded"]
    assert figures["different_at_s"] == []


# -- tuning in flight ---------------------------------------------------------------------------------------

TWO_COLUMNS = """<?xml version="1.0"?>
<sdf version="1.6"><world name="two_columns">
  <include><uri>model://ground_plane</uri></include>
  {columns}
</world></sdf>"""
COLUMN = """<model name="column_{x}"><static>true</static><pose>{x} 1.2 0 0 0 0</pose><link name="link">
  <collision name="column"><pose>0 0 2 0 0 0</pose>
    <geometry><cylinder><radius>0.2</radius><length>4</length></cylinder></geometry></collision>
</link></model>"""


def test_dynparam_changes_the_flight_while_flying(processes, tmp_path):
    """Two columns 1 m beside the way: no detour with r_UB = 1.2 m, but with the 1.5 m set between them."""
    world = tmp_path / "two_columns.world"
    world.write_text(TWO_COLUMNS.format(columns="".join(COLUMN.format(x=x) for x in (6, 14))))
    args = {"world": world, "goal": "17 0 2", **LOCKSTEP}
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", **args)
    flight.wait_until_said("process[experiment", READY_PATIENCE_S)
    dynparam = ("rosrun", "dynamic_reconfigure", "dynparam", "set", "/cepa", "r_ub", "1.5")
    probe = str(ROOT / "tests/flights/tuning_probe.py")
    run = processes.run(sys.executable, probe, "8", *dynparam, timeout_s=270.0)
    assert run.returncode == 0, run.stdout
    flight.wait(120.0)
    assert flight.result["success"], flight.result["failure"]
    assert flight.result["parameters"]["cepa"]["r_ub"] == 1.5
    truth = flight.series("truth")
    aside = [np.abs(truth["y_m"][np.abs(truth["x_m"] - x) < 2.0]).max() for x in (6.0, 14.0)]
    assert aside[0] < 0.06
    assert aside[1] > aside[0] + 0.05


# -- nodes that die -----------------------------------------------------------------------------------------

STEERING = ("/lidar_median_filter", "/lidar_padding", "/cepa", "/yaw_regulator", "/position_controller")
LINK = ("/mavros_publisher", "/mavros")


@pytest.mark.realtime
@pytest.mark.timeout(600)
def test_nodes_that_die_in_flight(processes, tmp_path):
    """Each is killed at cruising speed; then the whole is interrupted."""
    height_m = 5.0  # PX4's landing takes longer from there than any node is away
    goal = f"600 0 {height_m}"  # further than the flight gets
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", world=WORLDS / "empty.world", goal=goal)
    flight.wait_until_said("is sent to the goal", READY_PATIENCE_S)
    probe = str(ROOT / "tests/flights/fault_probe.py")
    run = processes.run(sys.executable, probe, str(height_m), *STEERING, *LINK, timeout_s=400.0)
    assert run.returncode == 0, run.stdout
    seen = {report["node"]: report for report in map(json.loads, run.stdout.splitlines()[-7:])}
    for node, report in seen.items():
        assert report["cruised"], report
        assert report["flew_on"], report
        assert re.search(rf"\[{node[1:]}-\d+\] process has died", flight.said), node
    for node in STEERING:
        # The command is dropped 0.5 s after the last one; 40 Hz chain and 30 Hz publisher round it up
        assert seen[node]["hold_commanded_after_s"] < 1.0, seen[node]
        assert seen[node]["lowest"] > height_m - 0.3, seen[node]
    for node in LINK:
        # Nothing gets to PX4 until it is back; PX4 lands meanwhile, from 1 s after the last setpoint on
        assert 0.5 < seen[node]["lowest"] < height_m - 0.01, seen[node]
    # Interrupted, it is over, and says so
    flight.interrupt()
    flight.wait(60.0)
    assert "escalating" not in flight.said, "a node had to be killed"
    result = flight.result
    assert result["reached_goal"] is False
    assert result["failure"] == "The run was interrupted before its end."
    assert result["path_length_m"] > 20.0
    assert "Traceback" not in flight.said


KEYBOARD_INTERRUPT = re.compile(r"Traceback \(most recent call last\):\n(?:  .*\n)+KeyboardInterrupt\n")


def only_from_nodes(traceback: re.Match) -> str:
    """Pass over what Python says when it is interrupted before it has come to a node's first line."""
    return traceback[0] if "/nodes/" in traceback[0] else ""


def test_interrupted_while_it_starts_the_launch_ends_quietly(processes, tmp_path):
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", world=WORLDS / "empty.world", goal="9 0 2")
    flight.wait_until_said("process[experiment", READY_PATIENCE_S)
    time.sleep(1.0)  # some nodes still import, others connect
    flight.interrupt()
    flight.wait(60.0)
    assert "Traceback" not in KEYBOARD_INTERRUPT.sub(only_from_nodes, flight.said)
    assert "escalating" not in flight.said, "a node had to be killed"
