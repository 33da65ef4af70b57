"""Numbers to compare with that no benchmark measures, each with its source.

An anchor is a constant. It was measured on another machine, under another load. So a ratio to the numbers
beside it is an order of magnitude, not a result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable

HEADING = "anchor, measured elsewhere"


@dataclass(frozen=True)
class Anchor:
    """A number measured elsewhere. text: name and value. source: who measured it, and on which machine."""

    text: str
    source: str


def sources(anchors: Iterable[Anchor]) -> str:
    """Return the lines with the anchors' sources, for below a table."""
    lines = dict.fromkeys(f"- {anchor.text}: {anchor.source}" for anchor in anchors)
    return "\n".join(("Anchors are constants; nothing of them was measured by this run:", *lines))
