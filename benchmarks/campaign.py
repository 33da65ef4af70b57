"""Campaigns: trials per core-second, what two workers are worth, and what a trial costs beside its flight.

The same flights (26 m through random forests at 2 m/s) by one worker and by two of a local Dask cluster.
Overhead is the time of the run with one worker, from the first submission until the table is on disk, over
that of its trials; starting the cluster is not in it. Wall times count here, so the machine should be idle.

Figures: campaign.{trials_per_core_s, cpu_s_per_trial, scaling_1_to_2, overhead_percent, cluster_start_s}.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from benchmarks._report import Report, options, table
from master_thesis.campaign.reading import campaign_of
from master_thesis.campaign.run import run_campaign
from master_thesis.campaign.store import CampaignFolder
from master_thesis.campaign.workers import Workers

TRIALS = 60
BRIEF_TRIALS = 20


@dataclass(frozen=True)
class Timed:
    """A run: from the first submission to the table, and the trials' own wall and processor time."""

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
    with Report("campaign", given.results, vars(given)) as report:
        one, two = timed(number, 1), timed(number, 2)
        if one.table != two.table:
            raise SystemExit("One worker and two have not made the same table.")
        figures = {
            "trials_per_core_s": number / one.elapsed_s,
            "cpu_s_per_trial": one.trials_cpu_s / number,
            "scaling_1_to_2": one.elapsed_s / two.elapsed_s,
            "overhead_percent": 100.0 * (one.elapsed_s / one.trials_s - 1.0),
            "cluster_start_s": two.start_s,
        }
        for name, value in figures.items():
            report.add(f"campaign.{name}", value)
        print(table(("figure", "value"), [(name, f"{value:.2f}") for name, value in figures.items()]))


def timed(number: int, workers: int) -> Timed:
    """Fly a campaign of that many trials with that many workers, once warm."""
    campaign = campaign_of({"seeds": number, "trials": {"world": "random_forest"}}, "benchmark")
    started = time.perf_counter()
    with Workers(workers) as cluster, tempfile.TemporaryDirectory() as folder:
        start_s = time.perf_counter() - started
        _run(
            campaign_of({"seeds": workers, "trials": {"world": "empty"}}, "warm"),
            Path(folder, "warm"),
            cluster,
        )
        begun = time.perf_counter()
        path = Path(folder, "measured")
        costs = _run(campaign, path, cluster)
        elapsed_s = time.perf_counter() - begun
        content = (path / "trials.csv").read_bytes()
    wall_s, cpu_s = (sum(cost[name] for cost in costs) for name in ("wall_s", "cpu_s"))
    return Timed(start_s, elapsed_s, wall_s, cpu_s, content)


def _run(campaign, path: Path, workers: Workers) -> list[dict]:
    with CampaignFolder(path, campaign) as folder:
        run_campaign(campaign, folder, workers)
        return folder.costs()


if __name__ == "__main__":
    main()
