"""The benchmarks: where their numbers go, how the campaign judges, and a smallest run of each."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

ROOT = Path(__file__).resolve().parents[1]

from benchmarks import avoidance, cepa, experiment_1, px4, sim  # noqa: E402
from benchmarks.avoidance_rows import judging, mixed_forests, real_time, rows  # noqa: E402
from benchmarks.shared import places  # noqa: E402
from benchmarks.shared.flights import Question  # noqa: E402
from benchmarks.shared.results import Results, merge, table  # noqa: E402
from benchmarks.shared.trials import run_all, trial_options  # noqa: E402
from benchmarks.simulator import graph  # noqa: E402
from benchmarks.slam_rows import goals  # noqa: E402
from cepa import CepaParameters, Improved, LaserScan2D  # noqa: E402
from master_thesis.campaign.reading import read_campaign  # noqa: E402
from master_thesis.experiments_3_4.flight_without_gnss import distances  # noqa: E402
from master_thesis.trials.trial import Trial  # noqa: E402


def test_dotted_keys_are_nested_objects_and_leave_the_others_alone(tmp_path):
    path = tmp_path / "benchmarks.json"
    merge(path, {"sim.graph.rtf": 5.0, "cepa.empty": {"speedup": 900.0, "old": 1}})
    merge(path, {"cepa.empty": {"speedup": 950.0}, "cepa.first_call_s": np.float64(0.2)})
    assert json.loads(path.read_text()) == {
        "sim": {"graph": {"rtf": 5.0}},
        "cepa": {"empty": {"speedup": 950.0}, "first_call_s": 0.2},
    }


def test_distances_from_the_planned_path_are_those_of_its_nearest_line():
    corner = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)])
    points = np.array([(2.0, 0.5), (-3.0, 4.0), (4.2, 2.0), (4.0, 5.0)])
    assert distances(points, corner) == pytest.approx([0.5, 5.0, 0.2, 2.0])


def test_benchmarks_that_end_at_once_lose_nothing(tmp_path):
    path = tmp_path / "benchmarks.json"
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda n: merge(path, {f"many.k{n}": n}), range(40)))
    assert json.loads(path.read_text()) == {"many": {f"k{n}": n for n in range(40)}}


def test_a_damaged_file_is_refused_and_left_as_it_is(tmp_path):
    path = tmp_path / "benchmarks.json"
    path.write_text("[1]")
    with pytest.raises(ValueError, match="holds no JSON object"):
        merge(path, {"a": 1})
    assert path.read_text() == "[1]"
    assert not list(tmp_path.glob(".benchmarks.json.*"))


def test_a_run_that_fails_writes_nothing(tmp_path):
    results = Results("cepa", tmp_path)
    results.add("cepa.first_call_s", 0.2)
    with pytest.raises(ZeroDivisionError), results:
        _ = 1 / 0
    assert not (tmp_path / "benchmarks.json").exists()


def test_a_run_is_recorded_with_machine_and_load(tmp_path):
    with Results("cepa", tmp_path, {"places": 3}) as results:
        results.add("cepa.first_call_s", 0.2)
    written = json.loads((tmp_path / "benchmarks.json").read_text())
    run = written["runs"]["cepa"]
    assert written["cepa"] == {"first_call_s": 0.2}
    assert run["options"] == {"places": 3}
    assert run["machine"]["cores"] >= 1
    assert len(run["load_before"]) == 3


def test_tables_are_markdown():
    lines = table(("", "ms"), [("a", 1.5), ("longer", 22)]).splitlines()
    assert lines == ["|        |  ms |", "| ------ | --: |", "| a      | 1.5 |", "| longer |  22 |"]


def test_what_is_not_measured_here_is_headed_so_and_has_a_source():
    figures = {"inprocess.rtf": 30.0, "world_size.ratio": 1.3, "graph.rtf": 6.0}
    told = sim.metrics_table(figures)
    assert "| anchor, measured elsewhere |" in told.splitlines()[0]
    for name in figures.keys() & sim.ANCHORS.keys():
        assert f"- {sim.ANCHORS[name].text}: {sim.ANCHORS[name].source}" in told
    assert "Embree alone" not in told  # what is not shown needs no source
    assert "anchor, measured elsewhere" in goals.as_table({}).splitlines()[0]
    assert "ours / PX4 (anchor, measured elsewhere)" in px4.steps_table({}).splitlines()[0]
    for anchor in (*sim.ANCHORS.values(), goals.ANCHOR, px4.RECORDED):
        assert anchor.source
        assert "this machine" not in anchor.source


def test_the_px4_benchmark_complains_of_what_is_more_than_ten_per_cent_off():
    published = {
        "steps": [{"manoeuvres": ["up", "down"], "rise_s": 1.0, "overshoot_percent": 0}],
        "takeoff": {"peak_m_s": 1.2},
        "hover_cm": {"x": 1.4},
    }

    def complaints(up_s, overshoot, peak_m_s, x_cm):
        steps = {
            "up": {"ours": {"rise_s": up_s, "overshoot_percent": overshoot}},
            "down": {"ours": {"rise_s": 1.0, "overshoot_percent": 0.0}},
        }
        hover = {"ours": {"x": x_cm}, "px4": published["hover_cm"]}
        return px4.out_of_bounds(steps, {"ours": {"peak_m_s": peak_m_s}}, hover, published)

    assert complaints(1.19, 1.9, 1.31, 1.53) == []
    assert complaints(1.21, 2.1, 1.33, 1.25) == [
        "up and down: rise_s is 1.1, PX4's 1",
        "up and down: overshoot_percent is 1.05, PX4's 0",
        "take-off: peak_m_s is 1.33, PX4's 1.2",
        "hover: x is 1.25, PX4's 1.4",
    ]
    assert complaints(float("nan"), 0.0, 1.2, 1.4) == ["up and down: rise_s is nan, PX4's 1"]


def test_the_graphs_latency_is_that_of_a_flight_in_real_time_without_lockstep(monkeypatch):
    """DESIGN: wall time from scan to setpoint, at real-time factor 1 without lockstep."""
    flown = []

    class Flight:
        def __init__(self, folder, *arguments):
            flown.append(arguments)
            self.results = Path(next(word for word in arguments if word.startswith("results:="))[9:])

        def interrupt(self):
            self._leave(latency_ms={"median": 5.5, "p99": 9.5, "count": 600})
            return 1.5

        def wait_for_end(self, _):
            self._leave(latency_ms={"median": 2.5, "p99": 3.5, "count": 700})

        def _leave(self, **more):
            folder = self.results / "experiment_1/now"
            folder.mkdir(parents=True)
            content = {"success": True, "real_time_factor": 6.0, "flight_time_s": 25.0, "lockstep_misses": 0}
            (folder / "result.json").write_text(json.dumps({**content, **more}))

        def wait_for(self, *_):
            return 1.0

        cpu_s = memory_gb = wait_for

        def close(self):
            pass

    monkeypatch.setattr(graph, "Graph", Flight)
    monkeypatch.setattr(graph, "LOAD_S", 0.01)
    started, fast = graph.measure_start(), graph.measure_speed()
    assert (started["graph.latency_ms"], started["graph.latency_p99_ms"]) == (5.5, 9.5)
    assert {"real_time_factor:=1.0", "lockstep:=false"} <= set(flown[0])
    assert not any("latency" in name for name in fast)


# Garwood's limits for 0, 1 and 10 events at 95 % as every table of them has it
@pytest.mark.parametrize(("events", "low", "high"), [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)])
def test_the_confidence_interval_is_garwoods(events, low, high):
    assert mixed_forests.rate_interval(events, 1.0) == pytest.approx((low, high), abs=5e-3)
    assert mixed_forests.rate_interval(events, 4.0)[1] == pytest.approx(high / 4.0, abs=2e-3)


def flight(end, path_length_m, flight_time_s=13.0, **more):
    """A flight of 26 m at 2 m/s, as a row of the campaign's table."""
    return {
        "replicate": 0,
        "algorithm": "improved",
        "speed_m_s": 2.0,
        "cepa.velocity_aware_emergency": False,
        "cepa.levelling": False,
        "reached": end == "goal",
        "collision": end == "collision",
        "stuck": end == "stuck",
        "path_length_m": path_length_m,
        "flight_time_s": flight_time_s,
        "time_over_straight": flight_time_s / 13.0,
        "min_clearance_m": 0.5,
        "emergencies": 0,
        **more,
    }


