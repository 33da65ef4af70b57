"""From a log that is known in closed form to result.json, the series and the pictures."""

import json
import math
import threading
from dataclasses import replace
from datetime import datetime

import numpy as np
import pytest

from flights.flight.course import Phase, PhaseLimits
from flights.flight.description import RunDescription
from flights.flight.judging.contacts import UavParts
from flights.flight.monitor import Monitor
from flights.results import run_files, run_summary
from flights.results.metrics import flight_metrics
from flights.results.run_folder import RunFolder
from flights.worlds.scenario import scenario

IRIS = UavParts("iris", frozenset(("rotor_0",)))
KEYS_OF_THE_ISSUE = (
    "reached_goal",
    "collision",
    "min_clearance_m",
    "flight_time_s",
    "path_length_m",
    "cepa_computation_ms",
    "real_time_factor",
    "seed",
    "parameters",
)


class WallClock:
    """A wall clock that runs at half the speed of the simulation's."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


def fly_straight(until_s=60.0):
    """Wait 10 s, fly 20 s along x at 2 m/s, hover 2 s and land in 5 s; twice as long by the wall."""
    wall = WallClock()
    monitor = Monitor(PhaseLimits(), IRIS, wall)
    asked = []
    for step in range(int(until_s * 100)):
        t_s = 0.01 * step
        wall.now_s = 100.0 + 2.0 * t_s
        monitor.course.on_ready(t_s >= 10.0)
        x = 2.0 * min(max(t_s - 10.0, 0.0), 20.0)
        asked += monitor.on_truth(t_s, (x, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0))
        if 10.0 < t_s < 30.0 and step % 10 == 0:
            monitor.log.decisions.add(t_s, 0.001 * step, 3, -1.0, step == 2000, "steered")
            monitor.log.v_ref.add(t_s, 2.0, 0.0, 0.0, 0.0)
        if step == 3000:
            monitor.on_goal_reached(True)
        if step == 3700:
            asked += monitor.on_armed(False)
    return monitor, asked


@pytest.fixture
def description(worlds_folder):
    return RunDescription("experiment_1", scenario("empty", worlds_folder), "improved", "ust", seed=3)


def test_metrics_of_a_straight_flight(description):
    monitor, asked = fly_straight()
    assert [action.name for action in asked] == ["SEND_GOAL", "LAND", "FINISH"]
    metrics = flight_metrics(monitor.log, monitor.course.outcome, (40.0, 0.0, 2.0))
    assert metrics["success"] is True
    assert metrics["flight_time_s"] == pytest.approx(20.0, abs=0.011)
    assert metrics["path_length_m"] == pytest.approx(40.0, abs=0.03)
    assert metrics["goal_error_m"] == pytest.approx(0.0, abs=1e-9)
    assert metrics["landing_error_m"] == pytest.approx(0.0, abs=1e-9)
    assert metrics["cepa_computation_ms"]["median"] == pytest.approx(2.0, abs=0.011)
    assert metrics["cepa_computation_ms"]["count"] == 199
    assert metrics["emergencies"] == 1
    assert metrics["times_s"]["landing"] == pytest.approx(32.0, abs=0.02)


def test_a_flight_cut_short_is_measured_to_its_end(description):
    monitor, _ = fly_straight(until_s=20.0)
    monitor.abort("The run was interrupted before its end.")
    metrics = flight_metrics(monitor.log, monitor.course.outcome, (40.0, 0.0, 2.0))
    assert metrics["success"] is metrics["reached_goal"] is False
    assert metrics["flight_time_s"] is None
    assert metrics["path_length_m"] == pytest.approx(20.0, abs=0.05)
    assert metrics["goal_error_m"] == pytest.approx(20.0, abs=0.05)
    assert metrics["landing_error_m"] is metrics["landed_off_goal_m"] is metrics["landing"] is None
    assert metrics["failure"] == "The run was interrupted before its end."


def test_a_run_that_never_flew_has_a_summary_too(tmp_path, description):
    monitor = Monitor(PhaseLimits(), IRIS)
    monitor.abort("The simulator ended.")
    wall = monitor.wall_metrics(0.0)
    folder = RunFolder(tmp_path, "experiment_1", datetime.now())
    content = run_files.write_numbers(folder, description, monitor.log, monitor.course.outcome, wall)
    assert content["failure"] == "The simulator ended."
    assert content["reached_goal"] is False
    assert json.loads((folder.path / "result.json").read_text())["cepa_computation_ms"] is None
    assert "failure" in run_summary.headline(content)


@pytest.mark.parametrize(
    ("factor", "p99_ms", "lockstep", "told"),
    [
        (0.99, 60.0, False, ""),
        (0.80, 60.0, False, "bad: the machine did not keep the factor of 1."),
        (0.80, 997.0, False, "bad: 1 % of the answers came after 500 ms"),
        (0.80, 997.0, True, "does not matter: in lockstep"),
    ],
)
def test_pace_and_latency_are_judged(description, tmp_path, factor, p99_ms, lockstep, told):
    monitor = Monitor(PhaseLimits(), IRIS)
    monitor.abort("The simulator ended.")
    wall = monitor.wall_metrics(0.0)
    folder = RunFolder(tmp_path, "experiment_1", datetime.now())
    content = run_files.write_numbers(folder, description, monitor.log, monitor.course.outcome, wall)
    content["parameters"] = {"gazebo": {"real_time_factor": 1.0, "lockstep": lockstep}}
    content |= {"real_time_factor": factor, "latency_ms": {"median": 50.0, "p99": p99_ms}}
    words = run_summary.headline(content)
    assert told in words
    assert ("pace" in words) == bool(told)


def test_wall_metrics(description):
    monitor, _ = fly_straight()
    monitor.on_performance(
        {
            "setpoint_latency_ms_median": 4.0,
            "setpoint_latency_ms_p99": 9.0,
            "setpoint_latency_count": 800.0,
            "lockstep_misses": 0.0,
        }
    )
    wall = monitor.wall_metrics(started_s=90.0)
    assert wall.real_time_factor == pytest.approx(0.5, abs=1e-3)
    assert wall.wall_time_to_ready_s == pytest.approx(30.0, abs=0.03)
    assert wall.latency_ms == {"median": 4.0, "p99": 9.0, "count": 800}
    counts = wall.latency_ms["count"], wall.lockstep_misses
    assert [type(count) for count in counts] == [int, int]


def test_without_measured_latencies_there_are_none(description):
    monitor, _ = fly_straight()
    monitor.on_performance({"setpoint_latency_ms_median": math.nan, "setpoint_latency_count": 0.0})
    assert monitor.wall_metrics(90.0).latency_ms is None


def test_a_uav_that_stays_on_the_ground_between_two_parts_has_wall_times_too():
    monitor, _ = fly_straight(until_s=20.0)
    for step in range(400):  # it stops, is told to land, and stands
        monitor._wall_clock.now_s = 140.0 + 0.02 * step
        monitor.on_truth(20.0 + 0.01 * step, (20.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0))
        if step == 200:
            monitor.land_between()
    assert monitor.on_armed(False) == []
    (action,) = monitor.stay_landed()
    assert action.name == "FINISH"
    assert monitor.course.outcome.success
    assert monitor.wall_metrics(90.0).real_time_factor == pytest.approx(0.5, abs=1e-3)


@pytest.mark.table("step_s", [1.0, 600.0, 31_536_000.0])
def test_a_clock_that_is_set_ahead_takes_no_time_from_the_flight(step_s):
    monitor, _ = fly_straight(until_s=20.0)
    assert monitor.course.phase is Phase.FLYING
    assert monitor.on_truth(monitor.now_s + step_s, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)) == []
    assert monitor.course.phase is Phase.FLYING


def test_a_clock_that_jumps_back_ends_the_run():
    monitor, _ = fly_straight(until_s=20.0)
    (action,) = monitor.on_truth(1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert action.name == "FINISH"
    assert monitor.course.outcome.failure == "The clock jumped back: the simulation was reset."
    assert monitor.course.phase is Phase.DONE


@pytest.mark.usefixtures("png_only")
def test_all_files_of_a_run(tmp_path, description):
    monitor, _ = fly_straight()
    monitor.log.add_scan(15.0, np.full(11, 3.0), -0.5, 0.1)
    folder = RunFolder(tmp_path, "experiment_1", datetime.now())
    wall = monitor.wall_metrics(100.0)
    flown = folder, description, monitor.log, monitor.course.outcome
    content = run_files.complete_run(*flown, run_files.write_numbers(*flown, wall))
    written = json.loads((folder.path / "result.json").read_text())
    assert written["scenario"] == "empty"
    assert set(KEYS_OF_THE_ISSUE) <= set(written)
    assert written["seed"] == 3
    assert written["min_clearance_m"] is None  # the field is empty
    assert "40.0 m" in run_summary.headline(content)
    names = {path.name for path in folder.path.iterdir()}
    drawn = {f"{n}.{e}" for n in ("path_speed", "path_computation", "flight") for e in ("png", "pdf", "svg")}
    assert drawn | {"truth.csv", "decisions.csv"} <= names
    truth = np.genfromtxt(folder.path / "truth.csv", delimiter=",", names=True)
    assert truth["x_m"][-1] == 40.0
    hits = np.genfromtxt(folder.path / "hits.csv", delimiter=",", names=True)
    assert np.hypot(hits["x_m"] - 10.0, hits["y_m"]) == pytest.approx(3.0, abs=0.002)


def test_nothing_is_written_to_a_folder_that_is_sealed(tmp_path):
    folder = RunFolder(tmp_path, "experiment_1", datetime.now())
    folder.write_result({"success": True, "failure": None})
    folder.seal(1.0, "pictures")
    late = threading.Thread(target=folder.write_files, args=({"flight.png": b"picture"},), daemon=True)
    late.start()
    late.join(0.2)
    assert [path.name for path in folder.path.iterdir()] == ["result.json"]


def test_a_landing_for_a_battery_does_not_count_as_clearance(monkeypatch, description):
    """It stood on the ground of a room: real PX4's explorations told a clearance of 0."""
    from flights.results import clearance

    monkeypatch.setattr(clearance, "clearances_along", lambda poses, *_, **__: poses[:, :2])
    monitor, _ = fly_straight(until_s=20.0)
    for step in range(1000):
        if step == 100:
            monitor.land_between()
        if step == 700:
            monitor.fly_on()
        monitor.on_truth(20.0 + 0.01 * step, (20.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0))
    times_s = clearance.clearances_of_flight(description, monitor.log, monitor.course.outcome)[:, 0]
    steps = np.diff(times_s)
    assert np.flatnonzero(steps > 0.02).size == 1
    assert times_s[[0, -1]] == pytest.approx([10.0, 29.99], abs=0.02)
    assert times_s[:-1][steps > 0.02] == pytest.approx(20.99, abs=0.02)
    assert times_s[1:][steps > 0.02] == pytest.approx(27.0, abs=0.02)


