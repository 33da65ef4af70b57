"""Experiment 1 as a table: both algorithms in all four scenarios, over several seeds (thesis, table 8.1).

Flown in the ROS-free closed loop, one flight on each core; CEPA's computation time is measured inside it,
from the goal's sending to its being reached. Figures are means over the seeds with standard deviations.

Figures: experiment_1.SCENARIO.ALGORITHM; and results/experiment_1.{md, json, png}.
"""

from __future__ import annotations

import io
import itertools
import json
import os
from concurrent.futures import ProcessPoolExecutor
from typing import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from tqdm import tqdm

from benchmarks._flights import WORLDS, scenario
from benchmarks._report import Report, options, table, write_atomically
from benchmarks._thesis import TABLE_8_1_MS
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.experiment import Phase
from master_thesis.results import analysis, run_report
from master_thesis.worlds import scenario as scenarios

COLUMNS = {
    "computation_ms": ("CEPA's mean [ms]", 3),
    "computation_p99_ms": ("p99 [ms]", 3),
    "directions": ("directions", 0),
    "flight_time_s": ("flight time [s]", 1),
    "path_length_m": ("path [m]", 1),
    "clearance_m": ("least clearance [m]", 2),
    "emergencies": ("emergency scans", 1),
}
"""The figures of a flight: heading and decimals."""
SEEDS = (1, 2, 3, 4, 5)
LEAST_MS = 0.005
"""The foot of the picture's logarithmic scale; the thesis's "~ 0" stands there."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = options(__doc__)
    parser.add_argument("--seeds", nargs="+", type=int, default=SEEDS)
    parser.add_argument("--scenarios", nargs="+", default=scenarios.SCENARIOS, choices=scenarios.SCENARIOS)
    parser.add_argument("--goal", type=float, default=40.0, metavar="M", help="distance to fly in m")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N", help="processes that fly")
    given = parser.parse_args(arguments)
    with Report("experiment_1", given.results, vars(given)) as report:
        flown = fly_all(given.scenarios, given.seeds, given.goal, given.workers)
        figures = {
            name: {algorithm: summary(flown[name, algorithm]) for algorithm in TABLE_8_1_MS}
            for name in given.scenarios
        }
        report.add("experiment_1", figures)
        text = as_markdown(figures, len(given.seeds))
        write_atomically(given.results / "experiment_1.md", text)
        write_atomically(given.results / "experiment_1.json", json.dumps(figures, indent=2) + "\n")
        write_atomically(given.results / "experiment_1.png", png(figures))
        print(f"\n{text}")


def fly_all(names: Sequence[str], seeds: Sequence[int], goal_x_m: float, workers: int) -> dict:
    """Fly every scenario with both algorithms and all seeds; return the flights by (scenario, algorithm)."""
    flights = list(itertools.product(names, TABLE_8_1_MS, seeds, [goal_x_m]))
    with ProcessPoolExecutor(workers) as pool:
        flown = list(tqdm(pool.map(fly, *zip(*flights)), "flights", len(flights), unit=" flights"))
    found: dict = {}
    for (name, algorithm, *_), figures in zip(flights, flown):
        found.setdefault((name, algorithm), []).append(figures)
    return found


def fly(name: str, algorithm: str, seed: int, goal_x_m: float = 40.0) -> dict:
    """Fly one scenario once; return the figures of the flight."""
    with ClosedLoop(scenario(name, algorithm, seed, goal_x_m)) as loop:
        outcome = loop.run_to(Phase.LANDING)
        log = loop.log
    goal = (goal_x_m, 0.0, scenarios.FLIGHT_HEIGHT_M)
    flown = scenarios.Scenario(name, WORLDS / f"{name}.world", goal_xyz_m=goal)
    description = run_report.RunDescription("experiment_1", flown, algorithm, "ust", seed)
    merit = run_report.figures_of_merit(log, outcome, goal)
    return {
        "reached_goal": outcome.reached_goal,
        "collision": outcome.collision,
        "computation_ms": merit["cepa_computation_ms"]["mean"],
        "computation_p99_ms": merit["cepa_computation_ms"]["p99"],
        "directions": merit["cepa_directions_tested"]["mean"],
        "flight_time_s": merit["flight_time_s"],
        "path_length_m": merit["path_length_m"],
        "clearance_m": run_report.least(analysis.clearances(description, log, outcome)),
        "emergencies": merit["emergencies"],
    }


def summary(flown: Sequence[dict]) -> dict:
    """Return mean and standard deviation of every figure over the flights, and how many arrived untouched."""
    figures = {
        "flights": len(flown),
        "reached_goal": sum(flight["reached_goal"] for flight in flown),
        "collisions": sum(flight["collision"] for flight in flown),
    }
    for key in COLUMNS:
        values = [flight[key] for flight in flown if flight[key] is not None]
        figures[key] = {"mean": float(np.mean(values)), "std": float(np.std(values))} if values else None
    return figures


def as_markdown(figures: dict, seeds: int) -> str:
    """Return table 8.1, theirs and ours, and the flights' other figures."""
    names = list(figures)
    rows = [
        (f"thesis, {algorithm}", *(TABLE_8_1_MS[algorithm][name] or "~ 0" for name in names))
        for algorithm in TABLE_8_1_MS
    ]
    rows += [
        (f"ours, {algorithm}", *(_spread(figures[name][algorithm]["computation_ms"], 3) for name in names))
        for algorithm in TABLE_8_1_MS
    ]
    others = [
        (
            f"{name}, {algorithm}",
            f"{values['reached_goal']}/{values['flights']}",
            values["collisions"],
            *(_spread(values[key], digits) for key, (_, digits) in COLUMNS.items()),
        )
        for name, by_algorithm in figures.items()
        for algorithm, values in by_algorithm.items()
    ]
    header = ("flights", "reached goal", "collisions", *(heading for heading, _ in COLUMNS.values()))
    return (
        f"# Experiment 1\n\nMean and standard deviation over {seeds} seeds.\n\n"
        f"{table(('computation time [ms]', *names), rows)}\n\n{table(header, others)}\n"
    )


