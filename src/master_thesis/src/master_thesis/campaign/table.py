"""A campaign's table: rows of typed columns, and the CSV text that keeps every bit of them.

pandas reads the text (`pandas.read_csv`), and so does any spreadsheet. An empty cell means: no value.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Sequence

Row = Mapping[str, Any]
_WORDS = {"True": True, "False": False}
_READERS = {"bool": _WORDS.__getitem__, "int": int, "float": float, "str": str}
KINDS = tuple(_READERS)
"""Names of the types that a column may have."""


@dataclass(frozen=True)
class Table:
    """Rows, and the kind (of `KINDS`) of each column in order; a row may lack what a column would hold."""

    kinds: Mapping[str, str]
    rows: Sequence[Row]

    def to_csv(self) -> bytes:
        """Return the table as text: a header, a line for each row; floats as they are read back exactly."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.kinds)
        for row in self.rows:
            writer.writerow([_cell(row.get(name)) for name in self.kinds])
        return text.getvalue().encode("utf-8")

    def to_pandas(self):
        """Return a pandas.DataFrame; numbers without a value are NaN."""
        import pandas as pd

        columns = {}
        for name, kind in self.kinds.items():
            values = [row.get(name) for row in self.rows]
            numeric = kind == "float" or (kind == "int" and None in values)
            columns[name] = pd.Series(values, dtype=float if numeric else None)
        return pd.DataFrame(columns)


def read_csv(content: bytes, kinds: Mapping[str, str]) -> Table:
    """Read what `Table.to_csv` wrote.

    Raises:
        ValueError: a sentence that says which line is not of a table with these columns.
    """
    lines = csv.reader(io.StringIO(content.decode("utf-8"), newline=""))
    header = next(lines, [])
    if header != list(kinds):
        raise ValueError("its header is not this campaign's")
    return Table(kinds, [_row(number, line, kinds) for number, line in enumerate(lines, start=2)])


def _row(number: int, line: Sequence[str], kinds: Mapping[str, str]) -> dict:
    if len(line) != len(kinds):
        raise ValueError(f"line {number} has {len(line)} cells in place of {len(kinds)}")
    try:
        return {
            name: _READERS[kind](cell) if cell else None for cell, (name, kind) in zip(line, kinds.items())
        }
    except (KeyError, ValueError):
        raise ValueError(f"line {number} holds a value of the wrong kind") from None


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)


def of_rows(rows: Iterable[Row], kinds: Mapping[str, str]) -> Table:
    """Return a table of these rows; what is no column of it is left out."""
    return Table(kinds, [{name: row.get(name) for name in kinds} for row in rows])
