"""The command `campaign`: runs a campaign, or tunes CEPA by one."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from typing import Sequence

from flights.campaign.campaign import Campaign
from flights.errors import FlightsError, TrialsError
from flights.mapping.mapping_flight import PACKAGE
from flights.trials.workers import count, interrupted, open_workers

RESULTS = PACKAGE.parents[2] / "results" / "campaigns"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    tuning = arguments[:1] == ["tune"]
    given = _parser(tuning).parse_args(arguments[tuning:])
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        return _tune(given) if tuning else _run(given)
    except FlightsError as error:
        print(f"campaign: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return interrupted("\ncampaign: interrupted; call again to go on with what is missing.")


def _parser(tuning: bool) -> argparse.ArgumentParser:
    command = "campaign tune" if tuning else "campaign"
    what = (
        "Searches CEPA's parameters by a campaign's flights (its `tune:`), and writes cepa_tuned.yaml."
        if tuning
        else "Flies a campaign: trials.csv, summary.csv, pictures. `campaign tune` searches parameters."
    )
    parser = argparse.ArgumentParser(prog=command, description=what)
    parser.add_argument("file", type=Path, help="YAML file, or the name of a shipped campaign")
    parser.add_argument(
        "--workers", type=count, metavar="N", help="number of processes (default: one for each core)"
    )
    parser.add_argument("--scheduler", metavar="WHERE", help="Dask scheduler: tcp://host:port, or its file")
    parser.add_argument(
        "--out", type=Path, metavar="FOLDER", help=f"folder for the results (default: {RESULTS}/NAME)"
    )
    parser.add_argument("--seeds", type=count, metavar="N", help="number of seeds, in place of the file's")
    parser.add_argument(
        "--smallest", action="store_true", help="fly what the file says under `smallest:` (takes seconds)"
    )
    return parser


def _read(given: argparse.Namespace, name: str = "") -> tuple[Campaign, Path]:
    from flights.campaign.reading import read_campaign

    campaign = read_campaign(given.file, given.smallest, given.seeds)
    folder = RESULTS / (campaign.name + name + ("_smallest" if given.smallest else ""))
    return campaign, given.out or folder


def _run(given: argparse.Namespace) -> int:
    campaign, path = _read(given)
    # These take seconds to import. An error in the file comes before
    from flights.campaign.folder import CampaignFolder
    from flights.campaign.summary import write_summary

    with CampaignFolder(path, campaign) as folder:
        with open_workers(given.workers, given.scheduler) as workers:
            flown = folder.fly(workers)
        print(write_summary(campaign, folder, flown))
    print(f"\n{path}")
    if flown.failed:
        raise TrialsError(
            f"{len(flown.failed)} of {len(campaign)} trials failed, see the column error of trials.csv; "
            "call again to try them once more."
        )
    return 0


def _tune(given: argparse.Namespace) -> int:
    campaign, path = _read(given, "_tuning")
    from flights.campaign.tuning import tune

    with open_workers(given.workers, given.scheduler) as workers:
        print(tune(campaign, path, workers))
    return 0
