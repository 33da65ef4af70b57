"""Text files with rows of numbers: the form of trajectories, relations and walls."""

from __future__ import annotations

import gzip
import math
import zlib
from pathlib import Path
from typing import Mapping, Sequence

import numpy as np

from gridslam.errors import EvaluationError, reason_of
from input_schemas import text_of


def read_rows(
    path: Path, form: str, columns: Sequence[int], other_forms: Mapping[int, str] | None = None
) -> np.ndarray:
    """Read the rows of numbers in a file, plain or .gz: (n, k) float64, finite, n >= 1.

    Blanks or commas separate numbers. # begins a comment. A table with commas may have a heading.

    Args:
        path: the file.
        form: description of a line's content, for errors.
        columns: allowed numbers per line; all lines have the same.
        other_forms: what the file may be instead, and what to do then, by numbers per line, for errors.

    Raises:
        EvaluationError: the file cannot be read, or holds something else; the sentence names the line.
    """
    rows: list[list[float]] = []
    for number, line in enumerate(_text_of(path).splitlines(), start=1):
        line = line.partition("#")[0]
        words = line.replace(",", " ").split()
        if not words or (not rows and "," in line and not any(map(_is_number, words))):
            continue
        allowed = (len(rows[0]),) if rows else columns
        wrong = next((word for word in words if not _is_number(word)), None)
        if wrong is not None or len(words) not in allowed:
            fault = f"has {len(words)} numbers" if wrong is None else f"{wrong[:20]!r} is not a finite number"
            hint = (other_forms or {}).get(len(words), "") if wrong is None and not rows else ""
            raise EvaluationError(f"{path}, line {number}: {fault}; each line must hold {form}.{hint}")
        rows.append([float(word) for word in words])
    if not rows:
        raise EvaluationError(f"{path}: is empty; each line must hold {form}.")
    return np.array(rows)


def _text_of(path: Path) -> str:
    try:
        with (gzip.open if str(path).endswith(".gz") else open)(path, "rb") as file:
            text = text_of(file.read())
    except (OSError, EOFError, zlib.error) as error:
        raise EvaluationError(f"{path}: cannot be read ({reason_of(error)}).") from None
    if "\0" in text:
        raise EvaluationError(f"{path}: cannot be read (it is not text).")
    return text


def _is_number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False
