"""How well marked pixels, or answers, agree with the truth."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np
from scipy.ndimage import distance_transform_edt


class Score(NamedTuple):
    """right of found: marks near the truth. shown of true: truth near a mark. Pixels, or pictures."""

    right: int
    found: int
    shown: int
    true: int

    @property
    def precision(self) -> float:
        """Share of what is found that is right; 1 if nothing is found."""
        return self.right / self.found if self.found else 1.0

    @property
    def recall(self) -> float:
        """Share of the truth that is found; 1 if there is none."""
        return self.shown / self.true if self.true else 1.0

    @property
    def f(self) -> float:
        """Harmonic mean of both."""
        both = self.precision + self.recall
        return 2.0 * self.precision * self.recall / both if both else 0.0


def of_pixels(found: np.ndarray, true: np.ndarray, tolerance_px: float) -> Score:
    """Return the score of a picture's marks. found, true: bool (height, width)."""
    right = np.count_nonzero(found & _near(true, tolerance_px))
    shown = np.count_nonzero(true & _near(found, tolerance_px))
    return Score(right, np.count_nonzero(found), shown, np.count_nonzero(true))


def of_answer(found: bool, true: bool) -> Score:
    """Return the score of a picture that is answered by yes or no."""
    return Score(int(found and true), int(found), int(found and true), int(true))


def total(scores: Sequence[Score]) -> Score:
    """Return the score of all pictures together."""
    return Score(*(sum(column) for column in zip(*scores)))


def _near(mask: np.ndarray, tolerance_px: float) -> np.ndarray:
    if not mask.any():
        return np.zeros_like(mask)
    near: np.ndarray = distance_transform_edt(~mask) <= tolerance_px
    return near
