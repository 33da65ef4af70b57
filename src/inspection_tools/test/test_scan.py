"""Geometry of scans: which close the circle, which divide it, which are nonsense."""

import math

import numpy as np
import pytest

from flight_basics.errors import ScanError
from inspection_tools import ScanGeometry

DEGREE = math.pi / 180.0


@pytest.mark.table(
    ("beams", "increment_deg", "closes"),
    [
        (1440, 0.25, True),
        (1441, 0.25, True),  # the first beam repeated
        (1439, 0.25, False),  # one direction is missing
        (1442, 0.25, False),  # it goes on beyond the turn: the last beam is no neighbour of the first
        (1900, -0.25, False),
        (1081, 0.25, False),
        (1800, -0.2, True),
        (1, 0.25, False),
    ],
)
def test_closes_circle(beams, increment_deg, closes):
    assert ScanGeometry(beams, 0.3, increment_deg * DEGREE).closes_circle is closes


@pytest.mark.table(
    ("increment_deg", "turn"), [(360 / 1024, 1024), (0.25, 1440), (0.2, 1800), (1 / 3, 1080), (-0.2, 1800)]
)
def test_beams_per_turn_survives_float32(increment_deg, turn):
    assert ScanGeometry(10, 0.0, float(np.float32(increment_deg * DEGREE))).beams_per_turn == turn


@pytest.mark.table(
    ("increment_deg", "turn"), [(0.7, 514), (7.0, 51), (270.0 / 1081.0, 1441), (135.0, 3), (300.0, 1)]
)
def test_an_increment_that_does_not_divide_the_turn_is_rounded(increment_deg, turn):
    assert ScanGeometry(10, 0.0, increment_deg * DEGREE).beams_per_turn == turn


@pytest.mark.table(
    ("beams", "start", "increment", "complaint"),
    [
        (0, 0.0, 0.1, "no beams"),
        (5, math.nan, 0.1, "angle_min is nan"),
        (5, 0.0, 0.0, "angle_increment is 0.0"),
        (5, 0.0, math.nan, "angle_increment is nan"),
        (5, 0.0, math.inf, "angle_increment is inf"),
        (5, 0.0, -7.0, "less than a turn"),
    ],
)
def test_refuses(beams, start, increment, complaint):
    with pytest.raises(ScanError, match=complaint):
        ScanGeometry(beams, start, increment)
