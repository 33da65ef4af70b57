"""Whole flights through the whole graph, started as a user starts them: with roslaunch."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import sys
import time
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
WORLDS = ROOT / "src/master_thesis/worlds"

READY_PATIENCE_S = 150.0  # quiet machines need 12 s

pytestmark = [pytest.mark.ros, pytest.mark.flight]


def busy() -> str | None:
    """Return why times of the wall clock would say nothing now, or None on a machine of one's own."""
    load, cores = os.getloadavg()[0], os.cpu_count() or 1
    return f"a load of {load:.1f} on {cores} cores: others are at work, too" if load > cores + 0.5 else None


class Flight:
    """One `roslaunch master_thesis ...` with ports and a results folder of its own."""

    def __init__(self, processes, folder: Path, launch_file: str, **args) -> None:
        master, offboard, ground = free_ports(3)
        processes.environment["ROS_MASTER_URI"] = f"http://localhost:{master}"
        self.folder = folder
        ports = {"offboard_port": offboard, "gcs_port": ground, "results": folder / "results"}
        words = [f"{name}:={value}" for name, value in {**ports, **args}.items()]
        self._log = (folder / "roslaunch.log").open("w")
        command = ("roslaunch", "-p", str(master), "master_thesis", launch_file, *words)
        self.started_s = time.monotonic()
        self._process = processes.start(*command, stdout=self._log, stderr=self._log)

    @property
    def said(self) -> str:
        """What roslaunch and the nodes have printed so far."""
        return (self.folder / "roslaunch.log").read_text(errors="replace")

    def wait_until_said(self, words: str, patience_s: float) -> None:
        end_s = time.monotonic() + patience_s
        while words not in self.said:
            assert self._process.poll() is None, f"it ended before it said '{words}':\n{self.said}"
            assert time.monotonic() < end_s, f"it did not say '{words}' within {patience_s} s:\n{self.said}"
            time.sleep(0.05)

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def wait(self, patience_s: float) -> float:
        """Wait for its end; returns how long that took, s."""
        started_s = time.monotonic()
        self._process.wait(patience_s)
        return time.monotonic() - started_s

    @property
    def results(self) -> Path:
        (folder,) = (self.folder / "results").glob("*/*")
        return folder

    @property
    def result(self) -> dict:
        return json.loads((self.results / "result.json").read_text())

    def series(self, name: str) -> np.ndarray:
        return np.genfromtxt(
            self.results / f"{name}.csv", delimiter=",", names=True, dtype=None, encoding=None
        )


def free_ports(count: int) -> list[int]:
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


# -- Experiment 1 from roslaunch to the picture -------------------------------------------------------------


@pytest.fixture(scope="module")
def forest(processes_of_module, tmp_path_factory):
    """Experiment 1 in the forest in real time, recorded."""
    was_busy = busy()
    flight = Flight(
        processes_of_module,
        tmp_path_factory.mktemp("forest"),
        "experiment_1.launch",
        scenario="forest",
        record="true",
        headless="true",
    )
    flight.wait(250.0)
    flight.was_busy = was_busy
    return flight


def test_experiment_1_does_what_it_should(forest):
    result = forest.result
    assert result["success"], result["failure"]
    assert result["reached_goal"] is True
    assert result["collision"] is False
    assert result["min_clearance_m"] > 0.0
    assert 20.0 < result["flight_time_s"] < 30.0
    assert 40.0 < result["path_length_m"] + 0.2 < 50.0  # 0.2: the goal's tolerance
    assert result["cepa_computation_ms"]["count"] > 700
    assert result["parameters"]["cepa"]["r_ub"] == 1.2
    assert result["seed"] == 1
    assert "Traceback" not in forest.said


def test_experiment_1_keeps_up_with_the_clock(forest):
    """What is promised of a machine of its own; it cannot be seen on one that others use as well."""
    result = forest.result
    assert result["latency_ms"]["count"] > 700
    assert result["lockstep_misses"] == 0
    if forest.was_busy:
        pytest.skip(f"the figures of the wall clock are not looked at: {forest.was_busy}")
    assert result["real_time_factor"] > 0.95
    assert result["latency_ms"]["median"] < 15.0
    assert result["latency_ms"]["p99"] < 40.0
    assert result["wall_time_to_ready_s"] < 15.0


