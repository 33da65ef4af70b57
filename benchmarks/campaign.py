"""Campaigns: trials per core-second, one worker against two, and the overhead of a trial.

The same flights (26 m through random forests at 2 m/s) by one worker and by two of a local Dask cluster.
Overhead is the time of the run with one worker, from the first submission until the table is on disk, over
that of its trials; starting the cluster is not in it. Wall times count here, so the machine should be idle.

Keys: campaign.{trials_per_core_s, cpu_s_per_trial, scaling_1_to_2, overhead_percent, cluster_start_s}.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import pandas as pd

from benchmarks.shared.results import Results, options, table
from master_thesis.campaign.campaign import Campaign
from master_thesis.campaign.folder import COSTS, TABLE, CampaignFolder
from master_thesis.campaign.reading import campaign_of
from master_thesis.trials.dask_workers import DaskWorkers

TRIALS = 60
BRIEF_TRIALS = 20


@dataclass(frozen=True)
class Timed:
    """The times of a run: from the first submission to the table, and the trials' own wall and CPU time."""

    start_s: float
    elapsed_s: float
    trials_s: float
    trials_cpu_s: float
    table: bytes


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = options(__doc__)
    parser.add_argument("--trials", type=int, metavar="N", help="flights of each run")
    given = parser.parse_args(arguments)
    number = given.trials or (BRIEF_TRIALS if given.brief else TRIALS)
    with Results("campaign", given.results, vars(given)) as results:
        one, two = timed(number, 1), timed(number, 2)
        if one.table != two.table:
            raise SystemExit("One worker and two have not made the same table.")
        metrics = {
            "trials_per_core_s": number / one.elapsed_s,
            "cpu_s_per_trial": one.trials_cpu_s / number,
            "scaling_1_to_2": one.elapsed_s / two.elapsed_s,
            "overhead_percent": 100.0 * (one.elapsed_s / one.trials_s - 1.0),
            "cluster_start_s": two.start_s,
        }
        for name, value in metrics.items():
            results.add(f"campaign.{name}", value)
        print(table(("figure", "value"), [(name, f"{value:.2f}") for name, value in metrics.items()]))


def timed(number: int, workers: int) -> Timed:
    """Fly a campaign with this many trials and workers, after a warm-up."""
    campaign = campaign_of({"seeds": number, "trials": {"world": "random_forest"}}, "benchmark")
    started = time.perf_counter()
    with DaskWorkers(workers) as cluster, tempfile.TemporaryDirectory() as folder:
        start_s = time.perf_counter() - started
        _run(
            campaign_of({"seeds": workers, "trials": {"world": "empty"}}, "warm"),
            Path(folder, "warm"),
            cluster,
        )
        begun = time.perf_counter()
        path = Path(folder, "measured")
        _run(campaign, path, cluster)
        elapsed_s = time.perf_counter() - begun
        content = (path / TABLE).read_bytes()
        wall_s, cpu_s = pd.read_csv(path / COSTS)[["wall_s", "cpu_s"]].sum()
    return Timed(start_s, elapsed_s, wall_s, cpu_s, content)


def _run(campaign: Campaign, path: Path, workers: DaskWorkers) -> None:
    with CampaignFolder(path, campaign) as folder:
        folder.fly(workers)


if __name__ == "__main__":
    main()
