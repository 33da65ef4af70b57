"""Which photographs count as seen: the whole ones that the search for findings did not leave out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from flight_basics.yaml_file import text_of
from inspection.photographs.listing import LeftOut, Listing, listed

FINDINGS = "findings.json"


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
