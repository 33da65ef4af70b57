"""Runs a campaign to its end, or until it is interrupted: what is finished is on disk at any time."""

from __future__ import annotations

import sys
from dataclasses import dataclass

from tqdm import tqdm

from master_thesis.campaign.campaign import Campaign
from master_thesis.campaign.store import CampaignFolder
from master_thesis.campaign.table import Table
from master_thesis.campaign.trial import run_trial
from master_thesis.campaign.workers import Workers


@dataclass(frozen=True)
class Finished:
    """What a run of a campaign left. missing: trials that no worker survived; a second call tries them."""

    table: Table
    missing: int


def run_campaign(
    campaign: Campaign, folder: CampaignFolder, workers: Workers, quiet: bool = False
) -> Finished:
    """Run the trials that the folder does not hold yet, and join the table.

    Also when it is interrupted (KeyboardInterrupt, which goes on to the caller) the table holds all that is
    finished.

    Raises:
        CampaignError: the disk is full, or the scheduler is gone.
    """
    missing = folder.missing
    trials = [campaign.trial(index) for index in missing]
    done, total = len(campaign) - len(missing), len(campaign)
    bar = tqdm(desc=campaign.name, total=total, initial=done, unit=" trials", disable=quiet, file=sys.stderr)
    try:
        with bar:
            for batch in workers.batches(run_trial, trials) if trials else ():
                finished = [result for _, result in batch if not isinstance(result, Exception)]
                folder.add(finished)
                bar.update(len(finished))
    except BaseException:
        workers.kill()
        folder.join()
        raise
    return Finished(folder.join(), len(folder.missing))
