"""What `doctor` says of a scan."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doctor.scans import geometry, values
from doctor.snapshot import Scan


def scan(range_max=10.0, ranges=(1.0, 2.0, math.inf)):
    return Scan("/scan", "laser", 0.0, 0.2, 0.1, 0.1, range_max, np.array(ranges))


@pytest.mark.filterwarnings("error")
@pytest.mark.table("range_max", [10.0, math.inf])
def test_a_lidar_without_a_greatest_range_is_as_good_as_another(range_max):
    assert list(geometry(scan(range_max))) == []
    assert list(values([scan(range_max)])) == []


def test_a_greatest_range_that_is_no_number_is_an_error():
    (diagnosis,) = geometry(scan(math.nan))
    assert "no numbers" in diagnosis.what


@pytest.mark.table(
    ("ranges", "saying"), [((1.0,) + (10.0,) * 20, "exactly 10 m"), ((11.0, 11.0, 11.0), "above range_max")]
)
def test_what_lies_at_the_greatest_range_or_beyond_is_said(ranges, saying):
    (diagnosis,) = values([scan(ranges=ranges)])
    assert saying in diagnosis.what