def test_experiment_1_leaves_series_and_pictures(forest):
    names = {path.name for path in forest.results.iterdir()}
    pictures = {"path_speed.png", "path_computation.png", "flight.png"}
    assert pictures | {"result.json", "truth.csv", "odometry.csv", "decisions.csv", "flight.bag"} <= names
    assert not [name for name in names if name.endswith(".active")], "the bag was not closed"
    truth = forest.series("truth")
    assert np.hypot(truth["x_m"][-1] - 40.0, truth["y_m"][-1]) < 0.5
    assert 0.0 < truth["z_m"][-1] < 0.3


def test_the_recorded_flight_gives_the_same_answers_again(forest, processes):
    """`rosbag play --clock` of what CEPA heard, into CEPA alone: each answer equals the recorded one."""
    bag = forest.results / "flight.bag"
    port = free_ports(1)[0]
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{port}"
    processes.start("roslaunch", "-p", str(port), "cepa", "cepa.launch", "visualiser:=false")
    probe = str(ROOT / "tests/playback_probe.py")
    run = processes.run(sys.executable, probe, str(bag), timeout_s=200.0)
    assert run.returncode == 0, run.stdout
    figures = json.loads(run.stdout.splitlines()[-1])
    assert figures["expected"] >= 270  # 7 s at 40 Hz
    # Topics hold the newest message only: a machine that is busy for 50 ms (played at half speed) loses one,
    # and an answer to a scan whose odometry was lost is made with the one of 10 ms before.
    assert figures["answered"] >= 0.95 * figures["expected"]
    assert figures["equal"] >= 0.9 * figures["expected"]
    assert figures["furthest_apart_m_s"] < 0.05


# -- the closed loop without ROS is the same flight ---------------------------------------------------------


def test_in_lockstep_the_nodes_fly_as_the_closed_loop_does(processes, tmp_path):
    from master_thesis.closed_loop import ClosedLoop, ClosedLoopParameters
    from master_thesis.experiment import Phase
    from simulation_tools.simulation import SimulationParameters

    goal = (14.0, 0.0, 2.0)
    world = WORLDS / "forest.world"
    args = {"world": world, "goal": "14 0 2", "seed": 3, "lockstep": "true", "real_time_factor": 0}
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", **args)
    with ClosedLoop(ClosedLoopParameters(SimulationParameters(str(world), seed=3), goal_xyz_m=goal)) as loop:
        outcome = loop.run()
    flight.wait(200.0)
    result = flight.result
    assert result["success"], result["failure"]
    assert result["lockstep_misses"] == 0
    # Compared from the moment each was sent to the goal
    ours = np.array(loop.log.truth.rows)[:, :4]
    theirs = np.array(flight.series("truth").tolist())[:, :4]
    ours[:, 0] -= outcome.times_s[Phase.FLYING]
    theirs[:, 0] -= result["times_s"]["flying"]
    times = np.arange(0.0, 7.0, 0.1)
    apart = [
        np.interp(times, ours[:, 0], ours[:, axis]) - np.interp(times, theirs[:, 0], theirs[:, axis])
        for axis in (1, 2, 3)
    ]
    assert np.linalg.norm(apart, axis=0).max() < 0.05


def test_in_lockstep_a_flight_repeats_bit_for_bit(processes, tmp_path):
    """With everything from the take-off to the landing, as fast as the machine can."""
    world = WORLDS / "forest.world"
    args = {"world": world, "goal": "6 0 2", "seed": 3, "lockstep": "true", "real_time_factor": 0}
    flights = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        flights.append(Flight(processes, tmp_path / name, "fly_to_goal.launch", **args))
        flights[-1].wait(200.0)
        assert flights[-1].result["success"], flights[-1].result["failure"]
        assert flights[-1].result["lockstep_misses"] == 0
        assert "Traceback" not in flights[-1].said
    for series in ("truth", "odometry", "v_safe", "v_final"):
        first, second = ((flight.results / f"{series}.csv").read_bytes() for flight in flights)
        assert first.count(b"\n") > 500
        assert first == second, f"{series}.csv differs"


