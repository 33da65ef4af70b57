"""Thickness readings from a table, each kept as it was measured."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple, Sequence

from flight_basics.errors import ReportError
from inspection.files.table import Row, TableError, number_of, read_table
from inspection.ship.ship import PORT, STARBOARD, Plate, Ship

HEADS = {
    "frame": ("fr", "frames", "frame_no", "frame_number", "fr_no"),
    "strake": ("strakes", "strake_no"),
    "side": ("sides", "side_p_s", "p_s"),
    "original_mm": ("original", "original_thickness", "original_thickness_mm", "as_built", "as_built_mm"),
    "forward_mm": ("forward", "fwd", "fwd_mm", "forward_reading", "forward_reading_mm"),
    "aft_mm": ("aft", "aft_reading", "aft_reading_mm"),
    "remark": ("remarks", "note", "notes"),
}  # fmt: skip
"""Columns, and other names of theirs. A head such as "Forward (mm)" or "forward [mm]" is forward_mm."""
SIDE_WORDS = {
    "p": PORT, "port": PORT, "ps": PORT, "bb": PORT, "s": STARBOARD, "starboard": STARBOARD,
    "stbd": STARBOARD, "stb": STARBOARD, "sb": STARBOARD,
}  # fmt: skip
FRAME = re.compile(r"(frames?|fr)?[.\s]*(no|nr)?[.\s]*#?\s*", re.IGNORECASE)
"""What may stand before the number of a frame: "Fr. 5", "Frame no. 5", "#5"."""
MOST_MM = 500.0


class Reading(NamedTuple):
    """One row of a table. original_mm, forward_mm, aft_mm: None: not measured. frame: that it names."""

    plate: Plate
    frame: str
    original_mm: float | None
    forward_mm: float | None
    aft_mm: float | None
    remark: str

    @property
    def least_mm(self) -> float | None:
        """The lower of the readings that there are."""
        return min((each for each in (self.forward_mm, self.aft_mm) if each is not None), default=None)


class Readings(NamedTuple):
    """rows: of a table, in its order. unused: heads of columns that were not read."""

    rows: list[Reading]
    unused: list[str]


def read_readings(path: Path, ship: Ship) -> Readings:
    """Return all readings of a table.

    Raises:
        ReportError: one sentence that names the row and the fault.
    """
    try:
        table = read_table(path, HEADS, ("frame", "strake", "side"), numbered="frame")
    except TableError as error:
        raise ReportError(f"The readings {error}") from None
    if not table.rows:
        raise ReportError(f"The readings {path} have heads, but no row.")
    plates = ship.plates()
    return Readings([_reading(row, plates) for row in table.rows], table.unused)


def _reading(row: Row, plates: Sequence[Plate]) -> Reading:
    values = {
        key: _thickness(f"{row.where}, {key}", row.values.get(key, ""))
        for key in ("original_mm", "forward_mm", "aft_mm")
    }
    if values["forward_mm"] is None and values["aft_mm"] is None:
        raise ReportError(f"{row.where}: there is neither a forward nor an aft reading.")
    return Reading(_plate(row, plates), row.values["frame"], remark=row.values.get("remark", ""), **values)


def _plate(row: Row, plates: Sequence[Plate]) -> Plate:
    frame, strake, side = (row.values.get(key, "") for key in ("frame", "strake", "side"))
    side_of = SIDE_WORDS.get(side.lower().rstrip("."))
    if side_of is None:
        raise ReportError(f'{row.where}: the side is "{side}"; give P or S.')
    try:
        number = number_of(FRAME.sub("", frame, count=1))
    except ValueError:
        number = math.nan
    if not number.is_integer():
        raise ReportError(f'{row.where}: the frame is "{frame}"; give a whole number.')
    own = [each for each in plates if (each.strake.lower(), each.side) == (strake.lower(), side_of)]
    exact = [each for each in own if each.strake == strake] or own
    for each in exact:
        if each.first <= number < each.last or (
            number == each.last and each.last == max(p.last for p in exact)
        ):
            return each
    raise ReportError(f'{row.where}: the ship has no plate at frame "{frame}", strake "{strake}", {side_of}.')


def _thickness(where: str, text: str) -> float | None:
    if not text or text in ("-", "\N{EN DASH}", "\N{EM DASH}"):
        return None
    try:
        value = number_of(text.lower().removesuffix("mm").rstrip())
    except ValueError:
        value = math.nan
    if not 0.0 < value < MOST_MM:
        raise ReportError(f'{where}: "{text}" is no thickness in mm.')
    return value