def test_flights_are_counted_by_what_flew_where_every_speed_did():
    campaign = read_campaign(Path("avoidance"), seeds=1)
    rows = [
        flight("goal", 26.0),
        flight("goal", 26.0, replicate=3),
        flight("goal", 26.0, speed_m_s=4.0),
        flight("stuck", 9.0, **{"cepa.levelling": True}),
        flight("collision", 4.0, algorithm="original"),
    ]
    sets = mixed_forests.sets(campaign, pd.DataFrame(rows))
    assert {name: len(flights) for name, flights in sets.items()} == {
        "improved_at_2_m_s": 2,
        "improved.all": 2,
        "improved.2_m_s": 1,
        "improved.4_m_s": 1,
        "improved_levelling.all": 1,
        "improved_levelling.2_m_s": 1,
        "original.all": 1,
        "original.2_m_s": 1,
    }
    assert mixed_forests.failures(pd.DataFrame(rows)).splitlines() == [
        "forest   0, improved_levelling, 2 m/s: stuck after 13.0 s",
        "forest   0, original, 2 m/s: collision after 13.0 s",
    ]


def test_collisions_count_by_what_was_flown():
    rows = [flight("goal", 30.0), flight("goal", 26.0, 26.0), flight("collision", 4.0)]
    metrics = mixed_forests.metrics(pd.DataFrame(rows))
    assert metrics["collisions_per_km"] == pytest.approx(1 / 0.06)
    assert metrics["reached"] == pytest.approx(2 / 3)
    assert metrics["stuck"] == 0.0
    assert metrics["time_to_goal_s"]["mean"] == pytest.approx(19.5)
    assert metrics["time_over_straight"] == pytest.approx(1.5)  # of 1 and 2: 26 m at 2 m/s take 13 s


