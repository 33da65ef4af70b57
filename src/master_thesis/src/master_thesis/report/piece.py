"""A piece of the report: a trial that belongs to a section of the page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flights.trials.trial import Trial, file_digest

TRIALS = "trials.jsonl"
"""The file of all finished pieces, beside the page."""


@dataclass(frozen=True)
class Piece(Trial):
    """Something to compute. It returns numbers by name; under `pictures` SVG files by name.

    experiment: the section that it belongs to. lidar: that it flies, if it may be chosen by it.
    """

    experiment: str = ""
    lidar: str | None = None


def fingerprint(parameters: Any, **files: Path) -> dict:
    """Return inputs of a piece: its parameters, and the digest of each file."""
    return {"parameters": parameters, **{name: file_digest(path) for name, path in files.items()}}
