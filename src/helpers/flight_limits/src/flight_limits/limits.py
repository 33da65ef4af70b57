"""Keep-out boxes and a ceiling, and the YAML file that holds them."""

from __future__ import annotations

import codecs
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable, Mapping

FARTHEST_M = 1e6
"""m: A box ends here at the latest."""


class LimitsError(Exception):
    """Limits that cannot be read or make no sense. The sentence says what is wrong, and where."""


@dataclass(frozen=True)
class KeepOutBox:
    """A box that a UAV stays out of.

    Attributes:
        low_m, high_m: its corners (x, y, z) in the map's frame. name: for messages.

    Raises:
        LimitsError: a corner is not three finite numbers, or low is not below high.
    """

    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]
    name: str = ""

    def __post_init__(self) -> None:
        for corner in (self.low_m, self.high_m):
            are_numbers = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in corner)
            if len(corner) != 3 or not are_numbers or not all(abs(v) <= FARTHEST_M for v in corner):
                raise LimitsError(f"{self} has a corner {corner!r}; give three numbers: x, y, z.")
        for axis, low, high in zip("xyz", self.low_m, self.high_m):
            if not low < high:
                raise LimitsError(f"{self} has {axis} from {low:g} to {high:g} m; low must be below high.")

    def __str__(self) -> str:
        return f"The keep-out box {self.name}".rstrip()

    def holds(self, place_m: Iterable[float]) -> bool:
        """Return whether a place (x, y, z) is in the box."""
        return all(low <= v <= high for low, v, high in zip(self.low_m, place_m, self.high_m))


@dataclass(frozen=True)
class Limits:
    """Keep-out boxes, and the greatest height of the UAV's centre in the map's frame, m.

    Raises:
        LimitsError: the ceiling is not a number.
    """

    boxes: tuple[KeepOutBox, ...] = ()
    ceiling_m: float = math.inf

    def __post_init__(self) -> None:
        is_number = isinstance(self.ceiling_m, (int, float)) and not isinstance(self.ceiling_m, bool)
        if not is_number or math.isnan(self.ceiling_m):
            raise LimitsError(f"ceiling is {self.ceiling_m!r}; it must be a height in metres.")


def read_limits(path: str | Path) -> Limits:
    """Return the limits in a YAML file: see `parse_limits` for its form.

    Raises:
        LimitsError: it cannot be read or makes no sense. The sentence names the file.
    """
    import yaml  # only if a file is read

    try:
        content = yaml.safe_load(_text_of(Path(path).read_bytes()))
    except OSError as error:
        raise LimitsError(f"The limits {path} cannot be read: {error.strerror}.") from None
    except (yaml.YAMLError, ValueError, RecursionError):  # no text, endless digits, endless depth
        raise LimitsError(f"The limits {path} are not YAML.") from None
    try:
        return parse_limits(content)
    except LimitsError as error:
        raise LimitsError(f"{path}: {error}") from None


def _text_of(content: bytes) -> str:
    """Return a file's text: UTF-8, UTF-16 with its mark as PowerShell writes it, or of an older editor."""
    try:
        is_utf_16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        return content.decode("utf-16" if is_utf_16 else "utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # only names and remarks hold other than ASCII


def parse_limits(content: object) -> Limits:
    """Return the limits from the content of a YAML file.

    The content is a mapping with these keys, none of which is needed:
      - `ceiling`: greatest height, m.
      - `keep_out`: a list of boxes, each with `low` and `high` ([x, y, z], m) and, if you like, a `name`.
      - `keep_in`: a box with `low` and `high`. All around it is kept out.

    Raises:
        LimitsError: one sentence that names the box and the fault.
    """
    if not isinstance(content, Mapping):
        raise LimitsError("Limits are a mapping with the keys ceiling, keep_out and keep_in.")
    unknown = sorted(set(content) - {"ceiling", "keep_out", "keep_in"}, key=str)
    if unknown:
        raise LimitsError(f"Limits have a ceiling, keep_out and keep_in, but no '{unknown[0]}'.")
    listed = content.get("keep_out") or []
    if not isinstance(listed, list):
        raise LimitsError("keep_out is no list; give a list of boxes with low and high.")
    boxes = tuple(
        _box(f"The keep-out box {number}", str(number), given) for number, given in enumerate(listed, start=1)
    )
    if "keep_in" in content:
        boxes += _around(_box("The box keep_in", "keep_in", content["keep_in"]))
    return Limits(boxes, content.get("ceiling", math.inf))


def _box(words: str, name: str, given: object) -> KeepOutBox:
    if not isinstance(given, Mapping) or not {"low", "high"} <= set(given) <= {"low", "high", "name"}:
        raise LimitsError(f"{words} is {given!r}; give it low, high and perhaps a name.")
    if not all(isinstance(given[corner], (list, tuple)) for corner in ("low", "high")):
        raise LimitsError(f"{words} needs low and high as lists: [x, y, z].")
    return KeepOutBox(tuple(given["low"]), tuple(given["high"]), str(given.get("name", name)))


def _around(inner: KeepOutBox) -> tuple[KeepOutBox, ...]:
    """Return six boxes that hold all that is outside of one."""
    boxes = []
    for axis, name in enumerate("xyz"):
        for low_m, high_m, side in (
            (-FARTHEST_M, inner.low_m[axis], "below"),
            (inner.high_m[axis], FARTHEST_M, "above"),
        ):
            if low_m < high_m:
                low, high = [-FARTHEST_M] * 3, [FARTHEST_M] * 3
                low[axis], high[axis] = low_m, high_m
                outside = KeepOutBox(
                    (low[0], low[1], low[2]), (high[0], high[1], high[2]), f"{name} {side} keep_in"
                )
                boxes.append(outside)
    return tuple(boxes)
