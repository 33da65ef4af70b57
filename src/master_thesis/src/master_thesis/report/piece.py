"""A piece of the report: what is computed, from which inputs, and what it leaves behind."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable

from master_thesis.results.run_folder import plain

FORMAT = 1
"""Of the pieces' files; another number makes every piece be computed again."""


@dataclass(frozen=True)
class Made:
    """What a piece has come to. numbers: what JSON holds. figures: SVG files by name, without ending."""

    numbers: dict
    figures: dict[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Piece:
    """Something to compute.

    name: of its folder. experiment: the section that it belongs to. title: for the progress line. make: a
    function of `given`, in a module, so that another process can call it. inputs: all that the outcome
    depends on besides, but the code: parameters, worlds. cost_s: about how long it takes. alone: it measures
    wall time, so that nothing else may run beside it.
    """

    name: str
    experiment: str
    title: str
    make: Callable[..., Made]
    given: dict
    inputs: dict = field(default_factory=dict)
    cost_s: float = 10.0
    lidar: str | None = None
    alone: bool = False

    @property
    def digest(self) -> str:
        """A number of the inputs alone: the same commit or another, a piece stays valid while they do."""
        return digest({"format": FORMAT, "given": self.given, "inputs": self.inputs})


def digest(value: Any) -> str:
    """Return a SHA-256 of anything that is made of dataclasses, mappings, sequences and numbers."""
    text = json.dumps(plain(_flat(value)), sort_keys=True, default=str)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def file_digest(path: Path) -> str:
    """Return a SHA-256 of a file's content."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def fingerprint(parameters: Any, **files: Path) -> dict:
    """Return inputs: parameters less the folders of paths, which are the machine's, and files' digests."""
    return {"parameters": _flat(parameters), **{name: file_digest(path) for name, path in files.items()}}


def _flat(value: Any) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: _flat(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): _flat(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_flat(item) for item in value]
    if isinstance(value, Path) or (isinstance(value, str) and value.startswith("/")):
        return Path(value).name
    return value
