"""Which photographs count as seen, and of which the search for findings still holds."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any, Mapping

from flight_basics.yaml_file import text_of
from inspection.photographs.listing import LeftOut, Listing, listed

FINDINGS = "findings.json"
END_BYTES = 65_536


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
            content: Any = json.loads(text_of(path.read_bytes()))
            return [LeftOut(str(each["photograph"]), str(each["why"])) for each in content["left_out"]]
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
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