def _spread(value: dict | None, digits: int) -> str:
    return f"{value['mean']:.{digits}f} ± {value['std']:.{digits}f}" if value else "-"


def png(figures: dict) -> bytes:
    """Draw the computation times, the thesis's and ours, on a logarithmic scale; return the PNG's bytes."""
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    axes = figure.add_subplot()
    names, width = list(figures), 0.2
    places = np.arange(len(names))
    for column, (whose, algorithm) in enumerate(
        (whose, algorithm) for algorithm in TABLE_8_1_MS for whose in ("thesis", "ours")
    ):
        if whose == "thesis":
            means, spread = [TABLE_8_1_MS[algorithm][name] or LEAST_MS for name in names], None
        else:
            ours = [figures[name][algorithm]["computation_ms"] for name in names]
            means, spread = [value["mean"] for value in ours], [value["std"] for value in ours]
        colour = {"original": "#c2410c", "improved": "#1f3b73"}[algorithm]
        bars = axes.bar(
            places + (column - 1.5) * width,
            means,
            width,
            yerr=spread,
            capsize=2,
            facecolor=colour if whose == "ours" else "white",
            edgecolor=colour,
            hatch=None if whose == "ours" else "////",
            label=f"{algorithm}, {whose}",
        )
        axes.bar_label(
            bars, [f"{mean:.2g}" if mean > LEAST_MS else "~ 0" for mean in means], fontsize=6, padding=2
        )
    axes.set_yscale("log")
    axes.set_ylim(LEAST_MS, 100.0)
    axes.set_xticks(places, names)
    axes.set_ylabel("mean computation time [ms]", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=7, ncol=4, frameon=False, loc="upper center")
    stream = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(stream, format="png", dpi=200)
    return stream.getvalue()


if __name__ == "__main__":
    main()
