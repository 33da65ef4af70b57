"""A planar lidar at another height: told once it flies there, not when it takes off, lands or hops."""

from __future__ import annotations

import math

import numpy as np

from gridslam.inputs.slice_watch import SliceWatch


def said_along(*legs):
    """What is said along legs of (metres along x, height from, height to), in steps of a tenth of a leg."""
    said, x = [], 0.0
    watch = SliceWatch(said.append)
    for way_m, begin_m, end_m in legs:
        for height_m in np.linspace(begin_m, end_m, 11)[1:]:
            x += way_m / 10
            watch.follow(x, 0.0, float(height_m))
    return said


def test_take_off_flight_and_landing_are_no_news():
    assert said_along((0.0, 0.1, 2.0), (20.0, 2.0, 2.0), (20.0, 2.3, 1.7), (0.0, 1.7, 0.1)) == []


def test_a_climb_is_told_once_and_so_is_the_way_back():
    said = said_along((5.0, 2.0, 2.0), (0.5, 2.0, 3.5), (20.0, 3.5, 3.5), (0.5, 3.5, 2.0), (20.0, 2.0, 2.0))
    assert len(said) == 2
    assert "flies at 3.5 m, and the map is of 2.0 m" in said[0]
    assert "flies at 2.0 m, and the map is of 3.5 m" in said[1]


def test_a_short_hop_is_not_told():
    assert said_along((5.0, 2.0, 2.0), (0.4, 2.0, 4.0), (0.4, 4.0, 2.0), (5.0, 2.0, 2.0)) == []


def test_an_unknown_height_is_not_told():
    assert said_along((5.0, 2.0, 2.0), (5.0, math.nan, math.nan), (5.0, 2.0, 2.0)) == []
