"""Reads a YAML file of one thing: a mission, a plan, a ship."""

from __future__ import annotations

import codecs
from pathlib import Path
from typing import Any, Callable, TypeVar

from flight_basics.errors import FlightBasicsError

Thing = TypeVar("Thing")
UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
"""Begins of a text as PowerShell writes it."""


def text_of(content: bytes) -> str:
    """Return the text of a file that people write: UTF-8, UTF-16 with its mark, or of an older editor."""
    try:
        return content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # only names and remarks hold other than ASCII


def read_yaml(
    path: str | Path, what: str, parse: Callable[[Any], Thing], error: type[FlightBasicsError]
) -> Thing:
    """Return what `parse` makes of the content of a file.

    what: the file in sentences, such as "The ship".

    Raises:
        error: it cannot be read, or is not YAML, or `parse` has raised a FlightBasicsError. The sentence
            names the file.
    """
    import yaml  # only if a file is read

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        content = yaml.load(text_of(Path(path).read_bytes()), loader)
    except OSError as fault:
        raise error(f"{what} {path} cannot be read: {fault.strerror}.") from None
    except (yaml.YAMLError, ValueError, RecursionError) as fault:  # no text, endless digits, endless depth
        where = getattr(fault, "problem_mark", None)
        line = f", line {where.line + 1}" if where else ""
        raise error(f"{what} {path} is not YAML{line}.") from None
    try:
        return parse(content)
    except FlightBasicsError as fault:
        raise error(f"{path}: {fault}") from None
