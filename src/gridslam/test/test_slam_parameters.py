"""Parameters and scans that make no sense are refused in one sentence."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gridslam import MapError, OccupancyGrid, PlanarScan, ScanError, SlamParameters


def test_defaults_are_gmappings():
    expected = {
        "maxUrange": None,
        "maxRange": None,
        "sigma": 0.05,
        "kernelSize": 1,
        "lstep": 0.05,
        "astep": 0.05,
        "iterations": 5,
        "lsigma": 0.075,
        "ogain": 3.0,
        "lskip": 0,
        "minimumScore": 0.0,
        "srr": 0.1,
        "srt": 0.2,
        "str": 0.1,
        "stt": 0.2,
        "linearUpdate": 1.0,
        "angularUpdate": 0.5,
        "temporalUpdate": -1.0,
        "resampleThreshold": 0.5,
        "particles": 30,
        "delta": 0.05,
        "occ_thresh": 0.25,
        "llsamplerange": 0.01,
        "llsamplestep": 0.01,
        "lasamplerange": 0.005,
        "lasamplestep": 0.005,
    }
    parameters = SlamParameters()
    assert {name: getattr(parameters, name) for name in expected} == expected


def test_sides_of_the_map_that_are_not_given_are_gmappings():
    parameters = SlamParameters(xmin=-50.0, ymax=20.0)
    assert (parameters.xmin, parameters.ymin, parameters.xmax, parameters.ymax) == (
        -50.0,
        -100.0,
        100.0,
        20.0,
    )
    assert SlamParameters().ymin is None


def test_beams_are_used_no_farther_than_they_reach():
    assert SlamParameters(maxUrange=10.0, maxRange=8.0).ranges_for(30.0) == (8.0, 8.0)
    assert SlamParameters(maxUrange=10.0).ranges_for(8.01) == (8.0, 8.0)
    assert SlamParameters(maxUrange=6.0, maxRange=8.0).ranges_for(30.0) == (6.0, 8.0)


@pytest.mark.table(
    ("changes", "sentence"),
    [
        ({"ranges_m": [1.0]}, "1 ranges but 2 angles"),
        ({"ranges_m": [1.0, math.nan]}, "drop NaN"),
        ({"ranges_m": [1.0, -math.inf]}, "drop NaN and negative"),
        ({"angles_rad": [0.0, math.inf]}, "angles must be finite"),
        ({"ranges_m": ["near", "far"]}, "must be numbers"),
        ({"ranges_m": [[1.0, 2.0]]}, "must be one row"),
        ({"stamp_s": math.nan}, "stamp must be finite"),
        ({"range_max_m": math.inf}, "positive and finite"),
        ({"lidar_in_base": (0.0, 1.0)}, "lidar_in_base must be finite"),
    ],
)
def test_scans_that_make_no_sense_are_refused(changes, sentence):
    sound = {
        "stamp_s": 1.0,
        "angles_rad": [0.0, 1.0],
        "ranges_m": [1.0, math.inf],
        "lidar_in_base": (0.0, 0.0, 0.0),
        "range_max_m": 5.0,
    }
    PlanarScan(**sound)
    with pytest.raises(ScanError, match=sentence):
        PlanarScan(**{**sound, **changes})


@pytest.mark.table(
    ("cells", "resolution", "origin", "sentence"),
    [
        (np.zeros(3), 0.1, (0.0, 0.0), "must be a table"),
        (np.full((2, 2), 101), 0.1, (0.0, 0.0), "between -1"),
        (np.zeros((2, 2)), 0.0, (0.0, 0.0), "resolution must be positive"),
        (np.zeros((2, 2)), 0.1, (0.0, math.nan), "origin must be finite"),
    ],
)
def test_grids_that_make_no_sense_are_refused(cells, resolution, origin, sentence):
    with pytest.raises(MapError, match=sentence):
        OccupancyGrid(cells, resolution, origin)
