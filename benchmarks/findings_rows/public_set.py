"""Public photographs with their truth: masks of pixels, or a table of yes and no."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterator

import numpy as np
from PIL import Image
from scipy.io import loadmat

from benchmarks.findings_rows.burnt import Burnt
from inspection.findings.picture.flaws import check_shows
from inspection.photographs.listing import LeftOut, pictures_in, read_picture
from inspection.photographs.record import PhotographError

YES, NO = ("1", "yes", "true", "y"), ("0", "no", "false", "n")
GREY, GREY_16_BITS = ("L", "LA"), ("I;16", "I;16B", "I;16L", "I")
"""Pillow's names of pictures without colours."""
FEW_VALUES = 16
"""A mask with more values was compressed with losses, and is cut at half its range."""


class SetError(Exception):
    """A set cannot be read; the message is one sentence."""


@dataclass
class PublicSet:
    """Photographs with masks or answers.

    label: value of the pixels of a mask that count; None: all but the most frequent value. left_out: name of
    each other picture, with the reason. burnt: flaws that each picture gets.
    flaws: of each picture that counts, words of `apart`.
    """

    masks: dict[Path, Path] = field(default_factory=dict)
    answers: dict[Path, bool] = field(default_factory=dict)
    label: int | None = None
    left_out: dict[str, str] = field(default_factory=dict)
    burnt: Burnt = field(default_factory=Burnt)
    flaws: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def pictures(self) -> Iterator[tuple[Path, np.ndarray]]:
        """Yield each picture, uint8 (height, width, 3), that shows something."""
        for number, path in enumerate((*self.masks, *self.answers)):
            try:
                picture = self.burnt.into(_read(path), number)
                check_shows(picture, str(path))
            except PhotographError as error:
                self.left_out[path.name] = LeftOut.of(path, error).why
                continue
            yield path, picture

    def mask(self, path: Path, shape: tuple[int, ...]) -> np.ndarray | None:
        """Return the pixels of a picture that are marked, bool (height, width); None: left out, as told."""
        try:
            mask = read_mask(self.masks[path], self.label)
            if mask.shape != shape:
                raise SetError(f"Its mask has {mask.shape[1]} x {mask.shape[0]} px, and not its size.")
        except (SetError, OSError, ValueError, KeyError) as error:
            self.left_out[path.name] = str(error)
            return None
        return mask


def with_masks(photographs: Path, masks: Path, label: int | None = None) -> PublicSet:
    """Return the pictures of a folder that have a mask of the same name in another, whatever its suffix.

    Raises:
        SetError: there is no pair.
    """
    of_stem = {each.stem: each for each in sorted(masks.rglob("*")) if each.is_file()}
    found = PublicSet(label=label)
    for path in _pictures(photographs):
        if path.stem in of_stem:
            found.masks[path] = of_stem[path.stem]
        else:
            found.left_out[path.name] = f"{masks} has no mask of that name."
    if not found.masks:
        raise SetError(f"No picture in {photographs} has a mask of its name in {masks}.")
    return found


def with_answers(photographs: Path, table: Path, kind: str) -> PublicSet:
    """Return the pictures that a table answers for: columns `name` and the kind, yes or no.

    Raises:
        SetError: the table has other columns or values, or answers for none of the pictures.
    """
    with open(table, newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    if not rows or "name" not in rows[0] or kind not in rows[0]:
        raise SetError(f"{table}: its first line must name the columns name,{kind}.")
    by_name = {path.name: path for path in _pictures(photographs)}
    found = PublicSet()
    for number, row in enumerate(rows, 2):
        answer = (row[kind] or "").strip().lower()
        if answer not in YES + NO:
            raise SetError(f"{table}, line {number}: {kind} must be yes or no, not {row[kind]!r}.")
        if row["name"] in by_name:
            found.answers[by_name[row["name"]]] = answer in YES
        else:
            found.left_out[row["name"]] = f"{photographs} has no such picture."
    if not found.answers:
        raise SetError(f"{table} answers for no picture of {photographs}.")
    return found


def read_mask(path: Path, label: int | None = None) -> np.ndarray:
    """Return a mask, bool (height, width): the pixels of a label, or what has not the most frequent value.

    So it may be black on white, in colours, a palette, of 16 bits, or a label image of Matlab.

    Raises:
        SetError: it cannot be read.
    """
    if path.suffix == ".mat":
        labels = _label_image(loadmat(path))
        if labels is None:
            raise SetError(f"{path.name} holds no image of labels.")
        return _marked(labels, label)
    try:
        with Image.open(path) as image:
            values = np.asarray(image)
    except (OSError, SyntaxError) as error:
        raise SetError(f"Its mask {path.name} cannot be read: {error}.") from None
    if label is None:
        values = _few_values(values)
    return _marked(values, label)


def _marked(values: np.ndarray, label: int | None) -> np.ndarray:
    marked: np.ndarray = values != _most_frequent(values) if label is None else values == label
    if marked.ndim != 2:
        raise SetError("Its mask has colours, so no label chooses pixels of it.")
    return marked


def _few_values(values: np.ndarray) -> np.ndarray:
    """Return a mask's values (height, width), few of them: a number for each colour, or two halves."""
    if values.ndim == 3:
        colours = values[..., :3].astype(np.int64)
        values = (colours[..., 0] << 16) + (colours[..., 1] << 8) + colours[..., -1]
        if len(np.unique(values)) > FEW_VALUES:
            values = colours.max(axis=2)
    if len(np.unique(values)) > FEW_VALUES:
        values = values > 0.5 * (float(values.min()) + float(values.max()))
    return values


def _label_image(content: object) -> np.ndarray | None:
    """Return the first image of whole numbers in what Matlab has written."""
    if isinstance(content, dict):
        parts = [value for name, value in content.items() if not name.startswith("__")]
    elif isinstance(content, np.ndarray) and content.dtype.names:
        parts = [content[name] for name in content.dtype.names]
    elif isinstance(content, np.ndarray) and content.dtype == object:
        parts = list(content.ravel())
    elif isinstance(content, np.ndarray):
        is_image = content.ndim == 2 and min(content.shape) > 1 and content.dtype.kind in "uib"
        return content if is_image else None
    else:
        return None
    return next((image for image in map(_label_image, parts) if image is not None), None)


def _most_frequent(values: np.ndarray) -> float:
    found, counts = np.unique(values, return_counts=True)
    return found[counts.argmax()]


def _read(path: Path) -> np.ndarray:
    """Return a picture, uint8 (height, width, 3). Many sets are grey, and `findings` reads colours only."""
    try:
        with Image.open(path) as image:
            if image.mode in GREY:
                return np.array(image.convert("RGB"))
            if image.mode in GREY_16_BITS:
                grey = np.asarray(image, np.int64) >> 8
                return np.repeat(grey.clip(0, 255).astype(np.uint8)[..., None], 3, axis=2)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        pass  # read_picture tells what is wrong
    return read_picture(path)


def _pictures(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise SetError(f"{folder} is no folder.")
    return [
        path
        for each in sorted({folder, *(p for p in folder.rglob("*") if p.is_dir())})
        for path in pictures_in(each)
    ]