# Clopper's and Pearson's limits: closed form for no event and for every event
@pytest.mark.parametrize(
    ("events", "low", "high"), [(0, 0.0, 1 - 0.025 ** (1 / 50)), (50, 0.025 ** (1 / 50), 1.0)]
)
def test_the_interval_of_a_share_is_clopper_and_pearsons(events, low, high):
    assert judging.share_interval(events, 50) == pytest.approx((low, high))


ROW = rows.Row("thick", "thick forests", (rows.Goal((2.0,), 0.75, 0.05, 1.4, no_slower=True),), p99_ms=2.0)


def row_flights(end="goal", flight_time_s=16.0, computation_ms=1.0, **more):
    """Four flights of the judged algorithm, of which the last ends so; three of improved."""
    common = {"world": "thick_forest", "flight_time_s": flight_time_s}
    common["time_over_straight"] = flight_time_s / 13.0
    flights = [flight("goal", 26.0, **common, replicate=i, algorithm="dynamic") for i in range(3)]
    flights.append(flight(end, 26.0, **common, replicate=3, algorithm="dynamic", **more))
    flights += [flight("goal", 26.0, 17.0, world="thick_forest", replicate=i) for i in range(3)]
    flown = pd.DataFrame(flights)
    flown["index"] = np.arange(len(flown))
    return flown, {i: [computation_ms] * 9 for i in range(4)}


def test_a_row_counts_by_place_speed_and_algorithm():
    flown, computation_ms = row_flights("collision")
    sets = judging.sets(ROW, flown)
    assert {name: len(flights) for name, flights in sets.items()} == {
        ("thick_forest", 2.0, "dynamic"): 4,
        ("thick_forest", 2.0, "improved"): 3,
    }
    metrics = judging.metrics(sets["thick_forest", 2.0, "dynamic"], computation_ms)
    assert (metrics["flights"], metrics["contacts"], metrics["reached"]) == (4, 1, 0.75)
    assert metrics["time_ratio"] == pytest.approx(16.0 / 13.0)
    assert metrics["computation_ms"] == {"p50": 1.0, "p99": 1.0}
    assert judging.key("thick_forest", 2.0, "dynamic") == "avoidance.thick_forest.2_m_s.dynamic"


