"""Reads tables that people write: CSV from a spreadsheet of any country, or from a text editor."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path
from typing import Mapping, NamedTuple, Sequence

SEPARATORS = (";", "\t", "|", ",")
"""The head of a table has the one that is meant most often; a comma may be in numbers, so it comes last."""
BESIDE_WORDS = r"[\W_]+"
"""Of a head: what separates its words."""
ENCODINGS = ("utf-8-sig", "utf-16", "cp1252")
REMARK = "#"
_NUMBERED = re.compile(REMARK + r"\s*\d")
_RULE = re.compile(r":?-{2,}:?")
"""A cell of the line under the head of a table in Markdown."""


class TableError(ValueError):
    """A table that cannot be read; its message is one sentence that names file and row."""


class Row(NamedTuple):
    """A row of a table. where: file and line, for a sentence. values: by the head of their column."""

    where: str
    values: Mapping[str, str]


class Table(NamedTuple):
    """rows: of a table. unused: the heads that are not known, as they are written."""

    rows: list[Row]
    unused: list[str]


def read_table(
    path: Path, heads: Mapping[str, Sequence[str]], needed: Sequence[str], numbered: str = ""
) -> Table:
    """Return the rows of a table, without those that are empty, and without remarks, which begin with #.

    A byte order mark, UTF-16, ends of lines, semicolons, tabs, spaces, brackets and capitals in the heads do
    no harm. Heads may begin with #. Columns that are not known are left out. A number may have a decimal
    comma if commas do not separate.

    numbered: the column whose numbers may begin with #; where it is the first, such a row is no remark.
    heads: names by which a column is known, in small letters, by the name that it gets. needed: columns that
        must be there.

    Raises:
        TableError: it cannot be read, lacks a column, has one twice, or has a row that is too long.
    """
    text = _text_of(path)
    separator = _separator_of(text)
    lines = csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True, strict=True)
    columns: list[str | None] | None = None
    rows, unused = list[Row](), list[str]()
    try:
        for cells in lines:
            values = [each.strip() for each in cells]
            if not any(values) or _is_of_excel(values) or _is_rule(values):
                continue
            if columns is None and _is_head(values, heads, needed):
                values[0] = values[0].lstrip(f"{REMARK} ")
            elif _is_remark(values) and not (_NUMBERED.match(values[0]) and (columns or [""])[0] == numbered):
                continue
            where = f"{path}, line {lines.line_num}"
            if columns is None:
                columns = _columns_of(where, values, heads, needed)
                unused = [each for each, name in zip(values, columns) if each and name is None]
                continue
            _check_row(where, values, len(columns), separator)
            rows.append(Row(where, {name: value for name, value in zip(columns, values) if name}))
    except csv.Error as error:
        raise TableError(f"{path}, line {lines.line_num}: the row is no CSV ({error}).") from None
    if columns is None:
        raise TableError(f"{path}: the table is empty; its first row must be {', '.join(heads)}.")
    return Table(rows, unused)


def number_of(text: str) -> float:
    """Return the number in a cell, which may have a decimal comma. Raises ValueError if it is none."""
    if "_" in text:
        raise ValueError(text)
    text = text.replace("\N{MINUS SIGN}", "-")
    return float(text.replace(",", ".") if "." not in text else text)


def _text_of(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise TableError(f"{path}: cannot be read: {error.strerror}.") from None
    for encoding in ENCODINGS:
        if encoding == "utf-16" and content[:2] not in (b"\xff\xfe", b"\xfe\xff"):
            continue
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text.replace("\r\n", "\n").replace("\r", "\n")
    raise TableError(f"{path}: is no text. Store the table as CSV in UTF-8.")


def _is_head(values: Sequence[str], heads: Mapping[str, Sequence[str]], needed: Sequence[str]) -> bool:
    """Return whether a line is the head, although it begins with #."""
    known = {_known(each, heads) for each in values}
    return values[0].startswith(REMARK) and known.issuperset(needed)


def _is_remark(values: Sequence[str]) -> bool:
    return values[0].startswith(REMARK)


def _is_rule(values: Sequence[str]) -> bool:
    """Return whether a row is what Markdown draws under a head."""
    return all(_RULE.fullmatch(each) for each in values if each)


def _check_row(where: str, values: Sequence[str], columns: int, separator: str) -> None:
    """Raise TableError if a row has values of several, or a comma of a number has cut it."""
    if any(values[columns:]) or (len(values) > columns and separator == "," and _may_be_cut(values)):
        raise TableError(
            f"{where}: the row has {len(values)} values for {columns} columns. A comma in a "
            "number needs another separator, such as a semicolon."
        )
    if any(line.count(separator) >= columns - 1 > 0 for each in values for line in each.split("\n")[1:]):
        raise TableError(f"{where}: a quotation mark that is not closed has taken the rows after it.")


def _may_be_cut(values: Sequence[str]) -> bool:
    """Return whether two neighbours may be one number with a decimal comma: no cell has a decimal point."""
    whole = [each.lstrip("-").isdecimal() for each in values]
    has_point = any(re.search(r"\d\.\d", each) for each in values)
    return not has_point and any(a and b for a, b in zip(whole, whole[1:]))


def _is_of_excel(values: Sequence[str]) -> bool:
    """Return whether a row is Excel's "sep=;": it tells the separator to Excel."""
    return values[0].lower().startswith("sep=")


def _separator_of(text: str) -> str:
    """Return what separates the head's words. A word in quotes may have several lines."""
    plain = re.sub(r'"[^"]*"', "", text)
    lines = (line for line in plain.splitlines() if line.strip() and not line.startswith("#"))
    head = next((line for line in lines if not _is_of_excel([line])), "")
    return max(SEPARATORS, key=head.count)


def _known(name: str, heads: Mapping[str, Sequence[str]]) -> str | None:
    """Return what a column is known as; None: it is not known."""
    word = re.sub(BESIDE_WORDS, "_", name.lower()).strip("_")
    return next((key for key, several in heads.items() if word in (key, *several)), None)


def _columns_of(
    where: str, names: Sequence[str], heads: Mapping[str, Sequence[str]], needed: Sequence[str]
) -> list[str | None]:
    """Return what each column is known as; None: it is not known."""
    columns = [_known(name, heads) for name in names]
    twice = sorted({each for each in columns if each and columns.count(each) > 1})
    if twice:
        raise TableError(f"{where}: there are two columns for {twice[0]}.")
    missing = [each for each in needed if each not in columns]
    if missing:
        raise TableError(f"{where}: there is no column {missing[0]}; the heads must be {', '.join(heads)}.")
    return columns
