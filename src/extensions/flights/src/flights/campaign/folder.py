"""A campaign's folder: its trials as they finish, and what is written about them in the end."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterable, Mapping, Sequence

import pandas as pd

from flights.campaign.axes import axes_of
from flights.campaign.campaign import Campaign
from flights.campaign.trial import COLUMNS, LidarData, run_case
from flights.errors import CampaignError
from flights.files import plain, replace_file
from flights.results.run_folder import machine, versions
from flights.trials.run import run_trials, version
from flights.trials.store import Store
from flights.trials.trial import Failed, Row, Trial, several_versions
from flights.trials.workers import Workers
from input_schemas import read_file

FINISHED, TABLE, COSTS, DESCRIPTION = "trials.jsonl", "trials.csv", "costs.csv", "campaign.json"


@dataclass(frozen=True)
class Digest:
    """What of a folder's description tells of which campaign it is."""

    digest: str


@dataclass(frozen=True)
class Flown:
    """What a run of a campaign left.

    trials: a row for each case that finished or failed. computation_ms: the sample of computation times of
    each flight, by the case's index. failed: those that raised; a second call tries them again. mixture: a
    sentence, if different versions of the code computed the rows.
    """

    trials: pd.DataFrame
    computation_ms: Mapping[int, Sequence[float]]
    failed: Sequence[Failed] = ()
    mixture: str | None = None


class CampaignFolder:
    """The folder of one campaign, locked while it is open; use it as a context manager."""

    def __init__(self, path: Path, campaign: Campaign, fresh: bool = False) -> None:
        """Take up a folder, or begin it. fresh: forget what is in it.

        Raises:
            CampaignError: the folder is another campaign's, or cannot be written.
            TrialsError: another process uses it, or its trials are damaged.
        """
        self.path = Path(path).expanduser()
        self._campaign = campaign
        self._cases = {str(case.index): case for case in campaign.cases}
        self._trials = [Trial(name, run_case, {"case": case}) for name, case in self._cases.items()]
        if not fresh:
            self._check()
        self._store = Store(self.path / FINISHED, fresh)
        try:
            self.write(DESCRIPTION, json.dumps(_described(campaign), indent=2) + "\n")
        except BaseException:
            self._store.close()
            raise

    def _check(self) -> None:
        """Raise CampaignError if the folder is another campaign's."""
        path = self.path / DESCRIPTION
        if not path.exists():
            return
        digest = read_file(path, "The campaign of this folder", Digest, CampaignError, other_keys=True).digest
        if digest != self._campaign.digest:
            raise CampaignError(
                f"{self.path} holds trials of another campaign, or of this file before it was changed; "
                "choose another folder with --out, or move that one away."
            )

    @property
    def missing(self) -> list[int]:
        """Indices of the cases that are not finished."""
        return [int(trial.name) for trial in self._trials if self._store.get(trial) is None]

    def fly(self, workers: Workers, quiet: bool = False) -> Flown:
        """Fly the cases that are missing, and write the tables.

        The tables are written after Ctrl-C (KeyboardInterrupt, which goes on to the caller), too.

        Raises:
            TrialsError: the disk is full, or the scheduler is gone.
        """
        failed: list[Failed] = []
        try:
            failed = run_trials(self._trials, self._store, workers, self._campaign.name, quiet)
        finally:
            finished = [row for row in map(self._store.get, self._trials) if row is not None]
            trials = self._write_tables(finished, failed)
        times = {int(row.name): row.result.get("computation_ms", ()) for row in finished}
        return Flown(trials, times, failed, several_versions(finished))

    def _write_tables(self, finished: Iterable[Row], failed: Iterable[Failed]) -> pd.DataFrame:
        """Write trials.csv, which does not depend on who flew, and costs.csv. Return the first."""
        found = {row.name: {**row.result, "commit": row.commit} for row in finished}
        found.update({one.trial.name: {"error": one.why, "commit": version()} for one in failed})
        rows = [
            {"index": case.index, "replicate": case.replicate, **case.settings, **found[name]}
            for name, case in self._cases.items()
            if name in found
        ]
        columns = columns_of(self._campaign)
        exact = pd.DataFrame(rows, columns=columns, dtype=object)  # which writes every bit of a number
        self.write(TABLE, exact.to_csv(index=False))
        costs = [(int(row.name), row.wall_s, row.cpu_s) for row in finished]
        self.write(COSTS, pd.DataFrame(costs, columns=["index", "wall_s", "cpu_s"]).to_csv(index=False))
        return pd.DataFrame(rows, columns=columns)

    def write(self, name: str, content: bytes | str) -> None:
        """Write another file into the folder, whole or not at all; raises CampaignError."""
        try:
            replace_file(self.path / name, content)
        except OSError as error:
            raise CampaignError(
                f"Cannot write {self.path / name}: {error.strerror}; free some space."
            ) from None

    def __enter__(self) -> CampaignFolder:
        return self

    def __exit__(self, *exception: object) -> None:
        self._store.close()


def _described(campaign: Campaign) -> Any:
    return plain(
        {
            "digest": campaign.digest,
            "name": campaign.name,
            "kind": campaign.kind,
            "seed": campaign.seed,
            "trials": [{**dict(block.axes), "times": block.times} for block in campaign.blocks],
            "machine": machine(),
            "versions": versions(),
        }
    )


def columns_of(campaign: Campaign) -> list[str]:
    """Return the columns of a campaign's table: settings, lidar, outcome, error, commit."""
    names = ["index", "replicate"]
    names += [name for name in axes_of(campaign.kind) if any(name in s for s in campaign.combinations)]
    found = (*(field.name for field in dataclasses.fields(LidarData)), *COLUMNS[campaign.kind])
    return [*names, *(name for name in found if name not in names), "error", "commit"]
