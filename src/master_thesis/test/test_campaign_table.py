"""The text of a campaign's table gives back what was put in, every bit of it."""

from __future__ import annotations

import io
import math

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from master_thesis.campaign.table import Table, of_rows, read_csv

KINDS = {"index": "int", "reached": "bool", "way_m": "float", "error": "str"}
VALUES = {
    "index": st.integers(-(2**62), 2**62),
    "reached": st.booleans(),
    "way_m": st.floats(allow_nan=False),
    "error": st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\0"), min_size=1),
}
ROWS = st.lists(
    st.fixed_dictionaries({name: st.none() | values for name, values in VALUES.items()}), max_size=4
)


@given(ROWS)
def test_what_is_read_is_what_was_written(rows):
    assert read_csv(Table(KINDS, rows).to_csv(), KINDS).rows == rows


def test_pandas_reads_the_text_as_the_table_tells_it():
    rows = [
        {"index": 0, "reached": True, "way_m": 0.1 + 0.2, "error": None},
        {"index": 1, "reached": False, "way_m": None, "error": 'said "no", twice'},
    ]
    table = Table(KINDS, rows)
    read = pd.read_csv(io.BytesIO(table.to_csv()), float_precision="round_trip")
    pd.testing.assert_frame_equal(read, table.to_pandas(), check_dtype=False)
    assert read["way_m"][0] == 0.1 + 0.2
    assert math.isnan(read["way_m"][1])


def test_a_number_that_is_missing_is_nan_in_pandas():
    frame = Table({"index": "int"}, [{"index": 3}, {}]).to_pandas()
    assert frame["index"][0] == 3
    assert math.isnan(frame["index"][1])


def test_what_is_no_column_is_left_out():
    assert of_rows([{"index": 1, "more": 2}], {"index": "int"}).rows == [{"index": 1}]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("index,reached,way_m\n", "its header is not this campaign's"),
        ("index,reached,way_m,error\n1,True\n", "line 2 has 2 cells in place of 4"),
        ("index,reached,way_m,error\n1,True,1.0,\n2,maybe,1.0,\n", "line 3 holds a value of the wrong kind"),
    ],
)
def test_another_table_is_refused_with_its_line(text, said):
    with pytest.raises(ValueError, match=said):
        read_csv(text.encode(), KINDS)
