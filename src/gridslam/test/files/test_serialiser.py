"""The serialiser gives back the tree that it got, and refuses what is none."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from gridslam.files.saved_classes import SAVED_CLASSES
from gridslam.files.serialiser import DTYPES, TREE, pack, unpack


@dataclass(frozen=True, eq=False)
class Pair:
    """Two of anything."""

    one: Any
    other: Any


class Named(NamedTuple):
    """A named tuple."""

    value: Any


CLASSES = (Pair, Named)
NUMBERS = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
ARRAYS = npst.arrays(st.sampled_from(DTYPES), npst.array_shapes(min_dims=0, min_side=0, max_side=4))
TREES = st.recursive(
    NUMBERS | ARRAYS,
    lambda trees: (
        st.lists(trees, max_size=3)
        | st.lists(trees, max_size=3).map(tuple)
        | st.dictionaries(st.text(), trees, max_size=3)
        | st.builds(Pair, trees, trees)
        | st.builds(Named, trees)
    ),
    max_leaves=12,
)


def assert_same(one: Any, other: Any) -> None:
    """Bit for bit, and of the same types."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())
    elif isinstance(one, Pair):
        assert_same([one.one, one.other], [other.one, other.other])
    elif isinstance(one, dict):
        assert list(one) == list(other)
        assert_same(list(one.values()), list(other.values()))
    elif isinstance(one, (list, tuple)):
        assert len(one) == len(other)
        for each, twin in zip(one, other):
            assert_same(each, twin)
    else:
        assert repr(one) == repr(other)  # NaN, too


@given(TREES)
def test_a_tree_comes_back_as_it_was(tree):
    assert_same(unpack(pack(tree), CLASSES), tree)


@pytest.mark.table("value", [{1, 2}, print, 1j, np.array(["text"]), b"bytes"])
def test_what_is_not_plain_is_refused(value):
    with pytest.raises(TypeError, match="no plain value"):
        pack({"in it": [value]})


@pytest.mark.table(
    "structure",
    [
        {"array": ["float64", 1, [4]]},
        {"array": ["float64", -1, [2]]},
        {"array": ["float64", 0, [-2]]},
        {"array": ["float64", 0, [2**40, 2**40]]},
        {"array": ["int64", 0, [2]]},
        {"array": ["object", 0, [2]]},
        {"array": ["float64"]},
        {"class": "Popen", "fields": [["true"]]},
        {"class": "Pair", "fields": [1]},
        {"list": []},
    ],
)
def test_structures_that_point_at_what_is_not_there_are_refused(structure):
    packed = {**pack(np.arange(4.0)), TREE: np.array(json.dumps(structure))}
    with pytest.raises((ValueError, TypeError, LookupError)):
        unpack(packed, CLASSES)


def test_no_two_saved_classes_have_one_name():
    assert len({each.__name__ for each in SAVED_CLASSES}) == len(SAVED_CLASSES)
