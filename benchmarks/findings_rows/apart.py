"""Pictures with a flaw (blurred, written upon, converted), which count with the others and apart."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator, Mapping

import numpy as np

from inspection.findings.picture.flaws import BLURRED, CONVERTED, WRITTEN, flaws_in

WORDS = {BLURRED: "blurred", WRITTEN: "written", CONVERTED: "converted"}


def flaws_of(picture: np.ndarray, path: Path) -> tuple[str, ...]:
    """Return the flaws of a picture, uint8 (height, width, 3), each in a word. path: of its file."""
    return tuple(WORDS[why] for why in flaws_in(picture, path))


def told_of(flaws: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    """Yield a line for each flaw: its pictures, of those that are given by name."""
    for why, word in WORDS.items():
        names = [name for name, each in flaws.items() if word in each]
        if names:
            yield f"{word}: {len(names)} pictures: {', '.join(names)}. {why}"
