"""A campaign's folder: finished trials as CSV part files, joined into one table; what is missing.

A part appears under its name only when it is complete, so that a campaign may be ended at any moment.
"""

from __future__ import annotations

import dataclasses
import fcntl
import json
import os
from pathlib import Path
from typing import Any, Mapping, Sequence

from master_thesis.campaign.axes import axes_of
from master_thesis.campaign.campaign import Campaign
from master_thesis.campaign.mapping import MapFigures, Mapped
from master_thesis.campaign.table import KINDS, Table, of_rows, read_csv
from master_thesis.campaign.trial import Cost, FlightOutcome, LidarFigures
from master_thesis.errors import CampaignError
from master_thesis.results.run_folder import machine, versions
from master_thesis.results.sources import commit

TABLE, COSTS, DESCRIPTION = "trials.csv", "costs.csv", "campaign.json"
_COST = "cost."
_COST_COLUMNS = {field.name: field.type for field in dataclasses.fields(Cost)}


def columns_of(campaign: Campaign) -> dict[str, str]:
    """Return the columns of a campaign's table and their kinds: settings, lidar, outcome, error."""
    known, settings = axes_of(campaign.kind), {}
    for combination in campaign.combinations:
        settings.update({name: known[name].kind.__name__ for name in combination})
    outcomes = (FlightOutcome,) if campaign.kind == "flight" else (Mapped, MapFigures)
    figures = {
        field.name: field.type
        for outcome in (LidarFigures, *outcomes)
        for field in dataclasses.fields(outcome)
        if field.type in KINDS
    }
    return {"index": "int", "replicate": "int", **settings, **figures, "error": "str"}


class CampaignFolder:
    """The folder of one campaign, locked while it is open; use it as a context manager."""

    def __init__(self, path: Path, campaign: Campaign) -> None:
        """Take up a folder, or begin it.

        Raises:
            CampaignError: it is another campaign's, it is in use by another process, or cannot be written.
        """
        self.path = Path(path).expanduser()
        self._campaign = campaign
        self._columns = columns_of(campaign)
        self._parts = self.path / "parts"
        try:
            self._parts.mkdir(parents=True, exist_ok=True)
            self._lock = open(self.path / ".lock", "w", encoding="utf-8")  # noqa: SIM115 - held until close
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._lock.close()
            raise CampaignError(f"Another campaign is at work in {self.path}; wait for its end.") from None
        except OSError as error:
            raise CampaignError(f"The folder {self.path} cannot be used: {error.strerror}.") from None
        try:
            self.warning = self._describe()
            self._rows, self._costs = self._read()
        except BaseException:
            self._lock.close()
            raise

    def _describe(self) -> str | None:
        """Write down whose folder this is; return a warning when other code began it."""
        path, here = self.path / DESCRIPTION, commit(Path(__file__).parent)
        described = {"digest": self._campaign.digest, "commit": here}
        if path.exists():
            try:
                before = json.loads(path.read_text(encoding="utf-8"))
                digest, of_commit = before["digest"], before["commit"]
            except (OSError, ValueError, KeyError, TypeError):
                raise CampaignError(f"{path} is damaged; choose another folder with --out.") from None
            if digest != self._campaign.digest:
                raise CampaignError(
                    f"{self.path} holds trials of another campaign, or of this file before it was changed; "
                    "choose another folder with --out, or move that one away."
                )
            if of_commit == here:
                return None
            return f"The trials in {self.path} so far were flown by another version of the code, {of_commit}."
        described.update(name=self._campaign.name, kind=self._campaign.kind, seed=self._campaign.seed)
        described.update(axes=dict(self._campaign.axes), machine=machine(), versions=versions())
        _write(path, (json.dumps(described, indent=2) + "\n").encode())
        return None

    def _read(self) -> tuple[dict[int, dict], dict[int, dict]]:
        """Return what was finished before, rows and costs by index."""
        rows = {row["index"]: row for row in _read(self.path / TABLE, self._columns)}
        costs = {row["index"]: row for row in _read(self.path / COSTS, _COST_COLUMNS)}
        for path in sorted(self._parts.glob("*.csv")):
            for row in _read(path, self._part_columns):
                cost = {name: row.pop(_COST + name) for name in _COST_COLUMNS if name != "index"}
                rows[row["index"]] = row
                costs[row["index"]] = {"index": row["index"], **cost}
        return rows, costs

    @property
    def _part_columns(self) -> dict[str, str]:
        """Those of the table, and what each trial cost."""
        costs = {_COST + name: kind for name, kind in _COST_COLUMNS.items() if name != "index"}
        return {**self._columns, **costs}

    @property
    def missing(self) -> list[int]:
        """Indices of the trials that are not on disk."""
        return [index for index in range(len(self._campaign)) if index not in self._rows]

    def add(self, finished: Sequence[tuple[Mapping[str, Any], Cost]]) -> None:
        """Put finished trials (rows and costs) on disk as one part; raises CampaignError."""
        if not finished:
            return
        rows = []
        for row, cost in finished:
            self._rows[cost.index] = dict(row)
            self._costs[cost.index] = dataclasses.asdict(cost)
            rows.append({**row, _COST + "wall_s": cost.wall_s, _COST + "cpu_s": cost.cpu_s})
        part = of_rows(rows, self._part_columns)
        _write(self._parts / f"{finished[0][1].index:08d}.csv", part.to_csv())

    def join(self) -> Table:
        """Join all that is on disk into one table in the order of the trials, and write it.

        trials.csv holds nothing that differs from run to run; what the trials cost stands in costs.csv.
        """
        of_campaign = range(len(self._campaign))
        everything = of_rows([self._rows[index] for index in sorted(self._rows)], self._columns)
        _write(self.path / TABLE, everything.to_csv())
        _write(self.path / COSTS, of_rows(self.costs(), _COST_COLUMNS).to_csv())
        for part in self._parts.glob("*.csv"):
            part.unlink()
        return of_rows([row for row in everything.rows if row["index"] in of_campaign], self._columns)

    def write(self, name: str, content: bytes) -> None:
        """Write another file into the folder, whole or not at all."""
        _write(self.path / name, content)

    def costs(self) -> list[dict]:
        """Return what the trials took, in their order."""
        return [self._costs[index] for index in sorted(self._costs)]

    def close(self) -> None:
        """Let others in."""
        self._lock.close()

    def __enter__(self) -> CampaignFolder:
        return self

    def __exit__(self, *exception) -> None:
        self.close()


def _read(path: Path, columns: Mapping[str, str]) -> Sequence[dict]:
    """Return the rows of a file, none when it is not there; raises CampaignError."""
    if not path.exists():
        return ()
    try:
        return read_csv(path.read_bytes(), columns).rows
    except (OSError, ValueError) as error:
        raise CampaignError(f"{path} is damaged ({error}); move it away.") from None


def _write(path: Path, content: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with open(temporary, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise CampaignError(f"Cannot write {path}: {error.strerror}; free some space.") from None
    finally:
        temporary.unlink(missing_ok=True)
