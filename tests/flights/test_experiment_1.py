"""Through Experiment 1's forest: what a flight leaves, that lockstep repeats it, what a full disk ends.

12 m suffice: the first trees force it aside. The loop without ROS flies all 40 m
(src/extensions/flights/test/flight/test_closed_loop.py), and one test below flies it beside this graph.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from launched_flight import Flight

from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.graph.free_ports import free_ports
from master_thesis.experiment_1.scenario_flight import scenario_parameters

ROOT = Path(__file__).resolve().parents[2]
FOREST = ROOT / "src/extensions/flights/worlds/forest.world"
GOAL_X_M = 12.0
FLOWN = {
    "world": FOREST, "goal": f"{GOAL_X_M} 0 2", "algorithm": "improved", "record": "true",
    "lockstep": "true", "lockstep_timeout": 30, "real_time_factor": 0,
}  # fmt: skip

pytestmark = [pytest.mark.ros, pytest.mark.flight]

SETUP_PATIENCE_S = 400.0
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
def flown(processes_of_module, tmp_path_factory):
    """A flight as the README starts it, with bringup.sh, while somebody else's flight ends later."""
    folder = tmp_path_factory.mktemp("flight") / "a folder"
    folder.mkdir()
    flight = Flight(processes_of_module, folder, "fly_to_goal.launch", by_bringup=True, **FLOWN)
    # Before it flies, bringup.sh builds the sources that changed
    flight.wait_until_said("is sent to the goal", SETUP_PATIENCE_S)
    other = flight.results.with_name("other")
    other.mkdir()
    (other / "result.json").write_text("{}")
    os.utime(other / "result.json", (time.time() + 3600.0,) * 2)
    flight.wait(250.0)
    shutil.rmtree(other)
    return flight


@pytest.fixture(scope="module")
def twins(flown, processes_of_module, tmp_path_factory, small_disk):
    """The same flight again, started with roslaunch, while its disk fills up."""
    folder = small_disk.parent if small_disk else tmp_path_factory.mktemp("flight")
    second = Flight(processes_of_module, folder, "fly_to_goal.launch", **FLOWN)
    second.wait_until_said("is sent to the goal", SETUP_PATIENCE_S)
    if small_disk:
        filler = small_disk / "filler"
        fill(filler)
        second.wait_until_said("told to land", SETUP_PATIENCE_S)
        filler.unlink()  # there is room for the results again
    second.end_without_pictures(250.0)
    return flown, second


def fill(filler: Path) -> None:
    """Make a file as large as its disk allows."""
    with contextlib.suppress(OSError), filler.open("wb") as file:
        while True:
            file.write(bytes(1 << 20))


@pytest.mark.timeout(SETUP_PATIENCE_S + 500.0)
def test_the_flight_does_what_it_should(flown):
    result = flown.result
    assert result["success"], result["failure"]
    assert result["reached_goal"] is True
    assert result["landed"]
    assert result["lockstep_misses"] == 0
    assert result["collision"] is False
    assert result["min_clearance_m"] > 0.0
    # 2 m/s, 1.5 s for getting up to speed and braking, and detours
    assert 0.5 * GOAL_X_M < result["flight_time_s"] < 0.9 * GOAL_X_M
    assert GOAL_X_M < result["path_length_m"] + 0.2 < 1.25 * GOAL_X_M  # 0.2: the goal's tolerance
    assert result["cepa_computation_ms"]["count"] > 200
    assert result["parameters"]["cepa"]["r_ub"] == 1.2
    assert result["seed"] == 1


def test_it_leaves_series_and_pictures(flown):
    names = {path.name for path in flown.results.iterdir()}
    pictures = {"path_speed.png", "path_computation.png", "flight.png"}
    assert pictures | {"result.json", "truth.csv", "odometry.csv", "decisions.csv", "flight.bag"} <= names
    assert not [name for name in names if name.endswith(".active")], "the bag was not closed"
    truth = flown.series("truth")
    assert np.hypot(truth["x_m"][-1] - GOAL_X_M, truth["y_m"][-1]) < 0.5
    assert 0.0 < truth["z_m"][-1] < 0.3