def test_clearance_along_a_path_past_a_tree(tmp_path, worlds_folder, description):
    """Distance from a UAV to trunks at known places, with its own size from the model."""
    pytest.importorskip("pybullet")
    from dataclasses import replace

    from flights.results.clearance import clearances_of_flight
    from simulation_tools.sdf.elements import Cylinder
    from simulation_tools.sdf.parser import load_world

    monitor, _ = fly_straight()
    in_forest = replace(description, scenario=scenario("forest", worlds_folder))
    found = clearances_of_flight(in_forest, monitor.log, monitor.course.outcome)
    trunks = [
        (model.pose.position_m, model.links[0].collisions[0].geometry.radius_m)
        for model in load_world(str(worlds_folder / "forest.world"), ()).models
        if model.links[0].collisions and isinstance(model.links[0].collisions[0].geometry, Cylinder)
    ]
    for t_s, clearance in found[::40]:
        x = 2.0 * min(max(t_s - 10.0, 0.0), 20.0)
        to_axis = min(math.hypot(x - p[0], p[1]) - radius for p, radius in trunks)
        if to_axis > 1.0:
            # between the distance of its centre and that less its greatest reach
            assert to_axis - 0.6 < clearance < to_axis


def inspected(**more):
    told = {"end": "done", "reason": "-", "asked": 20, "taken": 20, "share_asked": 0.98}
    return {"success": True, "failure": None, "inspection": {**told, **more}}


