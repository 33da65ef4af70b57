"""Which photographs count as seen, and of which the search for findings still holds."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Mapping

from flight_basics.errors import ReportError
from input_schemas import read_file
from inspection.photographs.listing import LeftOut, Listing, listed

FINDINGS = "findings.json"
END_BYTES = 65_536


@dataclass(frozen=True)
class LeftOutEntry:
    """A photograph that a file tells as left out, with the reason."""

    photograph: str
    why: str

    @property
    def left_out(self) -> LeftOut:
        """The photograph that does not count."""
        return LeftOut(self.photograph, self.why)


@dataclass(frozen=True)
class SearchedFile:
    """What of findings.json tells which photographs count."""

    left_out: tuple[LeftOutEntry, ...] = ()


def countable(folder: Path) -> Listing:
    """Return the photographs of a folder that count, and the others with the reason.

    What findings.json, in the folder or the one above it, tells as left out does not count: nobody has looked
    for rust and cracks in it.
    """
    listing = listed(folder)
    refused = {each.name: each.why for each in left_out_in(folder)}
    whole = tuple(each for each in listing.whole if each[0].name not in refused)
    more = tuple(LeftOut(path.name, refused[path.name]) for path, _ in listing.whole if path.name in refused)
    return Listing(whole, (*listing.left_out, *more))


def left_out_in(folder: Path) -> list[LeftOut]:
    """Return what the search for findings left out of a folder; nothing if it was not searched."""
    for path in (folder / FINDINGS, folder.parent / FINDINGS):
        try:
            told = read_file(path, "The findings", SearchedFile, ReportError, other_keys=True)
            return [each.left_out for each in told.left_out]
        except ReportError:
            continue
    return []


def digest_of(path: Path) -> str:
    """Return what a search of a photograph rests on: its pose, its calibration, its size and end in bytes."""
    digest = hashlib.sha256()
    for each in (path.with_suffix(".json"), path.parent / "calibration.yaml"):
        digest.update(each.read_bytes())
    with path.open("rb") as stream:
        size = stream.seek(0, os.SEEK_END)
        stream.seek(-min(END_BYTES, size), os.SEEK_END)
        digest.update(str(size).encode() + stream.read())
    return digest.hexdigest()


def changed_since(folder: Path, rests_on: Mapping[str, str]) -> list[str]:
    """Return the photographs of a folder that are not as they were. rests_on: digests by name."""
    changed = []
    for name, digest in rests_on.items():
        try:
            if digest_of(folder / name) != digest:
                changed.append(name)
        except OSError:
            changed.append(name)
    return changed