@pytest.mark.parametrize(
    ("flown", "missed"),
    [
        ({}, []),
        ({"end": "collision"}, ["no contact"]),
        ({"min_clearance_m": 0.049}, ["clearance at least 0.05 m"]),
        ({"flight_time_s": 18.0}, ["time / improved's at most 1"]),
        ({"flight_time_s": 19.0}, ["time / straight at most 1.4", "time / improved's at most 1"]),
        ({"computation_ms": 2.1}, ["p99 of computation at most 2 ms"]),
    ],
)
def test_a_goal_is_met_or_missed(flown, missed):
    found = judging.verdicts(ROW, *row_flights(**flown))
    assert [verdict.goal for verdict in found if not verdict.met] == missed
    assert len(found) == 6
    assert judging.verdicts_table(found).count("missed") == len(missed)


def test_each_worse_condition_is_a_place_and_judged_alone():
    row = rows.Row(
        "adverse", "", (rows.Goal((2.0,)),), worse={"urg": ("lidar", "urg"), "wind": ("wind_m_s", 5.0)}
    )
    common = {"world": "spaced_forest", "algorithm": "dynamic"}
    flown = pd.DataFrame(
        [
            flight("goal", 26.0, **common, lidar="urg", wind_m_s=0.0),
            flight("collision", 26.0, **common, lidar="ust", wind_m_s=5.0),
        ]
    )
    flown["index"] = [0, 1]
    assert [place for place, _, _ in judging.sets(row, flown)] == ["urg", "wind"]
    found = judging.verdicts(row, flown, {})
    assert [(verdict.name, verdict.met) for verdict in found] == [("urg", True), ("wind", False)]


def test_no_two_rows_have_a_place_in_common():
    """Their keys would be the same."""
    places = []
    for row in rows.ROWS:
        if row is rows.REAL_TIME:
            continue
        settings = pd.DataFrame(read_campaign(Path(row.campaign)).combinations)
        places += list(dict.fromkeys(row.places(settings)))
    assert len(places) == len(set(places))
    assert {"thick_forest", "without_window", "wind", "crossing", "cables"} <= set(places)


@pytest.mark.parametrize(
    ("result", "end"),
    [
        ({}, "reached"),
        ({"collision": True}, "collision"),
        ({"reached_goal": False, "collision": True}, "collision"),
        ({"reached_goal": False}, "stuck"),
    ],
)
def test_a_flight_through_the_graph_is_judged_as_one_without(tmp_path, result, end):
    content = {
        "reached_goal": True,
        "collision": False,
        "flight_time_s": 13.0,
        "path_length_m": 30.0,
        "min_clearance_m": 0.3,
        "emergencies": 0,
        "real_time_factor": 1.0,
        "times_s": {"flying": 8.0},
    }
    (tmp_path / "result.json").write_text(json.dumps({**content, **result}))
    lines = [f"{t},{ms}" for t, ms in [(7.0, 99.0), *((8.0 + i, i) for i in range(20))]]
    (tmp_path / "decisions.csv").write_text("\n".join(["t_s,computation_ms", *lines]))
    found = real_time.outcome_of(tmp_path / "result.json", straight_s=6.5)
    assert [name for name in ("reached", "collision", "stuck") if found[name]] == [end]
    assert found["computation_ms"] == [5.0, 15.0]  # of 0 to 19; what was before the goal does not count
    if end == "reached":
        assert found["time_over_straight"] == 2.0


