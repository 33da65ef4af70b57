"""gridslam on logs and places of every kind: accuracy, CPU time and memory, beside goals.

`csail`, `aces`, `intel` and `corridor` are bags that `gridslam_replay` maps with gmapping's default
thresholds, as a user would, with and without loop closure. Their paths are judged by the ATE after rigid
alignment; that of Intel by hand-verified relations, "exact" ones between stamps of scans, and all. `hold` is
Experiment 4 in the closed loop, with all lidars, odometry drifting as by default and three times as much.
`hall` is 300 x 300 m wide, seen with 80 m; `beams360` and `beams10000` are lidars in a hold; these three
and the costs of Intel (`cost_growth`, `render_ms`) are the filter alone. The hall is mapped with loop
closure, too. `no_imu` is `lidar_odometry` with scans alone, of a robot that turns at 186 degrees/s.
`two_hours` is laps in known corridors: memory and CPU time of the second hour beside those of the first.
`small_robot` drives through rooms of a few metres with turns and gaps, and in `slipped_step` a wheel slips in
a turn that no scan spans: the state beside the true error.

Each run of a log, a hall and a lidar is a process of its own, on one thread, with its kernels compiled. Times
are CPU times, user and system; memory is the process's peak, Python and numba too. Where a log is absent, it
is left out, saying so.

`ate_online` judges the path as it was published on the way, from the first scan on.
`published_by_best_after_closures` is the error of the path as it was published just after each closure, by
that of the final path if the log had ended there. `online_by_final_since_closure` is the error of the online
path by that of the final one, both from the first closure on; the drift until the next closure counts, too.

Keys: slam.LOG.{ate_worst_m, ate_median_m, ate_online_worst_m, cpu_ms_per_scan, cpu_ms_p95, peak_mb, ...} over
the seeds, and the same under .without_loop_closure. slam.intel also has {exact_final_m, exact_online_m,
all_final_m, all_online_m, cost_growth, render_ms, ...}, means over the seeds. slam.{hold_x1, hold_x3}.LIDAR.
slam.{beams360, beams10000, hall}.{cpu_ms_per_scan, peak_mb, ...}; the latter also has with_loop_closure.
slam.LOG.gmapping has the same of the program of `--gmapping`, or left_out: a sentence that tells why.
cost_growth is the mean cost of the last quarter of the processed scans by that of the first.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared.results import ROOT, Results
from benchmarks.shared.trials import trial_options
from benchmarks.slam_rows import gmapping, goals, hold
from benchmarks.slam_rows.logs import LOGS

DATA = ROOT.parent / "shared/data"
SEEDS = tuple(range(1, 11))
BRIEF_SEEDS = (1,)
SIMULATED = {"beams360": 3, "beams10000": 1, "hall": 1}
"""Logs that `shared.slam_run` makes, and the most seeds that are run, because they take long."""
COSTS = 3
"""Seeds of Intel's costs."""
TWO_HOURS = 3
"""Seeds of two hours of laps, which take minutes each."""
GMAPPINGS = 3
"""Seeds of gmapping, which takes minutes for a log."""
WITH_TRUE_POSES = ("csail", "aces", "corridor")
ALONE = ("no_imu", "two_hours", "small_robot", "slipped_step")
"""Rows that are modules of `slam_rows`, with a process for each seed. The worst seed counts."""
ROWS = (*LOGS, "hold", *SIMULATED, *ALONE)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--seeds", nargs="+", type=int, default=None, metavar="SEED")
    parser.add_argument("--rows", nargs="+", default=ROWS, choices=ROWS, metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--data", type=Path, default=DATA, help="folder with the bags and their true paths")
    parser.add_argument(
        "--gmapping",
        type=Path,
        metavar="PROGRAM",
        help="slam_gmapping_replay, which maps the logs beside ours",
    )
    given = parser.parse_args(arguments)
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    with Results("slam", given.results, vars(given)) as results:
        measured: dict[str, dict] = {}
        for row in given.rows:
            measured.update(measure(row, seeds, given))
        for name, metrics in measured.items():
            results.add(f"slam.{name}", metrics)
        print(f"\n{len(seeds)} seeds.\n\n{goals.as_table(measured)}")
        if given.gmapping:
            print(f"\n{gmapping.as_table(measured)}")


def measure(row: str, seeds: Sequence[int], given: argparse.Namespace) -> dict[str, dict]:
    """Return the metrics of a row by the logs' names in the keys; nothing where its files are absent."""
    if row == "hold":
        return hold.measure(seeds, given)
    if row in ALONE:
        seeds = seeds[:TWO_HOURS] if row == "two_hours" else seeds
        runs = [run_alone(row, seed, module=f"benchmarks.slam_rows.{row}") for seed in tqdm(seeds, row)]
        return {row: {name: max(run[name] for run in runs) for name in runs[0]}}
    if row in SIMULATED:
        seeds = seeds[: SIMULATED[row]]
        alone = means([run_alone(row, seed) for seed in tqdm(seeds, row)])
        if row == "hall":
            runs = [run_alone("hall_closed", seed) for seed in tqdm(seeds, "hall_closed")]
            alone["with_loop_closure"] = means(runs)
        return {row: alone}
    log = LOGS[row]
    if missing := log.missing(given.data):
        print(f"slam.{row} is left out: {given.data} has no {' and no '.join(missing)}.")
        return {}
    costs = {}
    if row == "intel" and (given.data / "intel_dense.log.gz").exists():
        costs = means([run_alone(row, seed, given.data) for seed in tqdm(seeds[:COSTS], "Intel's costs")])
    closed, alone = (log.measure(given.data, seeds, closure) for closure in (True, False))
    if row in WITH_TRUE_POSES:
        module, bar = "benchmarks.slam_rows.after_closures", tqdm(seeds, f"{log.bag}, after closures")
        closed.update(means([run_alone(row, seed, given.data, module=module) for seed in bar]))
    metrics = {**costs, **closed, "without_loop_closure": alone}
    if given.gmapping:
        metrics["gmapping"] = gmapping.measure(given.gmapping, log, given.data, seeds[:GMAPPINGS])
    return {row: metrics}


def run_alone(name: str, seed: int, *data: Path, module: str = "benchmarks.shared.slam_run") -> dict:
    """Return the metrics of one run in a separate process."""
    command = [sys.executable, "-m", module, name, str(seed), *map(str, data)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    return json.loads(done.stdout)


def means(runs: Sequence[dict[str, Any]]) -> dict:
    """Return the means over the seeds; for memory and the slowest rendering the greatest value."""
    return {
        key: (max if key in ("peak_mb", "render_max_ms") else np.mean)([run[key] for run in runs])
        for key in runs[0]
    }


if __name__ == "__main__":
    main()
