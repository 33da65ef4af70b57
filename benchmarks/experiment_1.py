"""Experiment 1 as a table: each algorithm in all four scenarios, over several seeds (thesis, table 8.1).

Flown in the ROS-free closed loop, one flight on each core. CEPA's computation time is measured in flight,
from sending the goal to reaching it. The table has means over the seeds with standard deviations.

Keys: experiment_1.SCENARIO.ALGORITHM; and results/experiment_1.{md, json, png}.
"""

from __future__ import annotations

import argparse
import json
from typing import Sequence

import numpy as np

from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_crossed, trial_options
from flights.files import replace_file
from flights.results.picture_files import png
from flights.worlds import scenario as scenarios
from master_thesis.experiment_1.pictures import times_figure
from master_thesis.experiment_1.pieces import ALGORITHMS
from master_thesis.experiment_1.scenario_flight import fly_scenario, scenario_parameters
from master_thesis.report.thesis import TABLE_8_1_MS

COLUMNS = {
    "computation_ms": ("CEPA's mean [ms]", 3),
    "computation_p99_ms": ("p99 [ms]", 3),
    "directions": ("directions", 0),
    "flight_time_s": ("flight time [s]", 1),
    "path_length_m": ("path [m]", 1),
    "clearance_m": ("clearance [m]", 2),
    "emergencies": ("emergency scans", 1),
}
"""The metrics of a flight: heading and decimals."""
SEEDS = (1, 2, 3, 4, 5)


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--seeds", nargs="+", type=int, default=SEEDS)
    parser.add_argument("--scenarios", nargs="+", default=scenarios.SCENARIOS, choices=scenarios.SCENARIOS)
    parser.add_argument("--algorithms", nargs="+", default=ALGORITHMS, choices=ALGORITHMS)
    parser.add_argument(
        "--k_previous", type=float, default=0.0, metavar="K", help="CEPA's, for improved; 0: the thesis"
    )
    parser.add_argument("--goal", type=float, default=40.0, metavar="M", help="distance to fly in m")
    given = parser.parse_args(arguments)
    with Results("experiment_1", given.results, vars(given)) as results:
        flown = fly_all(given)
        metrics = {
            name: {algorithm: summary(flown[name, algorithm]) for algorithm in given.algorithms}
            for name in given.scenarios
        }
        results.add("experiment_1", metrics)
        text = as_markdown(metrics, len(given.seeds))
        replace_file(given.results / "experiment_1.md", text)
        replace_file(given.results / "experiment_1.json", json.dumps(metrics, indent=2) + "\n")
        replace_file(given.results / "experiment_1.png", png(times_figure(computation_times(metrics))))
        print(f"\n{text}")


def fly_all(given: argparse.Namespace) -> dict:
    """Fly every scenario with each algorithm and all seeds; return the flights by (scenario, algorithm)."""
    axes = {"name": given.scenarios, "algorithm": given.algorithms, "seed": given.seeds}
    axes |= {"goal_x_m": (given.goal,), "k_previous": (given.k_previous,)}
    found: dict = {}
    for (name, algorithm, *_), flown in run_crossed("experiment_1", fly, given, **axes).items():
        found.setdefault((name, algorithm), []).append(flown)
    return found


def fly(name: str, algorithm: str, seed: int, goal_x_m: float = 40.0, k_previous: float = 0.0) -> dict:
    """Fly one scenario once; return the metrics of the flight."""
    return fly_scenario(scenario_parameters(name, algorithm, seed, goal_x_m, k_previous)).metrics


def summary(flown: Sequence[dict]) -> dict:
    """Return how many arrived and touched, the least clearance, and mean and deviation of every metric.

    The least clearance is that of all flights; None: nothing was near.
    """
    metrics = {
        "flights": len(flown),
        "reached_goal": sum(flight["reached_goal"] for flight in flown),
        "collisions": sum(flight["collision"] for flight in flown),
        "least_clearance_m": min(
            (flight["clearance_m"] for flight in flown if flight["clearance_m"] is not None), default=None
        ),
    }
    for key in COLUMNS:
        values = [flight[key] for flight in flown if flight[key] is not None]
        metrics[key] = {"mean": float(np.mean(values)), "std": float(np.std(values))} if values else None
    return metrics


def computation_times(metrics: dict) -> dict:
    """Return mean and spread of the computation time by (scenario, algorithm)."""
    return {
        (name, algorithm): (values["computation_ms"]["mean"], values["computation_ms"]["std"])
        for name, by_algorithm in metrics.items()
        for algorithm, values in by_algorithm.items()
    }


def as_markdown(metrics: dict, seeds: int) -> str:
    """Return table 8.1, the thesis's and ours, and the flights' other metrics."""
    names = list(metrics)
    rows = [
        (f"thesis, {algorithm}", *(TABLE_8_1_MS[algorithm][name] or "~ 0" for name in names))
        for algorithm in TABLE_8_1_MS
    ]
    rows += [
        (f"ours, {algorithm}", *(_spread(metrics[name][algorithm]["computation_ms"], 3) for name in names))
        for algorithm in metrics[names[0]]
    ]
    others = [
        (
            f"{name}, {algorithm}",
            f"{values['reached_goal']}/{values['flights']}",
            values["collisions"],
            "-" if values["least_clearance_m"] is None else f"{values['least_clearance_m']:.3f}",
            *(_spread(values[key], digits) for key, (_, digits) in COLUMNS.items()),
        )
        for name, by_algorithm in metrics.items()
        for algorithm, values in by_algorithm.items()
    ]
    header = (
        "flights",
        "reached goal",
        "contacts",
        "least clearance [m]",
        *(heading for heading, _ in COLUMNS.values()),
    )
    return (
        f"# Experiment 1\n\nMean and standard deviation over {seeds} seeds.\n\n"
        f"{table(('computation time [ms]', *names), rows)}\n\n{table(header, others)}\n"
    )


def _spread(value: dict | None, digits: int) -> str:
    return f"{value['mean']:.{digits}f} ± {value['std']:.{digits}f}" if value else "-"


if __name__ == "__main__":
    main()
