"""The marks of this project's own finder on a picture."""

from __future__ import annotations

import numpy as np

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate, candidates_in
from inspection.findings.picture.paint import RED


def marks_in(picture: np.ndarray, kind: str) -> list[Candidate]:
    """Return the marks of a kind, as `findings` without poses makes them of a picture, uint8 (h, w, 3)."""
    kinds = {kind, RED} if kind == "rust" else {kind}
    return [each for each in candidates_in(picture, FindingParameters().for_pictures()) if each.kind in kinds]


def pixels_of(marks: list[Candidate], shape: tuple[int, ...]) -> np.ndarray:
    """Return the marked places, bool (height, width)."""
    marked = np.zeros(shape, bool)
    for each in marks:
        x, y = np.rint(each.pixels).astype(int).T
        marked[np.clip(y, 0, shape[0] - 1), np.clip(x, 0, shape[1] - 1)] = True
    return marked
