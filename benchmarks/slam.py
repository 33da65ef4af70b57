"""gridslam beside gmapping: accuracy on the Intel log, CPU time, memory and rendering.

The Intel Research Lab (180 beams, real odometry) with 30 particles, cells of 5 cm and gmapping's default
thresholds, judged by hand-verified relative poses: the best particle's path in the end, and online, that is,
the newest map -> odom at each scan. "Exact" are the relations between stamps of scans, "all" the others
too, whose stamps the log has only interpolated. Each run is a process of its own, on one thread, with its
kernels compiled; times are CPU times, user and system, memory is the process's peak, Python and numba too.
Where the log is absent, that part is left out, saying so.

Keys: slam.intel.{exact_final_m, exact_online_m, all_final_m, all_online_m, cpu_ms_per_scan, cost_growth,
render_ms, peak_mb}, means over the seeds, the last one the greatest, and slam.beams360.{cpu_ms_per_scan,
peak_mb, ...}. cost_growth is the mean cost of the last quarter of the processed scans by that of the first.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared.anchors import HEADING, Anchor, sources
from benchmarks.shared.results import ROOT, Results, options, table

DATA = ROOT.parent / "shared/data"
GMAPPING = {
    "exact_final_m": 0.029,
    "exact_online_m": 0.077,
    "all_final_m": 0.100,
    "all_online_m": 0.162,
    "cpu_ms_per_scan": 63.0,
    "peak_mb": 430.0,
}
GMAPPING_360 = {"cpu_ms_per_scan": 120.0}
ANCHOR = Anchor(
    "gmapping",
    "slam_gmapping (C++, -O3) on the same log with the same parameters and seeds (360 beams: another log); "
    "measured once, before this benchmark was written, on a machine of two cores that is not described",
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = options(__doc__)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3], metavar="SEED")
    parser.add_argument(
        "--data", type=Path, default=DATA, help="folder with intel_dense.log.gz and its relations"
    )
    given = parser.parse_args(arguments)
    with Results("slam", given.results, vars(given)) as results:
        runs = {"beams360": [measure("beams360", seed) for seed in tqdm(given.seeds, "360 beams")]}
        missing = [
            name for name in ("intel_dense.log.gz", "intel.relations.gz") if not (given.data / name).exists()
        ]
        if missing:
            print(f"slam.intel is left out: {given.data} has no {' and no '.join(missing)}.")
        else:
            runs["intel"] = [measure("intel", seed, given.data) for seed in tqdm(given.seeds, "Intel log")]
        for name, metrics in runs.items():
            results.add(f"slam.{name}", summary(metrics))
        print()
        for name, peer in (("intel", GMAPPING), ("beams360", GMAPPING_360)):
            if name in runs:
                print(f"{comparison(name, given.seeds, runs[name], peer)}\n")
        print(sources([ANCHOR]))


def measure(name: str, seed: int, *data: Path) -> dict:
    """Return the metrics of one run in a separate process."""
    command = [sys.executable, "-m", "benchmarks.shared.slam_run", name, str(seed), *map(str, data)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    return json.loads(done.stdout)


def summary(runs: list[dict]) -> dict:
    """Return the means over the seeds; for memory and the slowest rendering the greatest value."""
    return {
        key: (max if key in ("peak_mb", "render_max_ms") else np.mean)([run[key] for run in runs])
        for key in runs[0]
    }


def comparison(name: str, seeds: Sequence[int], runs: list[dict], peer: dict) -> str:
    """Return a table of the seeds' metrics, their summary, and gmapping's from elsewhere."""
    header = (name, *(f"seed {seed}" for seed in seeds), "summary", f"{ANCHOR.text} ({HEADING})")
    whole = summary(runs)
    rows = [
        (key, *(_number(run[key]) for run in runs), _number(whole[key]), _number(peer.get(key)))
        for key in runs[0]
    ]
    return table(header, rows)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


if __name__ == "__main__":
    main()
