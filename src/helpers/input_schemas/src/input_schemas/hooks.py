"""What each kind of value may be made of: the hooks of cattrs.

What cattrs would take is checked first: it makes 3.7 a whole number, "7" a number, and a text a list of
letters.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping
from datetime import date
from functools import cache
from typing import Any, Callable, Literal, NewType, get_args, get_origin, get_type_hints

from cattrs import Converter
from cattrs.cols import homogenous_tuple_structure_factory, list_structure_factory
from cattrs.gen import make_dict_structure_fn, mapping_structure_factory, override

Key = str | int
MaybeInfinite = NewType("MaybeInfinite", float)
"""A number that may be inf, where that means no limit."""
FEW_KEYS = 12


class WrongError(Exception):
    """A value that is not what it must be; must_be: in words."""

    def __init__(self, given: Any, must_be: str) -> None:
        super().__init__(given, must_be)
        self.given, self.must_be = given, must_be


class KeyFaultError(Exception):
    """A mapping that lacks a key or has one too many. what: in words, after the mapping's name."""

    def __init__(self, key: Key, what: str) -> None:
        super().__init__(what)
        self.key = key


@cache
def converter_of(other_keys: bool) -> Converter:
    """Return what structures content. other_keys: those that a schema does not know are ignored."""
    converter = Converter(detailed_validation=True)
    for kind, hook in (
        (float, _float),
        (MaybeInfinite, _maybe_infinite),
        (int, _int),
        (bool, _bool),
        (str, _str),
    ):
        converter.register_structure_hook(kind, hook)
    of = converter.register_structure_hook_factory
    of(lambda kind: get_origin(kind) is Literal, _literal)
    of(_is_list, lambda kind, c: _of_shape(list, "a list", list_structure_factory(kind, c)))
    of(_is_row, lambda kind, c: _of_shape(list, "a list", homogenous_tuple_structure_factory(kind, c)))
    of(_is_tuple, _tuple)
    of(_is_mapping, lambda kind, c: _of_shape(Mapping, "a mapping", mapping_structure_factory(kind, c)))
    of(_is_schema, lambda kind, c: _schema(kind, c, other_keys))
    return converter


def _is_list(kind: Any) -> bool:
    return get_origin(kind) is list


def _is_row(kind: Any) -> bool:
    return get_origin(kind) is tuple and get_args(kind)[1:] == (...,)


def _is_tuple(kind: Any) -> bool:
    return get_origin(kind) is tuple and not _is_row(kind)


def _is_mapping(kind: Any) -> bool:
    return get_origin(kind) is dict


def _is_schema(kind: Any) -> bool:
    return isinstance(kind, type) and dataclasses.is_dataclass(kind)


def _number(given: Any, must_be: str) -> float:
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise WrongError(given, must_be)
    try:
        return float(given)
    except OverflowError:
        return math.inf


def _float(given: Any, _: Any) -> float:
    number = _number(given, "a finite number")
    if not math.isfinite(number):
        raise WrongError(given, "a finite number")
    return number


def _maybe_infinite(given: Any, _: Any) -> float:
    number = _number(given, "a number")
    if math.isnan(number):
        raise WrongError(given, "a number")
    return number


def _int(given: Any, _: Any) -> int:
    if not _number(given, "a whole number").is_integer():
        raise WrongError(given, "a whole number")
    return int(given)


def _bool(given: Any, _: Any) -> bool:
    if not isinstance(given, bool):
        raise WrongError(given, "true or false")
    return given


def _str(given: Any, _: Any) -> str:
    """Take what YAML makes of a name without quotes, too: 7, and 2026-05-01."""
    if isinstance(given, bool) or not isinstance(given, (str, int, float, date)):
        raise WrongError(given, "a text")
    return str(given)


def _literal(kind: Any, _: Converter) -> Callable[[Any, Any], Any]:
    def structure(given: Any, _: Any) -> Any:
        if not isinstance(given, str) or given not in get_args(kind):
            raise WrongError(given, f"one of {', '.join(get_args(kind))}")
        return given

    return structure


def _of_shape(shape: type, words: str, inner: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    def structure(given: Any, kind: Any) -> Any:
        if not isinstance(given, shape):
            raise WrongError(given, words)
        return inner(given, kind)

    return structure


def _tuple(kind: Any, converter: Converter) -> Callable[[Any, Any], Any]:
    """Return the hook of a list with as many entries as the tuple has."""
    parts = get_args(kind)
    words = {frozenset({float}): "finite numbers", frozenset({MaybeInfinite}): "numbers"}
    of = words.get(frozenset(parts))
    must_be = f"a list of {len(parts)} {of or 'entries'}"

    def structure(given: Any, _: Any) -> Any:
        if not isinstance(given, list) or len(given) != len(parts):
            raise WrongError(given, must_be)
        try:
            return tuple(map(converter.structure, given, parts))
        except WrongError as error:
            raise WrongError(given, must_be if of else f"{must_be}, {error.must_be} each") from None

    return structure


def _schema(kind: Any, converter: Converter, other_keys: bool) -> Callable[[Any, Any], Any]:
    fields = [each for each in dataclasses.fields(kind) if each.init]
    names = {each.name.rstrip("_"): each for each in fields}
    needed = [name for name, each in names.items() if each.name in needed_names(kind)]
    keys = f"keys {', '.join([*names][:FEW_KEYS])}"
    kinds = get_type_hints(kind)
    may_be_none = {
        n for n in needed if kinds[names[n].name] is Any or type(None) in get_args(kinds[names[n].name])
    }
    renamed: Any = {f.name: override(rename=name) for name, f in names.items() if f.name != name}
    build = make_dict_structure_fn(kind, converter, **renamed)

    def structure(given: Any, _: Any) -> Any:
        if not isinstance(given, Mapping):
            raise WrongError(given, f"a mapping with the {keys}")
        unknown = [] if other_keys else [key for key in given if key not in names]
        if unknown:
            near = difflib.get_close_matches(str(unknown[0]), names, 1)
            hint = f"did you mean '{near[0]}'?" if near else f"it may have the {keys}."
            raise KeyFaultError(unknown[0], f"has the key '{unknown[0]}', which is unknown; {hint}")
        held = {key: value for key, value in given.items() if value is not None or key in may_be_none}
        for key in needed:
            if key not in held:
                raise KeyFaultError(key, f"lacks the key '{key}'.")
        return build(held, kind)

    return structure


def needed_names(kind: Any) -> set[str]:
    """Return the names of the fields that must be given."""
    missing = dataclasses.MISSING
    fields = (each for each in dataclasses.fields(kind) if each.init)
    return {each.name for each in fields if each.default is missing and each.default_factory is missing}