def test_a_benchmark_with_failed_trials_ends_and_resumes_with_them(tmp_path):
    given = trial_options("A test.").parse_args(["--results", str(tmp_path), "--workers", "1"])
    good, bad = Trial("good", int, {}), Trial("bad", int, {"x": "no number"})
    with pytest.raises(SystemExit, match="1 of 2 trials failed; call again with --resume to go on"):
        run_all("x", [good, bad], given)
    given.resume = True
    before = (tmp_path / "x_trials.jsonl").read_text()
    assert run_all("x", [good], given) == [0]
    assert (tmp_path / "x_trials.jsonl").read_text() == before


def test_the_narrow_hallway_is_as_wide_as_it_says(tmp_path):
    path = tmp_path / "hallway.world"
    path.write_text(places.hallway(2.4))
    questions = places.questions(str(path), np.random.default_rng(1), 20, (15.0, 0.6), 0.5)
    ranges = np.array([question.scan.ranges for question in questions])
    assert ranges.min() > 0.5
    across = (ranges[:, :720] + ranges[:, 720:]).min(axis=1)  # opposite beams; wider where a door is
    assert np.median(across) == pytest.approx(2.4, abs=6 * places.NOISE_M)


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


@pytest.mark.flight
def test_cepa_is_benchmarked(run):
    written, said = run(cepa, "--scenarios", "forest", "--goal", "3", "--places", "20")
    forest = written["cepa"]["forest"]
    assert forest["original"]["directions"] > 4 * 1000  # four speeds in each of the beams that are seen
    assert forest["improved"]["directions"] < forest["original"]["directions"] / 10
    assert forest["speedup"] == pytest.approx(forest["original"]["mean_us"] / forest["improved"]["mean_us"])
    assert forest["speedup"] > 50  # 300 on a quiet machine
    assert written["cepa"]["worst_hallway"]["max_us"] > 0.0
    assert written["cepa"]["first_call_s"] > 0.0
    assert "thesis, improved / original" in said


@pytest.mark.flight
def test_the_campaign_is_flown(run, tmp_path):
    written, said = run(avoidance, "--smallest", "--workers", "1", "--rows", "mixed", "thick")
    campaign = written["cepa"]["campaign"]
    for name in ("improved", "original", "improved_velocity_aware", "improved_levelling"):
        assert campaign[name]["all"]["flights"] == 2
        assert campaign[name]["4_m_s"]["flights"] == 1
    assert campaign["improved_at_2_m_s"]["collisions"] == 0
    assert campaign["improved_at_2_m_s"]["distance_km"] > 1e-3 * (8.0 - 0.2)
    assert (tmp_path / "avoidance/flights.png").read_bytes().startswith(b"\x89PNG")
    assert "improved, all" in said
    thick = written["avoidance"]["thick_forest"]["4_m_s"]["improved"]
    assert thick["flights"] == 1
    assert thick["computation_ms"]["p99"] > 0.0
    assert "thick forests" in said


@pytest.mark.flight
def test_the_table_of_experiment_1_is_flown(run, tmp_path):
    few = ("--scenarios", "forest", "--seeds", "1", "--goal", "3", "--workers", "1")
    written, said = run(experiment_1, *few)
    improved = written["experiment_1"]["forest"]["improved"]
    assert improved["reached_goal"] == improved["flights"] == 1
    assert improved["collisions"] == 0
    assert improved["computation_ms"]["mean"] > 0.0
    assert 1.5 < improved["flight_time_s"]["mean"] < 6.0  # 3 m at 2 m/s, around a trunk
    assert (tmp_path / "experiment_1.md").read_text() in said
    assert (tmp_path / "experiment_1.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.flight
def test_the_simulator_s_rays_are_benchmarked_as_bringup_does(tmp_path):
    command = (sys.executable, "-m", "benchmarks.sim", "--results", str(tmp_path), "--parts", "raycast")
    libraries = os.pathsep.join([*map(str, ROOT.glob("src/*/src")), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": libraries}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    rays = json.loads((tmp_path / "benchmarks.json").read_text())["sim"]["raycast"]
    assert 1.0 < rays["mrays_s"] < rays["embree_mrays_s"]  # 14 and 20 on a quiet machine
    assert sim.ANCHORS["raycast.mrays_s"].text in done.stdout


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