# -- tuning in flight ---------------------------------------------------------------------------------------

TWO_COLUMNS = """<?xml version="1.0"?>
<sdf version="1.6"><world name="two_columns">
  <include><uri>model://ground_plane</uri></include>
  {columns}
</world></sdf>"""
COLUMN = """<model name="column_{x}"><static>true</static><pose>{x} 1.55 0 0 0 0</pose><link name="link">
  <collision name="column"><pose>0 0 2 0 0 0</pose>
    <geometry><cylinder><radius>0.2</radius><length>4</length></cylinder></geometry></collision>
</link></model>"""


def test_dynparam_changes_the_flight_while_flying(processes, tmp_path):
    """Two columns 1.35 m beside the way: outside r_UB = 1.2 m, inside the 1.5 m that is set between them."""
    world = tmp_path / "two_columns.world"
    world.write_text(TWO_COLUMNS.format(columns="".join(COLUMN.format(x=x) for x in (7, 18))))
    args = {"world": world, "goal": "23 0 2", "lockstep": "true", "real_time_factor": 2}
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", **args)
    flight.wait_until_said("is sent to the goal", READY_PATIENCE_S)
    dynparam = ("rosrun", "dynamic_reconfigure", "dynparam", "set", "/cepa", "r_ub", "1.5")
    probe = str(ROOT / "tests/tuning_probe.py")
    run = processes.run(sys.executable, probe, "9", *dynparam, timeout_s=270.0)
    assert run.returncode == 0, run.stdout
    flight.wait(120.0)
    assert flight.result["success"], flight.result["failure"]
    assert flight.result["parameters"]["cepa"]["r_ub"] == 1.5
    truth = flight.series("truth")
    aside = [np.abs(truth["y_m"][np.abs(truth["x_m"] - x) < 2.0]).max() for x in (7.0, 18.0)]
    assert aside[0] < 0.06
    assert aside[1] > aside[0] + 0.05


# -- nodes that die -----------------------------------------------------------------------------------------

STEERING = ("/lidar_median_filter", "/lidar_padding", "/cepa", "/yaw_regulator", "/position_controller")
LINK = ("/mavros_publisher", "/mavros")


@pytest.mark.timeout(600)
def test_nodes_that_die_in_flight(processes, tmp_path):
    """Each is killed at cruising speed; then the whole is interrupted."""
    goal = "600 0 2"  # further than the flight gets
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", world=WORLDS / "empty.world", goal=goal)
    flight.wait_until_said("is sent to the goal", READY_PATIENCE_S)
    probe = str(ROOT / "tests/fault_probe.py")
    run = processes.run(sys.executable, probe, *STEERING, *LINK, timeout_s=400.0)
    assert run.returncode == 0, run.stdout
    seen = {report["node"]: report for report in map(json.loads, run.stdout.splitlines()[-7:])}
    for node, report in seen.items():
        assert report["cruised"], report
        assert report["flew_on"], report
        assert re.search(rf"\[{node[1:]}-\d+\] process has died", flight.said), node
    for node in STEERING:
        # The command is dropped 0.5 s after the last one; 40 Hz chain and 30 Hz publisher round it up
        assert seen[node]["hold_commanded_after_s"] < 0.7, seen[node]
        assert seen[node]["lowest"] > 1.8, seen[node]
    for node in LINK:
        # Nothing gets to PX4 until it is back; PX4 lands meanwhile, from 1 s after the last setpoint on
        assert 0.5 < seen[node]["lowest"] < 1.99, seen[node]
    # Interrupted, it is over at once, and says so
    was_busy = busy()
    flight.interrupt()
    took_s = flight.wait(30.0)
    assert took_s < (15.0 if was_busy else 3.0), was_busy
    result = flight.result
    assert result["reached_goal"] is False
    assert result["failure"] == "The run was interrupted before its end."
    assert result["path_length_m"] > 20.0
    assert "Traceback" not in flight.said


