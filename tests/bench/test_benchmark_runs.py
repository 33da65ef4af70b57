"""A smallest run of each benchmark, and what it measures with."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks import avoidance, cepa, experiment_1, px4_vision, sim
from benchmarks.gnss_rows import boxes, landings, stops
from benchmarks.shared import places
from benchmarks.shared.flights import Question
from benchmarks.shared.forked import in_a_copy
from benchmarks.simulator import real_px4
from cepa import CepaParameters, Improved, LaserScan2D
from master_thesis.experiments_3_4.without_gnss.flight import distances

ROOT = Path(__file__).resolve().parents[2]


def test_distances_from_the_planned_path_are_those_of_its_nearest_line():
    corner = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)])
    points = np.array([(2.0, 0.5), (-3.0, 4.0), (4.2, 2.0), (4.0, 5.0)])
    assert distances(points, corner) == pytest.approx([0.5, 5.0, 0.2, 2.0])


def test_a_change_counts_from_one_row_to_the_next_and_within_a_time():
    rows = np.array([(0.0, 0.0), (0.1, 0.2), (0.2, 0.3), (0.9, -0.1)])
    assert boxes.change_within(rows, 0.0) == pytest.approx(0.4)
    assert boxes.change_within(rows[:3], 0.0) == pytest.approx(0.2)
    assert boxes.change_within(rows[:3], 0.5) == pytest.approx(0.3)


def test_a_place_over_a_box_is_between_its_sides():
    box = boxes.BOXES[0]
    x_m, y_m = box.x_m, box.y_m
    places_xy = np.array([(x_m, y_m), (x_m + 0.19, y_m - 1.49), (x_m + 0.21, y_m), (x_m, y_m + 1.51)])
    assert boxes.over(places_xy, boxes.BOXES).tolist() == [True, True, False, False]


def test_work_in_a_copy_changes_nothing_here():
    flown = [1]
    assert in_a_copy(lambda: (flown.append(2), flown)[1]) == [1, 2]
    assert flown == [1]


def test_a_copy_that_fails_says_why(capfd):
    with pytest.raises(RuntimeError, match="did not finish"):
        in_a_copy(lambda: 1 // 0)
    assert "ZeroDivisionError" in capfd.readouterr().err


def test_the_summary_of_stops_tells_those_in_curves_apart():
    numbers = {
        "brakes_s": 0.1,
        "after_death_s": 0.3,
        "stays_slow_s": 0.5,
        "fastest_after_m_s": 0.1,
        "way_m": 0.4,
    }
    straight = {**numbers, "slow_s": 0.4, "turn_rad_s": 0.1}
    turning = {**numbers, "slow_s": 0.6, "turn_rad_s": -0.4}
    found = stops.summary([straight, turning])
    assert (found["stops"], found["turning"]) == (2, 1)
    assert (found["median_s"], found["worst_s"], found["turning_worst_s"]) == (0.5, 0.6, 0.6)
    assert stops.summary([straight])["turning_worst_s"] is None
    never = stops.summary([straight, {**turning, "slow_s": None}])
    assert (never["median_s"], never["worst_s"]) == (None, None)


def test_the_summary_of_landings_counts_those_upright_near_the_goal():
    """One is near and stands, one lies on a rotor, one is far off, of one nobody knows how it stands."""
    cases = ((0.2, 1.0), (0.3, 31.0), (0.6, 1.0), (0.4, math.nan))
    flown = [{"flown": True, "contact": False, "off_goal_m": off, "tilt_deg": tilt} for off, tilt in cases]
    found = landings.summary(flown)
    assert (found["flights"], found["flown"], found["contact"], found["upright_near"]) == (4, 4, 0, 1)
    assert found["off_goal_m"] == {"median": pytest.approx(0.35), "worst": 0.6}


def test_the_narrow_hallway_is_as_wide_as_it_says(tmp_path):
    path = tmp_path / "hallway.world"
    path.write_text(places.hallway(2.4))
    questions = places.questions(str(path), np.random.default_rng(1), 20, (15.0, 0.6), 0.5)
    ranges = np.array([question.scan.ranges for question in questions])
    assert ranges.min() > 0.5
    across = (ranges[:, :720] + ranges[:, 720:]).min(axis=1)  # opposite beams; wider where a door is
    assert np.median(across) == pytest.approx(2.4, abs=6 * places.NOISE_M)


def test_a_px4_that_does_not_connect_ends_the_benchmark_in_one_sentence(tmp_path, monkeypatch, capsys):
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/px4").write_text("#!/bin/sh\nexec sleep 60\n")
    (tmp_path / "bin/px4").chmod(0o755)
    monkeypatch.setattr(px4_vision, "fly_ours", lambda *given: (np.zeros((2, 1)), []))
    monkeypatch.setattr(px4_vision, "hover", lambda flights: {"hover_cm": []})
    monkeypatch.setattr(px4_vision, "step", lambda flights: {})
    monkeypatch.setattr(real_px4, "_START_S", 0.1)
    assert px4_vision.main(["--brief", "--px4", str(tmp_path), "--results", str(tmp_path)]) == 1
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("No PX4 has connected within 0.1 s. Start PX4 SITL as instance 7")


def test_a_replay_counts_what_the_algorithm_says():
    free = LaserScan2D(np.full(1440, np.inf), -math.pi, math.radians(0.25), 0.06, 10.0)
    figures = cepa.replay(Improved(CepaParameters()), [Question(free, (2.0, 0.0), (0.0, 0.0))] * 5, times=2)
    assert figures["directions"] == 1.0
    assert 0.0 < figures["median_us"] <= figures["p99_us"] <= figures["max_us"]


@pytest.fixture
def run(tmp_path, capsys):
    """Run a benchmark; returns what stands in benchmarks.json and what was printed."""

    def run(benchmark, *arguments):
        benchmark.main(["--results", str(tmp_path), *arguments])
        return json.loads((tmp_path / "benchmarks.json").read_text()), capsys.readouterr().out

    return run


@pytest.mark.long
@pytest.mark.flight
def test_cepa_is_benchmarked(run, monkeypatch):
    monkeypatch.setattr(cepa, "REPLAYS", 1)  # the original takes 8 ms a scan
    written, said = run(cepa, "--scenarios", "forest", "--goal", "1", "--places", "20", "--brief")
    forest = written["cepa"]["forest"]
    assert forest["original"]["directions"] > 4 * 1000  # four speeds in each of the beams that are seen
    assert forest["improved"]["directions"] < forest["original"]["directions"] / 10
    assert forest["speedup"] == pytest.approx(forest["original"]["mean_us"] / forest["improved"]["mean_us"])
    assert forest["speedup"] > 50  # 300 on a quiet machine
    assert written["cepa"]["worst_hallway"]["max_us"] > 0.0
    assert written["cepa"]["first_call_s"] > 0.0
    assert "thesis, improved / original" in said


@pytest.mark.long
@pytest.mark.flight
def test_the_campaign_is_flown(run, tmp_path):
    written, said = run(avoidance, "--smallest", "--workers", "1", "--rows", "mixed", "thick")
    campaign = written["cepa"]["campaign"]
    for name in ("improved", "original", "improved_velocity_aware", "improved_levelling"):
        assert campaign[name]["all"]["flights"] == campaign[name]["2_m_s"]["flights"] == 1
    assert campaign["improved_at_2_m_s"]["collisions"] == 0
    assert campaign["improved_at_2_m_s"]["distance_km"] > 1e-3 * (8.0 - 0.2)
    assert (tmp_path / "avoidance/outcomes.png").read_bytes().startswith(b"\x89PNG")
    assert "improved, all" in said
    thick = written["avoidance"]["thick_forest"]["4_m_s"]["dynamic"]
    assert thick["flights"] == 1
    assert thick["computation_ms"]["p99"] > 0.0
    assert "thick forests" in said


@pytest.mark.flight
def test_the_table_of_experiment_1_is_flown(run, tmp_path, monkeypatch):
    monkeypatch.setattr(experiment_1, "ALGORITHMS", ("improved",))  # the smallest report flies all of them
    few = ("--scenarios", "empty", "--seeds", "1", "--goal", "3", "--workers", "1")
    written, said = run(experiment_1, *few)
    improved = written["experiment_1"]["empty"]["improved"]
    assert improved["reached_goal"] == improved["flights"] == 1
    assert improved["collisions"] == 0
    assert improved["computation_ms"]["mean"] > 0.0
    assert 1.5 < improved["flight_time_s"]["mean"] < 6.0  # 3 m at 2 m/s
    assert (tmp_path / "experiment_1.md").read_text() in said
    assert (tmp_path / "experiment_1.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.flight
def test_the_simulator_s_rays_are_benchmarked_as_bringup_does(tmp_path):
    command = (sys.executable, "-m", "benchmarks.sim", "--results", str(tmp_path), "--parts", "raycast")
    libraries = os.pathsep.join([*map(str, ROOT.glob("src/**/src")), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": libraries}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    rays = json.loads((tmp_path / "benchmarks.json").read_text())["sim"]["raycast"]
    assert min(rays["mrays_s"], rays["embree_mrays_s"]) > 1.0  # 14 and 15 on a quiet machine
    assert rays["by_embree"] == pytest.approx(rays["mrays_s"] / rays["embree_mrays_s"])
    assert "sim.raycast.by_embree" in done.stdout


@pytest.mark.long
@pytest.mark.flight
def test_a_soak_is_flown_with_faults_and_without_contacts(run):
    written, said = run(sim, "--soak", "--minutes", "0.4", "--seed", "3")
    soak = written["sim"]["soak"]
    assert soak["simulated_s"] == pytest.approx(24.0)
    assert soak["goals"] >= 1
    assert sum(soak["faults"].values()) >= 1
    assert soak["contacts"] == 0
    assert abs(soak["clock_drift_ms"]) < 1e-3
    assert "contacts: 0" in said
