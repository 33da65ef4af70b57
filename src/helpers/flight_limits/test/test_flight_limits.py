"""Keep-out boxes and the ceiling, from a file."""

import itertools
import math

import pytest

from flight_limits import KeepOutBox, Limits, LimitsError, parse_limits, read_limits
from flight_limits.limits import FARTHEST_M

GOOD = """
ceiling: 8
keep_out:
  - {name: hatch, low: [1, 2, 3], high: [4.5, 5, 6]}
  - {low: [-1, -1, -1], high: [0, 0, 0]}
"""


def test_a_file_holds_boxes_and_a_ceiling(tmp_path):
    path = tmp_path / "limits.yaml"
    path.write_text(GOOD)
    boxes = KeepOutBox((1, 2, 3), (4.5, 5, 6), "hatch"), KeepOutBox((-1, -1, -1), (0, 0, 0), "2")
    assert read_limits(path) == Limits(boxes, 8)
    assert parse_limits({}) == Limits((), math.inf)


@pytest.mark.table("place_m", list(itertools.product((-9.0, 0.0, 9.0), repeat=3)))
def test_all_around_the_box_keep_in_is_kept_out(place_m):
    limits = parse_limits({"keep_in": {"low": [-2, -3, -4], "high": [2, 3, 4]}})
    assert any(box.holds(place_m) for box in limits.boxes) == (place_m != (0.0, 0.0, 0.0))


def test_a_box_that_reaches_to_the_end_of_the_world_has_nothing_beyond():
    inner = {"low": [-FARTHEST_M, -1, 0], "high": [FARTHEST_M, 1, 9]}
    assert [box.name for box in parse_limits({"keep_in": inner}).boxes] == [
        "y below keep_in",
        "y above keep_in",
        "z below keep_in",
        "z above keep_in",
    ]


def test_a_box_the_wrong_way_round_is_refused_with_a_sentence(tmp_path):
    path = tmp_path / "limits.yaml"
    path.write_text("{keep_out: [{low: [0, 0, 2], high: [1, 1, 1], name: tank}]}")
    with pytest.raises(LimitsError, match=r"limits\.yaml: .*box tank has z from 2 to 1 m"):
        read_limits(path)