def explored(end):
    return {"success": True, "failure": None, "exploration": {"end": end, "reason": "-"}}


@pytest.mark.parametrize(
    ("content", "is_done"),
    [
        (inspected(), True),
        (inspected(taken=0, end="aborted"), False),
        (inspected(taken=12, end="battery"), False),
        ({**inspected(), "inspection": {"end": "", "reason": "no result"}}, False),
        # What some photographs could not show, others may
        (inspected(taken=18, coverage={"share_by_slam": 0.985}), True),
        (inspected(taken=18, coverage={"share_by_slam": 0.96}), False),
        (inspected(taken=18), False),
        (explored("explored"), True),
        (explored("time"), True),
        (explored("aborted"), False),
        (explored("battery"), False),
        # The photographs were asked, however the exploration before them ended
        ({**explored("battery"), **inspected()}, True),
    ],
)
def test_a_run_is_a_success_if_it_did_what_was_asked(tmp_path, content, is_done):
    """The UAV has landed well at home in each of them. The exit code is that of the content returned."""
    folder = RunFolder(tmp_path, "inspection", datetime.now())
    told = folder.write_result(content, is_whole=True)
    assert told == json.loads((folder.path / "result.json").read_text())
    assert told["success"] is is_done
    assert bool(told["failure"]) is not is_done


def test_what_the_world_lacks_stands_in_the_result(tmp_path, description):
    """The simulator warns of it at the start."""
    world = tmp_path / "lacking.world"
    shape = "<geometry><mesh><uri>file://no_such.stl</uri></mesh></geometry>"
    world.write_text(
        '<sdf version="1.6"><world name="w"><model name="pipe"><static>1</static><link name="l">'
        f'<collision name="c">{shape}</collision></link></model></world></sdf>'
    )
    lacking = replace(description, scenario=replace(description.scenario, world_path=world))
    monitor, _ = fly_straight(until_s=20.0)
    folder = RunFolder(tmp_path, "experiment_1", datetime.now())
    wall = monitor.wall_metrics(0.0)
    told = run_files.write_numbers(folder, lacking, monitor.log, monitor.course.outcome, wall)
    assert any("no_such.stl" in each for each in told["world_remarks"])
    assert "no_such.stl" in run_summary.headline(told)
