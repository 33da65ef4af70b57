"""Campaigns: trials per core-second, one worker against two, and the overhead of a trial.

The same flights (26 m through random forests at 2 m/s) by one worker and by two of a local Dask cluster.
Overhead is the time of the run with one worker, from the first submission until the table is on disk, over
that of its trials; starting the cluster is not in it. Wall times count here, so the machine should be idle.

Peers fly between the runs, as in `sim` (`--peers`, `--px4`, `--gazebo`). Their row tells how many seconds of
flight they simulate in a second of CPU time of all their threads, and how many flights as long as ours that
would be. Of our trials the time from the goal's sending to the arrival counts, and the CPU time of all of
the trial: take-off and judging, too.

Keys: campaign.{trials_per_core_s, cpu_s_per_trial, flown_s_per_core_s, scaling_1_to_2, overhead_percent,
cluster_start_s}; campaign.peers.NAME.{flown_s_per_core_s, trials_per_core_s} or .left_out.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Sequence

import pandas as pd

from benchmarks.peers import turns as peers
from benchmarks.shared.results import Results, options, table
from flights.campaign.campaign import Campaign
from flights.campaign.folder import COSTS, TABLE, CampaignFolder
from flights.campaign.reading import campaign_of
from flights.trials.dask_workers import DaskWorkers

BY_CORE = ("flown_s_per_core_s", "trials_per_core_s")
TRIALS = 60
BRIEF_TRIALS = 20


@dataclass(frozen=True)
class Timed:
    """The times of a run: from the first submission to the table, and the trials' own.

    trials_s, trials_cpu_s: the trials' wall and CPU time. flown_s: their simulated time, from the goal's
    sending to the arrival.
    """

    start_s: float
    elapsed_s: float
    trials_s: float
    trials_cpu_s: float
    flown_s: float
    table: bytes


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = options(__doc__)
    parser.add_argument("--trials", type=int, metavar="N", help="flights of each run")
    peers.add_options(parser)
    given = parser.parse_args(arguments)
    number = given.trials or (BRIEF_TRIALS if given.brief else TRIALS)
    with Results("campaign", given.results, vars(given)) as results:
        beside = peers.turns_of(given)
        one = timed(number, 1)
        beside.fly()
        two = timed(number, 2)
        beside.fly()
        if one.table != two.table:
            raise SystemExit("One worker and two have not made the same table.")
        metrics = {
            "trials_per_core_s": number / one.elapsed_s,
            "cpu_s_per_trial": one.trials_cpu_s / number,
            "flown_s_per_core_s": one.flown_s / one.trials_cpu_s,
            "scaling_1_to_2": one.elapsed_s / two.elapsed_s,
            "overhead_percent": 100.0 * (one.elapsed_s / one.trials_s - 1.0),
            "cluster_start_s": two.start_s,
        }
        for name, value in metrics.items():
            results.add(f"campaign.{name}", value)
        print(table(("figure", "value"), [(name, f"{value:.2f}") for name, value in metrics.items()]))
        found = {
            name: _by_trials(figures, one.flown_s / number) for name, figures in beside.figures().items()
        }
        for name, figures in found.items():
            results.add(f"campaign.peers.{name}", figures)
        ours = {**metrics, "trials_per_core_s": number / one.trials_cpu_s}  # by CPU time, as the peers
        print("\n" + peers_table(ours, found))


def peers_table(ours: Mapping[str, float], found: Mapping[str, Mapping[str, Any]]) -> str:
    """Return our trials and the peers as a table; below it a sentence for each that is left out."""
    if not found:
        return peers.HINT
    rows = [("ours: trials of a campaign, one worker", *(f"{ours[name]:.2f}" for name in BY_CORE))]
    rows += [
        (peers.flies(name), *(f"{figures[key]:.2f}" for key in BY_CORE))
        for name, figures in found.items()
        if "left_out" not in figures
    ]
    header = ("simulator", "simulated s by core-s", "flights as long as ours by core-s")
    return "\n\n".join((table(header, rows), *peers.sentences(found)))


def _by_trials(figures: Mapping[str, Any], trial_s: float) -> dict[str, Any]:
    """Return a peer's row from its figures. trial_s: mean simulated time of our trials."""
    if "left_out" in figures:
        return dict(figures)
    flown_s = figures["rtf_process"]
    return {"flown_s_per_core_s": flown_s, "trials_per_core_s": flown_s / trial_s}


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
        flown_s = pd.read_csv(path / TABLE)["flight_time_s"].sum()
    return Timed(start_s, elapsed_s, wall_s, cpu_s, flown_s, content)


def _run(campaign: Campaign, path: Path, workers: DaskWorkers) -> None:
    with CampaignFolder(path, campaign) as folder:
        folder.fly(workers)


if __name__ == "__main__":
    main()
