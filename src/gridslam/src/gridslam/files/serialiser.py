"""The one serialiser: a tree of plain values as arrays for an .npz file, and back. No pickles.

A tree is made of dataclasses and named tuples of given classes, lists, tuples, dictionaries, arrays, numbers,
text and None. Its structure becomes JSON. The content of all arrays of one type becomes one long array. An
array that stands in a tree twice is written once, and is one array again when it is read.
"""

from __future__ import annotations

import dataclasses
import json
from typing import Any, Iterable, Mapping

import numpy as np

TREE = "tree"
"""Name of the structure among the arrays; the others are named by their type."""
CLASS, FIELDS, ARRAY, TUPLE, MAPPING = "class", "fields", "array", "tuple", "mapping"
DTYPES = ("bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "float64")


def pack(tree: Any) -> dict[str, np.ndarray]:
    """Return a tree as arrays by name.

    Raises:
        TypeError: it holds something that is not plain.
    """
    writer = _Writer()
    structure = json.dumps(writer.written(tree))
    return {TREE: np.array(structure), **writer.arrays()}


def unpack(arrays: Mapping[str, np.ndarray], classes: Iterable[type]) -> Any:
    """Return the tree from the output of `pack`.

    Args:
        arrays: by name.
        classes: all dataclasses and named tuples that it may hold. They check their own values.

    Raises:
        ValueError, TypeError, LookupError: it is no such tree.
    """
    reader = _Reader(arrays, {each.__name__: each for each in classes})
    return reader.read(json.loads(str(arrays[TREE])))


class _Writer:
    def __init__(self) -> None:
        self._parts: dict[str, list[np.ndarray]] = {}
        self._sizes: dict[str, int] = {}
        self._known: dict[int, tuple[np.ndarray, list]] = {}
        """By identity, so the arrays themselves are kept, too."""

    def arrays(self) -> dict[str, np.ndarray]:
        return {name: np.concatenate(parts) for name, parts in self._parts.items()}

    def written(self, value: Any) -> Any:
        if value is None or isinstance(value, (bool, int, float, str)):
            return value
        if isinstance(value, np.ndarray):
            return {ARRAY: self._place(value)}
        if isinstance(value, np.generic):
            return value.item()
        if dataclasses.is_dataclass(value):
            names = [field.name for field in dataclasses.fields(value)]
            return self._object(value, [getattr(value, name) for name in names])
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            return self._object(value, value)
        if isinstance(value, tuple):
            return {TUPLE: [self.written(each) for each in value]}
        if isinstance(value, list):
            return [self.written(each) for each in value]
        if isinstance(value, Mapping):
            return {MAPPING: {str(name): self.written(each) for name, each in value.items()}}
        raise TypeError(f"{type(value).__name__} is no plain value")

    def _object(self, value: Any, fields: Iterable[Any]) -> dict:
        return {CLASS: type(value).__name__, FIELDS: [self.written(each) for each in fields]}

    def _place(self, array: np.ndarray) -> list:
        """Return [type, first element, shape] of an array."""
        if id(array) not in self._known:
            name = str(array.dtype)
            if name not in DTYPES:
                raise TypeError(f"an array of {name} is no plain value")
            first = self._sizes.get(name, 0)
            self._parts.setdefault(name, []).append(array.ravel())
            self._sizes[name] = first + array.size
            self._known[id(array)] = array, [name, first, list(array.shape)]
        return self._known[id(array)][1]


class _Reader:
    def __init__(self, arrays: Mapping[str, np.ndarray], classes: Mapping[str, type]) -> None:
        self._arrays, self._classes = arrays, classes
        self._known: dict[tuple, np.ndarray] = {}

    def read(self, node: Any) -> Any:
        if isinstance(node, list):
            return [self.read(each) for each in node]
        if not isinstance(node, dict):
            return node
        if ARRAY in node:
            return self._array(*node[ARRAY])
        if CLASS in node:
            return self._classes[node[CLASS]](*(self.read(each) for each in node[FIELDS]))
        if TUPLE in node:
            return tuple(self.read(each) for each in node[TUPLE])
        return {name: self.read(each) for name, each in node[MAPPING].items()}

    def _array(self, name: str, first: int, shape: list[int]) -> np.ndarray:
        key = (name, first, *shape)
        if key not in self._known:
            if name not in DTYPES or first < 0 or any(side < 0 for side in shape):
                raise ValueError("an array is not where it should be")
            flat = self._arrays[name]
            if flat.dtype != name or flat.ndim != 1:
                raise ValueError(f"the arrays of {name} are {flat.dtype} of shape {flat.shape}")
            last = first + int(np.prod(shape, dtype=object))
            if last > len(flat):
                raise ValueError("an array is cut off")
            self._known[key] = flat[first:last].reshape(shape).copy()
        return self._known[key]
