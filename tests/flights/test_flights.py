"""Flights through the whole graph that something is done to: tuning, nodes that die, Ctrl-C."""

from __future__ import annotations

import json
import re
import sys
import time
from pathlib import Path
from xmlrpc.client import ServerProxy

import numpy as np
import pytest
from launched_flight import READY_PATIENCE_S, Flight

ROOT = Path(__file__).resolve().parents[2]
PROBES = ROOT / "tests/flights"

pytestmark = [pytest.mark.ros, pytest.mark.flight]

COLUMNS_X_M = (6.0, 14.0)
TWO_COLUMNS = """<?xml version="1.0"?>
<sdf version="1.6"><world name="two_columns">
  <include><uri>model://ground_plane</uri></include>
  {columns}
</world></sdf>"""
COLUMN = """<model name="column_{x}"><static>true</static><pose>{x} 1.2 0 0 0 0</pose><link name="link">
  <collision name="column"><pose>0 0 4 0 0 0</pose>
    <geometry><cylinder><radius>0.2</radius><length>8</length></cylinder></geometry></collision>
</link></model>"""
STEERING = ("/lidar_median_filter", "/lidar_padding", "/cepa", "/yaw_regulator", "/position_controller")
LINK = ("/mavros_publisher", "/mavros")


@pytest.mark.long
@pytest.mark.timeout(900)
def test_tuned_attacked_and_interrupted_it_flies_on(processes, tmp_path):
    """CEPA is tuned between two columns. Then each node is killed at cruising speed. Then Ctrl-C comes."""
    world = tmp_path / "two_columns.world"
    world.write_text(TWO_COLUMNS.format(columns="".join(COLUMN.format(x=x) for x in COLUMNS_X_M)))
    height_m = 5.0  # PX4's landing takes longer from there than any node is away
    goal = f"600 0 {height_m}"  # further than the flight gets
    # At half speed, so that nodes keep up while other tests run
    args = {"world": world, "goal": goal, "real_time_factor": 0.5, "algorithm": "improved"}
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", **args)
    flight.wait_until_said("is sent to the goal", READY_PATIENCE_S)
    tune = ("rosrun", "dynamic_reconfigure", "dynparam", "set", "/cepa", "r_ub", "1.5")
    run = processes.run(sys.executable, str(PROBES / "tuning_probe.py"), "8", *tune, timeout_s=270.0)
    assert run.returncode == 0, run.stdout
    probe = (str(PROBES / "fault_probe.py"), str(COLUMNS_X_M[1] + 3.0), str(height_m))
    run = processes.run(sys.executable, *probe, *STEERING, *LINK, timeout_s=400.0)
    assert run.returncode == 0, run.stdout
    master = ServerProxy(processes.environment["ROS_MASTER_URI"])
    _, _, kept = master.getParam("/test", "/cepa/r_ub")
    assert kept == 1.5, "the tuning is gone since CEPA died"
    flight.interrupt()
    flight.wait(200.0)
    the_tuning_shows(flight)
    each_death_is_survived(run.stdout, flight, height_m)
    assert "escalating" not in flight.said, "a node had to be killed"
    assert flight.result["reached_goal"] is False
    assert flight.result["failure"] == "The run was interrupted before its end."
    assert "Traceback" not in flight.said


def the_tuning_shows(flight: Flight) -> None:
    """1 m beside a column there is no detour with r_UB = 1.2 m, but with 1.5 m."""
    truth = flight.series("truth")
    aside = [np.abs(truth["y_m"][np.abs(truth["x_m"] - x) < 2.0]).max() for x in COLUMNS_X_M]
    assert aside[0] < 0.06
    assert aside[1] > aside[0] + 0.05


def each_death_is_survived(reports: str, flight: Flight, height_m: float) -> None:
    """The UAV holds while a node of the steering is away; without its link PX4 lands until that is back."""
    seen = {report["node"]: report for report in map(json.loads, reports.splitlines()[-7:])}
    for node, report in seen.items():
        assert report["cruised"], report
        assert report["flew_on"], report
        assert re.search(rf"\[{node[1:]}-\d+\] process has died", flight.said), node
    for node in STEERING:
        # The command is dropped 0.5 s after the last one; 40 Hz chain and 30 Hz publisher round it up
        assert seen[node]["hold_commanded_after_s"] < 1.0, seen[node]
        assert seen[node]["lowest"] > height_m - 0.3, seen[node]
    for node in LINK:
        # Nothing gets to PX4 until it is back; PX4 lands meanwhile, if that takes longer than 1 s
        assert seen[node]["lowest"] > 0.5, seen[node]


KEYBOARD_INTERRUPT = re.compile(r"Traceback \(most recent call last\):\n(?:  .*\n)+KeyboardInterrupt\n")


def only_from_nodes(traceback: re.Match) -> str:
    """Pass over what Python says when it is interrupted before it has come to a node's first line."""
    return traceback[0] if "/nodes/" in traceback[0] else ""


def test_interrupted_while_it_starts_the_launch_ends_quietly(processes, tmp_path):
    flight = Flight(processes, tmp_path, "experiment_1.launch", scenario="empty", headless="true")
    flight.wait_until_said("process[experiment", READY_PATIENCE_S)
    time.sleep(1.0)  # some nodes still import, others connect
    flight.interrupt()
    flight.wait(200.0)
    assert "Traceback" not in KEYBOARD_INTERRUPT.sub(only_from_nodes, flight.said)
    assert "escalating" not in flight.said, "a node had to be killed"