def test_a_good_flight_tells_its_figures_once_and_warns_of_nothing(flown):
    said = flown.said
    assert said.count("flight time") == 1
    for words in ("REQUIRED", "[WARN]", "[ERROR]", "PARAMETERS", "rosdep", "escalating", "Traceback"):
        assert words not in said, said


@pytest.mark.long
@pytest.mark.timeout(2.0 * SETUP_PATIENCE_S + 500.0)
def test_in_lockstep_a_flight_repeats_bit_for_bit(twins):
    for flight in twins:
        assert flight.result["reached_goal"], flight.result["failure"]
        assert flight.result["landed"], flight.result["failure"]
        assert flight.result["lockstep_misses"] == 0
        assert "Traceback" not in flight.said
    for series in ("truth", "odometry", "v_safe", "v_final"):
        first, second = ((flight.results / f"{series}.csv").read_bytes() for flight in twins)
        assert first.count(b"\n") > 500
        assert first == second, f"{series}.csv differs"


@pytest.mark.long
@pytest.mark.timeout(2.0 * SETUP_PATIENCE_S + 500.0)
def test_a_disk_that_fills_up_ends_the_recording_only(twins, small_disk):
    if small_disk is None:
        pytest.skip("needs to mount a small disk")
    # rosbag finds the disk full and names the bag; or a write fails, and the node names it after landing
    flight = twins[1]
    assert flight.result["landed"]
    assert not flight.result["collision"]
    # The flight is as good as the other, but its bag, which was asked for, is not whole.
    assert not flight.result["success"]
    assert "flight.bag" in flight.result["failure"]
    undisturbed, disturbed = (each.said.split("is sent to the goal")[1] for each in twins)
    assert "flight.bag" in disturbed
    assert "flight.bag" not in undisturbed


def test_bringup_tells_of_its_own_flight_although_another_ended_later(flown):
    summary = flown.said.rpartition("Results in ")[2]
    assert summary.startswith(f"{flown.results}:\n")


def test_in_lockstep_a_flight_is_that_of_the_closed_loop(flown):
    """The same algorithms without ROS, compared from the moment each UAV is sent to the goal."""
    parameters = scenario_parameters("forest", goal_x_m=GOAL_X_M, k_previous=4.0)
    with ClosedLoop(parameters) as loop:
        outcome = loop.run_to(Phase.HOVERING)
    ours = np.array(loop.log.truth.rows)[:, :4]
    theirs = np.array(flown.series("truth").tolist())[:, :4]
    ours[:, 0] -= outcome.times_s[Phase.FLYING]
    theirs[:, 0] -= flown.result["times_s"]["flying"]
    times = np.arange(0.0, 5.0, 0.1)
    apart = [
        np.interp(times, ours[:, 0], ours[:, axis]) - np.interp(times, theirs[:, 0], theirs[:, axis])
        for axis in (1, 2, 3)
    ]
    assert np.linalg.norm(apart, axis=0).max() < 0.05


def test_a_bag_played_into_cepa_alone_gives_every_recorded_answer(flown, processes):
    (port,) = free_ports(1)
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{port}"
    processes.start(
        "roslaunch",
        "-p",
        str(port),
        "cepa",
        "cepa.launch",
        "algorithm:=improved",
        "visualiser:=false",
        "replay:=true",
    )
    bag = str(flown.results / "flight.bag")
    run = processes.run(sys.executable, str(ROOT / "tests/flights/playback_probe.py"), bag, timeout_s=200.0)
    assert run.returncode == 0, run.stdout
    figures = json.loads(run.stdout.splitlines()[-1])
    assert figures["recorded"] > 500
    assert figures["moving"] > 150
    assert figures["unanswered_at_s"] == []
    assert figures["different_at_s"] == []