@pytest.mark.parametrize("after_s", [0.2, 1.0])  # while the nodes import, while they connect
def test_interrupted_while_it_starts_the_launch_ends_quietly(processes, tmp_path, after_s):
    flight = Flight(processes, tmp_path, "fly_to_goal.launch", world=WORLDS / "empty.world", goal="9 0 2")
    flight.wait_until_said("process[experiment", READY_PATIENCE_S)
    time.sleep(after_s)
    was_busy = busy()
    flight.interrupt()
    took_s = flight.wait(60.0)
    assert "Traceback" not in flight.said
    assert "escalating" not in flight.said, "a node had to be killed"
    assert took_s < (12.0 if was_busy else 3.0), was_busy


# -- what cannot be flown -----------------------------------------------------------------------------------


CANNOT_BE_LAUNCHED = {
    "scenario": (
        "experiment_1",
        "scenario:=jungle",
        "There is no scenario 'jungle'; choose scenario:=empty|",
    ),
    "mavros": ("experiment_1", "mavros:=fake", "There is no mavros 'fake'; choose mavros:=sim|real."),
    "malformed": ("fly_to_goal", "goal:=9 0 2", "broken.world:2: "),
}


@pytest.mark.parametrize("case", CANNOT_BE_LAUNCHED)
def test_what_cannot_be_flown_ends_the_launch_with_a_sentence(processes, tmp_path, case):
    launch_file, arg, sentence = CANNOT_BE_LAUNCHED[case]
    args = dict([arg.split(":=")])
    if launch_file == "fly_to_goal":
        args["world"] = tmp_path / "broken.world"
        args["world"].write_text('<?xml version="1.0"?>\n<sdf version="1.6"><world')
    flight = Flight(processes, tmp_path, f"{launch_file}.launch", **args)
    flight.wait(100.0)
    assert sentence in flight.said
    assert "Traceback" not in flight.said


REFUSED = {
    "algorithm": ("_algorithm:=best", "There is no algorithm 'best'; choose algorithm:=improved|original."),
    "world": ("_world:=/no.world", "There is no world file /no.world; give the path of an SDF world"),
    "goal": ("_goal:=far away", "'far away' is no goal; give 3 numbers in metres and radians: x y z."),
    "near": ("_goal:=0 0 2", "The goal lies 0.00 m from the start; it must be 1 m to 10 km away."),
    "results": ("_results:=/proc", "Cannot make a results folder in /proc/"),
    "lidar": ("_lidar:=sonar", "There is no lidar 'sonar'; choose lidar:=urg|ust|utm|puck|tim|m8."),
    "speed": ("_speed:=abc", "'abc' is no speed; give a number from 0.05 to 15."),
    "pose_source": ("_pose_source:=gps", "There is no pose_source 'gps'; choose pose_source:="),
    "relative world": ("_world:=my.world", "for example world:=$PWD/my.world."),
    "relative results": ("_results:=out", "for example results:=$PWD/out."),
    "seed": ("_seed:=abc", "'abc' is no seed; give a whole number from 0 to 2147483647."),
    "no number": ("_hover_s:=two", "hover_s is two; it must be a positive number of seconds."),
    "limit": ("_hover_s:=-1", "hover_s is -1; it must be a positive number of seconds."),
}


@pytest.mark.parametrize("case", REFUSED)
def test_the_experiment_refuses_in_a_sentence(ros_master, case):
    arg, sentence = REFUSED[case]
    world = f"_world:={WORLDS / 'empty.world'}"
    words = (arg,) if arg.startswith("_world") else (world, arg)
    run = ros_master.run("rosrun", "master_thesis", "experiment", *words, timeout_s=100.0)
    assert run.returncode == 1
    assert sentence in run.stdout
    assert "Traceback" not in run.stdout
