"""Halves of a set by a seed: one to tune on, one to tell. Pictures that are alike stay in one half."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping, NamedTuple, Sequence

import numpy as np
from PIL import Image

SIDE_PX = 12
"""Of the grey copies that are compared."""
ALIKE = 0.97
"""Correlation of two copies that are of the same picture, or of two shots of one thing."""


class Halves(NamedTuple):
    """Names of the pictures of each half."""

    first: frozenset[str]
    second: frozenset[str]


def halves_of(answers: Mapping[Path, bool], seed: int) -> Halves:
    """Return the halves of a set; each has half of the pictures, or groups of alike ones, of each answer."""
    rng = np.random.default_rng(seed)
    halves: tuple[set[str], set[str]] = (set(), set())
    for answer in (True, False):
        groups = groups_alike(sorted(path for path, each in answers.items() if each is answer))
        for place, number in enumerate(rng.permutation(len(groups))):
            halves[place % 2].update(path.name for path in groups[number])
    return Halves(frozenset(halves[0]), frozenset(halves[1]))


def groups_alike(paths: Sequence[Path]) -> list[list[Path]]:
    """Return the pictures in groups: each holds a picture and the later ones that are like it."""
    copies = np.array([_copy(path) for path in paths]).reshape(len(paths), SIDE_PX**2)
    alike = copies @ copies.T / SIDE_PX**2 > ALIKE
    left, groups = list(range(len(paths))), []
    while left:
        first = left[0]
        members = [first, *(each for each in left[1:] if alike[first, each])]
        groups.append([paths[each] for each in members])
        left = [each for each in left if each not in members]
    return groups


def _copy(path: Path) -> np.ndarray:
    """Return a small grey copy of a picture, with the mean 0 and the standard deviation 1."""
    with Image.open(path) as image:
        grey = np.asarray(image.convert("L").resize((SIDE_PX, SIDE_PX)), float)
    copy: np.ndarray = (grey - grey.mean()) / max(float(grey.std()), 1.0)
    return copy
