"""Findings in photographs whose pose nobody knows: marks on the pictures alone, to be placed later."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from inspection.findings.kinds import RUST
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate, candidates_in
from inspection.findings.picture.flaws import check_shows, flaws_in
from inspection.findings.picture.paint import RED
from inspection.findings.remembered import read_marks
from inspection.photographs.listing import LeftOut, check_picture, pictures_in, read_picture

Box = tuple[int, int, int, int]


@dataclass(frozen=True)
class PictureMark:
    """What is marked in a photograph. box_px: left, top, right, bottom. size_px: of all its pixels."""

    kind: str
    box_px: Box
    size_px: int


@dataclass(frozen=True)
class MarkedPicture:
    """A photograph that was searched without a pose, and what was found: it has no place and no size."""

    photograph: str
    marks: tuple[PictureMark, ...] = ()


def without_pose(folder: Path) -> list[Path]:
    """Return the pictures of a folder that have no JSON beside them."""
    return [each for each in pictures_in(folder) if not each.with_suffix(".json").exists()]


class PictureSearch:
    """Marks rust and cracks in pictures. A picture that another detector has marked is not searched.

    Attributes:
        flawed: the pictures that were searched, but have a flaw, with a sentence each.
    """

    def __init__(self, parameters: FindingParameters) -> None:
        self._p = parameters.for_pictures()
        self._marked: list[MarkedPicture] = []
        self.flawed: list[LeftOut] = []

    def add(self, path: Path, name: str) -> None:
        """Search a picture; raises PhotographError: it shows nothing, or it or its marks are damaged."""
        found = read_marks(path)
        if found is not None:
            check_picture(path)
        else:
            picture = read_picture(path, turns=True)
            check_shows(picture, str(path))
            found = candidates_in(picture, self._p)
            self.flawed += [LeftOut(name, why) for why in flaws_in(picture, path)]
        self._marked.append(MarkedPicture(name, tuple(_mark(each) for each in found)))

    def marked(self) -> tuple[MarkedPicture, ...]:
        """Return what all pictures show. Red that fills most of them is the coating; else it is rust."""
        red = [any(mark.kind == RED for mark in each.marks) for each in self._marked]
        is_coating = 2 * sum(red) > len(red)
        return tuple(
            MarkedPicture(each.photograph, tuple(_sure(each.marks, is_coating))) for each in self._marked
        )


def _sure(marks: Sequence[PictureMark], is_coating: bool) -> list[PictureMark]:
    if is_coating:
        return [each for each in marks if each.kind != RED]
    if any(each.kind == RED for each in marks):
        marks = [each for each in marks if each.kind != RUST.name]
    return [PictureMark(RUST.name, e.box_px, e.size_px) if e.kind == RED else e for e in marks]


def _mark(candidate: Candidate) -> PictureMark:
    low, high = np.floor(candidate.pixels.min(axis=0)), np.ceil(candidate.pixels.max(axis=0))
    box = (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
    return PictureMark(candidate.kind, box, int(candidate.size_px))
