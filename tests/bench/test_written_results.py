"""What benchmarks write: their file, their tables, what is out of bounds."""

from __future__ import annotations

import errno
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from benchmarks import px4, sim
from benchmarks.shared import results as written_results
from benchmarks.shared.results import Results, merge, table
from benchmarks.shared.trials import run_all, trial_options
from benchmarks.simulator import graph
from flights.trials.trial import Trial


def test_dotted_keys_are_nested_objects_and_leave_the_others_alone(tmp_path):
    path = tmp_path / "benchmarks.json"
    merge(path, {"sim.graph.rtf": 5.0, "cepa.empty": {"speedup": 900.0, "old": 1}})
    merge(path, {"cepa.empty": {"speedup": 950.0}, "cepa.first_call_s": np.float64(0.2)})
    assert json.loads(path.read_text()) == {
        "sim": {"graph": {"rtf": 5.0}},
        "cepa": {"empty": {"speedup": 950.0}, "first_call_s": 0.2},
    }


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


@pytest.mark.parametrize("while_it_runs", [True, False])
def test_a_full_disk_ends_a_benchmark_with_a_sentence_and_no_numbers(tmp_path, monkeypatch, while_it_runs):
    full = OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "x.png"))

    def write(*_):
        raise full

    monkeypatch.setattr(written_results, "replace_file", write)

    def run():
        with Results("cepa", tmp_path) as results:
            results.add("cepa.first_call_s", 0.2)
            if while_it_runs:
                write()

    with pytest.raises(SystemExit, match=r"bench cepa: Cannot write .*x\.png: No space left on device; free"):
        run()
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
    assert "ours / PX4 (anchor, measured elsewhere)" in px4.steps_table({}).splitlines()[0]
    assert px4.RECORDED.source
    assert "this machine" not in px4.RECORDED.source


def test_the_simulator_s_table_has_limits_and_no_other_constants_than_the_thesis_s():
    lines = sim.metrics_table({"inprocess.rtf": 45.0, "launch_s": 4.0}).splitlines()
    assert lines[0].split("|")[1:-1][-1].strip() == "the thesis's own (constants)"
    assert [cell.strip() for cell in lines[2].split("|")[1:-1]] == ["sim.inprocess.rtf", "45", ">= 45", ""]
    assert "7, until all nodes are good to go" in lines[3]


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


def test_the_graphs_latency_is_of_a_real_time_flight_without_lockstep(monkeypatch):
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

    monkeypatch.setattr(graph, "LaunchedGraph", Flight)
    monkeypatch.setattr(graph, "LOAD_S", 0.01)
    started, fast = graph.measure_start(), graph.measure_speed()
    assert (started["graph.latency_ms"], started["graph.latency_p99_ms"]) == (5.5, 9.5)
    assert {"real_time_factor:=1.0", "lockstep:=false"} <= set(flown[0])
    assert not any("latency" in name for name in fast)


def test_a_benchmark_with_failed_trials_ends_and_resumes_with_them(tmp_path):
    given = trial_options("A test.").parse_args(["--results", str(tmp_path), "--workers", "1"])
    good, bad = Trial("good", int, {}), Trial("bad", int, {"x": "no number"})
    with pytest.raises(SystemExit, match="1 of 2 trials failed; call again with --resume to go on"):
        run_all("x", [good, bad], given)
    given.resume = True
    before = (tmp_path / "x_trials.jsonl").read_text()
    assert run_all("x", [good], given) == [0]
    assert (tmp_path / "x_trials.jsonl").read_text() == before
