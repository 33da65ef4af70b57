"""CEPA's computation time: the scans of Experiment 1's flights, replayed through both algorithms.

Each scenario is flown once (improved, seed 1, a UST padded to 1440 beams). Every scan between start and goal
then goes through both algorithms in this one process, with the reference and own velocity of its instant.
Times are the thread's in `steer`, with Python's share. Each scan counts the lesser time of two replays, so
that other load on the machine hardly changes them.

Keys: cepa.SCENARIO.ALGORITHM.{median_us, p99_us, mean_us, directions}, cepa.SCENARIO.speedup (ratio of
means), cepa.worst_{hallway, thicket}.{median_us, p99_us, max_us}, cepa.first_call_s.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared import places as forests
from benchmarks.shared.flights import Question, record
from benchmarks.shared.results import Results, options, table
from cepa import ALGORITHMS, CepaParameters, Improved
from cepa.algorithm import Algorithm
from flights.campaign.trial import steering
from flights.flight.parameters import CEPA
from flights.worlds.scenario import SCENARIOS
from master_thesis.experiment_1.scenario_flight import scenario_parameters
from master_thesis.report.thesis import TABLE_8_1_MS

REPLAYS = 2
WORST = {
    "hallway": (CepaParameters(r_ub=1.5), (15.0, 0.6)),
    "thicket": (CepaParameters(r_ub=1.5), (8.0, 8.0)),
}
"""CEPA's parameters, and half the area of the places."""
HALLWAY_WIDTH_M = 2.4
THICKET_SPACING_M = 1.6
FIRST_CALL = """
import math, time
import numpy as np
from cepa import Improved, LaserScan2D
angles = -math.pi + np.arange(1440) * math.radians(0.25)
ranges = np.where(np.cos(angles) > 0.1, 1.5 / np.maximum(np.cos(angles), 0.1), np.inf)
scan = LaserScan2D(ranges, angles[0], math.radians(0.25), 0.06, 10.0)
started = time.perf_counter()
decision = Improved().steer(scan, (2.0, 0.1), (2.0, 0.0))
print(time.perf_counter() - started)
assert decision.directions_tested > 1, decision
"""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = options(__doc__)
    parser.add_argument("--places", type=int, default=400, help="places tried in each of the worst worlds")
    parser.add_argument("--scenarios", nargs="+", default=SCENARIOS, choices=SCENARIOS)
    parser.add_argument("--goal", type=float, default=40.0, metavar="M", help="distance to fly in m")
    given = parser.parse_args(arguments)
    with Results("cepa", given.results, vars(given)) as results:
        metrics = {name: measure_scenario(name, given.goal) for name in tqdm(given.scenarios, "scenarios")}
        worst = {name: measure_worst(name, given.places) for name in tqdm(WORST, "worst places")}
        first_call_s = measure_first_call(1 if given.brief else 3)
        for name, values in metrics.items():
            results.add(f"cepa.{name}", values)
        for name, values in worst.items():
            results.add(f"cepa.worst_{name}", values)
        results.add("cepa.first_call_s", first_call_s)
        print(f"\n{times_table(metrics, worst)}\n\n{thesis_table(metrics)}")
        print(f"\nFirst call in a fresh process: {first_call_s:.3f} s")


def measure_scenario(scenario: str, goal_x_m: float = 40.0) -> dict:
    """Fly a scenario, replay it; return the metrics of both algorithms."""
    questions = record(scenario_parameters(scenario, goal_x_m=goal_x_m))
    metrics = {name: replay(steering(name, CEPA), questions, REPLAYS) for name in ALGORITHMS}
    speedup = metrics["original"]["mean_us"] / metrics["improved"]["mean_us"]
    return {**metrics, "speedup": speedup, "scans": len(questions)}


def measure_worst(name: str, places: int) -> dict:
    """Replay many places of one of the worst worlds; return the improved algorithm's metrics."""
    parameters, half_xy_m = WORST[name]
    rng = np.random.default_rng(1)
    text = forests.hallway(HALLWAY_WIDTH_M) if name == "hallway" else forests.thicket(rng, THICKET_SPACING_M)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.world"
        path.write_text(text, encoding="utf-8")
        questions = forests.questions(str(path), rng, places, half_xy_m, parameters.r_lb)
    return replay(Improved(parameters), questions, REPLAYS)


def replay(algorithm: Algorithm, questions: Sequence[Question], times: int) -> dict:
    """Let an algorithm answer every question; return the metrics of its least times, in microseconds."""
    for question in questions[:3]:  # the first use compiles and loads
        algorithm.steer(*question)
    least_ns = np.full(len(questions), np.inf)
    directions = []
    for _ in range(times):
        for index, question in enumerate(questions):
            started = time.thread_time_ns()
            decision = algorithm.steer(*question)
            least_ns[index] = min(least_ns[index], time.thread_time_ns() - started)
            directions.append(decision.directions_tested)
    us = 1e-3 * least_ns
    return {
        "median_us": float(np.median(us)),
        "p99_us": float(np.percentile(us, 99)),
        "mean_us": float(us.mean()),
        "max_us": float(us.max()),
        "directions": float(np.mean(directions)),
    }


def measure_first_call(processes: int) -> float:
    """Return the median time of the first call in fresh processes, s."""
    command = [sys.executable, "-c", FIRST_CALL]
    runs = [subprocess.run(command, check=True, capture_output=True, text=True) for _ in range(processes)]
    return statistics.median(float(run.stdout) for run in runs)


def times_table(metrics: dict, worst: dict) -> str:
    """Return the computation times as a table."""
    header = ("computation time [us]", "median", "p99", "mean", "max", "directions", "speed-up")
    rows = []
    for name, values in metrics.items():
        for algorithm in ALGORITHMS:
            speedup = f"{values['speedup']:.0f}" if algorithm == "improved" else ""
            rows.append((f"{name}, {algorithm}", *_row(values[algorithm]), speedup))
    rows += [(f"worst {name}, improved", *_row(values), "") for name, values in worst.items()]
    return table(header, rows)


def _row(values: dict) -> tuple[str, ...]:
    times = (f"{values[key]:.0f}" for key in ("median_us", "p99_us", "mean_us", "max_us"))
    return (*times, f"{values['directions']:.0f}")


def thesis_table(metrics: dict) -> str:
    """Return the thesis's table 8.1 beside ours: means in milliseconds, and improved over original."""
    names = list(metrics)
    theirs = {algorithm: [times[name] for name in names] for algorithm, times in TABLE_8_1_MS.items()}
    ours = {algorithm: [1e-3 * metrics[name][algorithm]["mean_us"] for name in names] for algorithm in theirs}
    rows = []
    for whose, times_ms, digits in (("thesis", theirs, 1), ("ours", ours, 3)):
        for algorithm in TABLE_8_1_MS:
            rows.append((f"{whose}, {algorithm} [ms]", *(_about(t, digits) for t in times_ms[algorithm])))
        ratios = (i / o for o, i in zip(times_ms["original"], times_ms["improved"]))
        rows.append((f"{whose}, improved / original", *(_about(ratio, digits + 1) for ratio in ratios)))
    return table(("table 8.1: mean computation time", *names), rows)


def _about(value: float, digits: int) -> str:
    """Write a number, or the thesis's "~ 0"."""
    return f"{value:.{digits}f}" if value > 0.0 else "~ 0"


if __name__ == "__main__":
    main()
