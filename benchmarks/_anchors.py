"""Numbers to compare with that no benchmark measures, each with its source.

An anchor is a constant. The machine, its load and the day were others than those of the numbers beside it, so
that a ratio of the two is an order of magnitude, not a result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable

HEADING = "anchor, measured elsewhere"


@dataclass(frozen=True)
class Anchor:
    """What somebody else reached. text: name and figure. source: who measured it, and on what."""

    text: str
    source: str


def sources(anchors: Iterable[Anchor]) -> str:
    """Return the lines below a table that say where its anchors come from."""
    lines = dict.fromkeys(f"- {anchor.text}: {anchor.source}" for anchor in anchors)
    return "\n".join(("Anchors are constants; nothing of them was measured by this run:", *lines))
