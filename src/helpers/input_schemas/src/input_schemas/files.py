"""Reads files of JSON and YAML that people or other programs wrote. A fault is one sentence with its line."""

from __future__ import annotations

import codecs
import json
import re
from pathlib import Path
from typing import Any, Callable, Sequence, TypeVar

from input_schemas.hooks import Key
from input_schemas.structuring import InputError, leaving_out, structured

S = TypeVar("S")
T = TypeVar("T")
TAB = re.compile(r"[ -]*\t")
"""In the indentation of a line of YAML."""
UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
"""Begins of a text as PowerShell writes it."""


def text_of(content: bytes) -> str:
    """Return the text of a file that people write: UTF-8, UTF-16 with its mark, or of an older editor."""
    try:
        return content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # only names and remarks hold other than ASCII


def read_file(
    path: str | Path, what: str, schema: type[S], error: type[Exception], other_keys: bool = False
) -> S:
    """Return what a file holds. One whose name ends with .json is JSON, any other YAML.

    what: the file in a sentence, such as "The ship". other_keys: see `structured`.

    Raises:
        error: it cannot be read, is no JSON or YAML, or does not fit. The sentence names file, line and key.
    """
    return read_made(path, what, lambda content: structured(content, schema, other_keys=other_keys), error)


def read_made(
    path: str | Path,
    what: str,
    make: Callable[[Any], T],
    error: type[Exception],
    plain: Callable[[str], str] = str,
    loader: Any = None,
) -> T:
    """Return what `make` returns of a file's content, where a schema does not tell all. Else as `read_file`.

    make: may raise whatever has the same base class as `error`. plain: makes YAML with the same lines of a
        text that only another program's reader takes. loader: of PyYAML; None: the safe one.
    """
    text = plain(_text_in(path, what, error))
    content = _content_of(path, text, what, error, loader)
    family = next(
        each for each in reversed(error.__mro__) if issubclass(each, Exception) and each is not Exception
    )
    try:
        return make(content)
    except (InputError, family) as fault:
        keys = getattr(fault, "keys", getattr(fault.__cause__, "keys", ()))
        raise error(f"{_place(path, text, keys)}: {fault}") from None


def read_without(path: str | Path, what: str, schema: type[S], error: type[Exception]) -> tuple[S, list[str]]:
    """Return what a file holds without what is wrong in it, and a sentence on each thing that is left out.

    Raises:
        error: as `read_file`; nothing is left that the schema would take.
    """
    text = _text_in(path, what, error)
    try:
        held, faults = leaving_out(_content_of(path, text, what, error), schema)
    except InputError as fault:
        raise error(f"{_place(path, text, fault.keys)}: {fault}") from None
    return held, [f"{_place(path, text, each.keys)}: {each.what} It is left out." for each in faults]


def _text_in(path: str | Path, what: str, error: type[Exception]) -> str:
    try:
        return text_of(Path(path).read_bytes())
    except OSError as fault:
        raise error(f"{what} {path} cannot be read: {fault.strerror}.") from None


def _content_of(path: str | Path, text: str, what: str, error: type[Exception], loader: Any = None) -> Any:
    import yaml  # only if a file is read

    is_json = Path(path).suffix.lower() == ".json"
    try:
        if is_json:
            return json.loads(text)
        return yaml.load(text, loader or getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except json.JSONDecodeError as fault:
        why = f"line {fault.lineno}, column {fault.colno} is not JSON ({fault.msg})"
    except yaml.MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        line, column, why = mark.line, mark.column, fault.problem
        lines = text.split("\n")[: line + 1]
        if (tab := TAB.match(lines[line] if line < len(lines) else "")) is not None:
            column, why = tab.end() - 1, "a tab is in its indentation; use spaces"
        why = f"line {line + 1}, column {column + 1} is not YAML ({why})"
    except (yaml.YAMLError, ValueError, RecursionError):  # no text, endless digits, endless depth
        why = f"it is not {'JSON' if is_json else 'YAML'}"
    raise error(f"{what} {path} cannot be read: {why}.")


def _place(path: str | Path, text: str, keys: Sequence[Key]) -> str:
    """Return file and line to which keys lead; of a key that is not there, that of what should hold it."""
    import yaml

    try:  # JSON is YAML, but for some tabs
        node = yaml.compose(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError):
        return str(path)
    line = 0
    for key in keys:
        if isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
            line = node.start_mark.line
        elif isinstance(node, yaml.MappingNode):
            found = next(((k, v) for k, v in node.value if k.value == str(key)), None)
            if found is None:
                break
            line, node = found[0].start_mark.line, found[1]
    return f"{path}, line {line + 1}" if line or keys else str(path)
