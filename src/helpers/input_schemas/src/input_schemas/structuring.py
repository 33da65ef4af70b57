"""Turns plain content, as JSON and YAML give it, into dataclasses, and each fault into one sentence.

A schema is a frozen dataclass whose fields are the keys: `from_` is the key `from`. A number must be finite.
A key without a value counts as one that is not given. What a class refuses in its `__post_init__` is told
with its place.

cattrs structures it, because it takes the standard library's dataclasses as they are, is pure Python, and
is imported in 40 ms. pydantic has a compiled core, takes 11 MB and twice the time. Debian's is too old.
"""

from __future__ import annotations

import math
from typing import Any, Callable, NamedTuple, Sequence, TypeVar

from cattrs.errors import AttributeValidationNote, BaseValidationError, IterableValidationNote

from input_schemas.hooks import Key, KeyFaultError, WrongError, converter_of, needed_names

T = TypeVar("T")
LONGEST = 60
"""Of a value in a sentence, characters."""


class InputError(Exception):
    """Content that does not fit its schema. The sentence says where. keys: the way to the fault in it."""

    def __init__(self, sentence: str, keys: Sequence[Key] = ()) -> None:
        super().__init__(sentence)
        self.keys = tuple(keys)


class Fault(NamedTuple):
    """What is wrong in content.

    keys: the way to it. what: one sentence. cut: the way to the smallest thing that may be left out.
    """

    keys: tuple[Key, ...]
    what: str
    cut: tuple[Key, ...] = ()


def structured(
    content: Any, schema: type[T], error: type[Exception] = InputError, other_keys: bool = False
) -> T:
    """Return content as its schema has it.

    other_keys: keys that the schema does not know are ignored, as a newer program may have written them. Else
        they are refused, as somebody may have misspelt one.

    Raises:
        error: one sentence of the first fault.
    """
    try:
        structure: Callable[[Any, Any], T] = converter_of(other_keys).structure
        return structure(content, schema)
    except Exception as raised:  # what cattrs has collected, and what constructors raise
        fault = _faults_of(raised)[0]
    told = InputError(fault.what, fault.keys)
    if error is InputError:
        raise told
    raise error(fault.what) from told  # `files` tells its line


def leaving_out(content: Any, schema: type[T]) -> tuple[T, list[Fault]]:
    """Return content as its schema has it, without what is wrong, and the faults. Other keys are ignored.

    The smallest thing is left out that can be: a key that need not be there, or an entry of a list. `content`
    is changed.

    Raises:
        InputError: nothing is left that the schema would take.
    """
    left_out: list[Fault] = []
    while True:
        try:
            structure: Callable[[Any, Any], T] = converter_of(True).structure
            return structure(content, schema), left_out
        except Exception as raised:  # as above
            faults = _faults_of(raised)
        cuts = {each.cut: each for each in reversed(faults)}
        for cut in sorted(cuts, key=lambda keys: [str(key).zfill(9) for key in keys], reverse=True):
            if not cut:
                raise InputError(cuts[cut].what, cuts[cut].keys)
            holder = content
            for key in cut[:-1]:
                holder = holder[key]
            del holder[cut[-1]]
        left_out += cuts.values()


def _faults_of(
    raised: BaseException, keys: tuple[Key, ...] = (), cut: tuple[Key, ...] = (), of: Any = None
) -> list[Fault]:
    """Return the faults that cattrs has collected, in their order. of: the class that was structured."""
    for note in getattr(raised, "__notes__", ()):
        if isinstance(note, AttributeValidationNote):
            keys = (*keys, note.name.rstrip("_"))
            cut = cut if note.name in needed_names(of) else keys
        elif isinstance(note, IterableValidationNote):
            cut = keys = (*keys, note.index)
    if isinstance(raised, BaseValidationError):
        return [fault for each in raised.exceptions for fault in _faults_of(each, keys, cut, raised.cl)]
    if isinstance(raised, WrongError):
        told = f"{_named(keys)} is {_short(raised.given)}; it must be {raised.must_be}."
        return [Fault(keys, told + _how_to_write(raised.given), cut)]
    if isinstance(raised, KeyFaultError):
        return [Fault((*keys, raised.key), f"{_named(keys)} {raised}", cut)]
    told = str(raised) or type(raised).__name__
    told += "" if told.endswith((".", "?")) else "."
    return [Fault(keys, f"{_named(keys)}: {told}" if keys else told, cut)]


def _named(keys: Sequence[Key]) -> str:
    """Return in words what keys lead to: "yaw in entry 2 of photographs"."""
    words = ""
    for key in keys:
        if isinstance(key, int):
            words = f"entry {key + 1} of {words or 'the top level'}"
        else:
            words = f"{key} in {words}" if words else str(key)
    return words or "The top level"


def _how_to_write(given: Any) -> str:
    """Return how a number is written that YAML takes for a text, such as 1e3."""
    try:
        number = float(given) if isinstance(given, str) else math.nan
    except ValueError:
        return ""
    return f" Write {number!r}, without quotation marks." if math.isfinite(number) else ""


def _short(given: Any) -> str:
    told = repr(given)
    return told if len(told) <= LONGEST else f"{told[: LONGEST - 3]}..."
