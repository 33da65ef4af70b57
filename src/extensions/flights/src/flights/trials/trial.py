"""A trial, which is something to compute, and its row: the result, its time and its code."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Callable, Iterable, Mapping

from flights.files import plain

FORMAT = 1
"""Version of the rows' format. After a change every trial is computed again."""


@dataclass(frozen=True)
class Trial:
    """Something to compute. Its outcome depends only on `given`, on `inputs` and on the code.

    name: unique among the trials that share a file. run: a function of a module, so that another process can
    call it with `given` as keyword arguments; `files.plain` must be able to convert its result. inputs:
    everything else that the outcome depends on: parameters, worlds. title: for the progress bar. cost_s:
    approximate duration. alone: nothing else may run at the same time, because the trial measures wall time.
    """

    name: str
    run: Callable[..., Any]
    given: Mapping[str, Any]
    inputs: Any = None
    title: str = ""
    cost_s: float = 1.0
    alone: bool = False

    @cached_property
    def digest(self) -> str:
        """A digest of everything that the trial depends on except the code."""
        return digest({"format": FORMAT, "given": self.given, "inputs": self.inputs})


@dataclass(frozen=True)
class Row:
    """A finished trial. commit: of the code, see `results.sources`. load: load average at its start."""

    name: str
    digest: str
    commit: str
    date: str
    wall_s: float
    cpu_s: float
    load: float
    result: Any


@dataclass(frozen=True)
class Failed:
    """A trial that raised, and a sentence with the reason."""

    trial: Trial
    why: str


def digest(value: Any) -> str:
    """Return a SHA-256 of dataclasses, mappings, sequences and numbers.

    Only the name of an absolute path counts, because folders differ between machines.
    """
    text = json.dumps(_without_folders(plain(value)), sort_keys=True)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def _without_folders(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_folders(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_without_folders(item) for item in value]
    return Path(value).name if isinstance(value, str) and value.startswith("/") else value


def file_digest(path: Path) -> str:
    """Return a SHA-256 of a file's content."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def several_versions(rows: Iterable[Row]) -> str | None:
    """Return a sentence if different versions of the code computed the rows, else None."""
    found: dict[str, int] = {}
    for row in rows:
        found[row.commit] = found.get(row.commit, 0) + 1
    if len(found) < 2:
        return None
    counts = ", ".join(f"{count} by {commit}" for commit, count in found.items())
    return f"Different versions of the code computed these {sum(found.values())} trials: {counts}."
