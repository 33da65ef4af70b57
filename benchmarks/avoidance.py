"""Flights through places that tuning never saw: does an algorithm touch anything, arrive, or get stuck?

Each row is a campaign file of flights (`config/campaigns/avoidance_ROW.yaml`). --rows flies some of
them. --resume goes on from an interrupted run.

- mixed: `config/campaigns/avoidance.yaml`, the improved and the original algorithm in random forests. The
  improved one must never collide at 2 m/s. Keys: cepa.campaign.{original, improved, improved_velocity_aware,
  improved_levelling}.{all, 1_m_s, ...}, and cepa.campaign.improved_at_2_m_s, with collisions per km.
- ros: the row spaced at 4 m/s through all ROS nodes in real time.
- spaced, thick, dead_ends, ...: keys avoidance.PLACE.SPEED.ALGORITHM.{flights, contacts, reached, time_ratio,
  clearance_m, computation_ms}. The table of goals says what `dynamic` is to reach and whether it does.

The campaigns' own files are in results/avoidance (mixed) and results/avoidance/ROW. The picture
results/avoidance/outcomes.png shows what became of the flights.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Sequence

from benchmarks.avoidance_rows import judging, mixed_forests, picture, real_time
from benchmarks.avoidance_rows.judging import Verdict
from benchmarks.avoidance_rows.rows import REAL_TIME, ROWS, Row
from benchmarks.shared.results import Results
from benchmarks.shared.trials import AGAIN, end_interrupted, trial_options
from flights.campaign.campaign import Campaign
from flights.campaign.folder import CampaignFolder, Flown
from flights.campaign.reading import read_campaign
from flights.campaign.summary import write_summary
from flights.trials.workers import open_workers

BRIEF_SEEDS, BRIEF_ROW_SEEDS = 4, 1
"""Of the row mixed, and of any other."""
MIXED = "mixed"
BY_NAME = {row.name: row for row in ROWS}


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    names = [MIXED, *BY_NAME]
    parser = trial_options(__doc__ or "")
    parser.add_argument("--rows", nargs="+", choices=names, default=names, help="what to fly (default: all)")
    parser.add_argument("--seeds", type=int, metavar="N", help="number of places, instead of the files'")
    parser.add_argument("--smallest", action="store_true", help="seconds of flight, as the files have it")
    given = parser.parse_args(arguments)
    verdicts: list[Verdict] = []
    found: dict[tuple[str, float, str], dict] = {}
    for name in given.rows:
        if name == MIXED:
            fly_mixed(given)
        else:
            of_row, its_verdicts = fly_row(BY_NAME[name], given)
            found.update(of_row)
            verdicts += its_verdicts
    if verdicts:
        print(f"\n{judging.verdicts_table(verdicts)}")
    if found:
        path = given.results / "avoidance" / "outcomes.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(picture.png(found))
        print(f"\n{path}")


def fly_mixed(given: argparse.Namespace) -> None:
    """Fly the random forests of the thesis's algorithms."""
    with Results("avoidance", given.results, vars(given)) as results:
        campaign, flown = fly("avoidance", given.results / "avoidance", given, BRIEF_SEEDS)
        print(f"\n{mixed_forests.compared(campaign, flown.trials, results)}")


def fly_row(row: Row, given: argparse.Namespace) -> tuple[dict[tuple[str, float, str], dict], list[Verdict]]:
    """Fly a row; return its metrics by place, speed and algorithm, and how its goals were met."""
    with Results(row.campaign, given.results, vars(given)) as results:
        if row is REAL_TIME:
            trials, computation_ms = real_time.fly_all(row, given)
        else:
            _, flown = fly(row.campaign, given.results / "avoidance" / row.name, given, BRIEF_ROW_SEEDS)
            trials, computation_ms = flown.trials, flown.computation_ms
        sets = judging.sets(row, trials)
        found = {name: judging.metrics(flights, computation_ms) for name, flights in sets.items()}
        for name, values in found.items():
            results.add(judging.key(*name), values)
        print(f"\n{row.what}\n\n{judging.as_table(found)}")
        return found, judging.verdicts(row, trials, computation_ms)


def fly(name: str, path: Path, given: argparse.Namespace, brief_seeds: int) -> tuple[Campaign, Flown]:
    """Fly a campaign in a folder; if trials fail, or after Ctrl-C, it ends the process with a sentence."""
    seeds = given.seeds or (brief_seeds if given.brief else None)
    campaign = read_campaign(Path(name), given.smallest, seeds)
    try:
        with CampaignFolder(path, campaign, not given.resume) as folder:
            with open_workers(given.workers) as workers:
                flown = folder.fly(workers)
            print(f"{write_summary(campaign, folder, flown)}\n\n{path}")
    except KeyboardInterrupt:
        end_interrupted()
    if flown.failed:
        raise SystemExit(f"{len(flown.failed)} of {len(campaign)} trials failed; {AGAIN}")
    return campaign, flown


if __name__ == "__main__":
    main()
