"""Keep-out boxes and a ceiling, and the YAML file that holds them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterable

from input_schemas import MaybeInfinite, read_made, structured

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


@dataclass(frozen=True)
class BoxEntry:
    """A box in a file of limits; see `KeepOutBox`."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    name: str = ""

    def box(self, name: str) -> KeepOutBox:
        """Return the box; it has this name unless the file gives one."""
        return KeepOutBox(self.low, self.high, self.name or name)


@dataclass(frozen=True)
class LimitsFile:
    """The file of limits. ceiling: greatest height, m. keep_in: all around it is kept out."""

    ceiling: MaybeInfinite = field(default=MaybeInfinite(math.inf))
    keep_out: tuple[BoxEntry, ...] = ()
    keep_in: BoxEntry | None = None


def read_limits(path: str | Path) -> Limits:
    """Return the limits in a YAML file: see `LimitsFile` for its form.

    Raises:
        LimitsError: it cannot be read or makes no sense. The sentence names the file.
    """
    return read_made(path, "The limits", parse_limits, LimitsError)


def parse_limits(content: object) -> Limits:
    """Return the limits from the content of a YAML file.

    Raises:
        LimitsError: one sentence that names the box and the fault.
    """
    told = structured(content, LimitsFile, LimitsError)
    boxes = tuple(each.box(str(number)) for number, each in enumerate(told.keep_out, start=1))
    if told.keep_in is not None:
        boxes += _around(told.keep_in.box("keep_in"))
    return Limits(boxes, told.ceiling)


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
