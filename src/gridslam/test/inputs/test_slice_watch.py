"""Level scans at another height: told once the vehicle flies there, not when it takes off, lands or hops."""

from __future__ import annotations

import math

import numpy as np

from gridslam.inputs.slice_watch import SliceWatch


def changes_along(*legs, watch=None):
    """The changes along legs of (metres along x, height from, height to), in steps of a tenth of a leg."""
    changes, x = [], 0.0
    watch = watch or SliceWatch()
    for way_m, begin_m, end_m in legs:
        for height_m in np.linspace(begin_m, end_m, 11)[1:]:
            x += way_m / 10
            changes.append(watch.follow(x, 0.0, float(height_m)))
    return [change for change in changes if change is not None]


def test_take_off_flight_and_landing_are_no_news():
    assert changes_along((0.0, 0.1, 2.0), (20.0, 2.0, 2.0), (20.0, 2.3, 1.7), (0.0, 1.7, 0.1)) == []


def test_a_climb_is_told_once_and_so_is_the_way_back():
    legs = (5.0, 2.0, 2.0), (0.5, 2.0, 3.5), (20.0, 3.5, 3.5), (0.5, 3.5, 2.1), (20.0, 2.1, 2.1)
    assert changes_along(*legs) == [(2.0, 3.5), (3.5, 2.0)]


def test_a_short_hop_is_not_told():
    assert changes_along((5.0, 2.0, 2.0), (0.4, 2.0, 4.0), (0.4, 4.0, 2.0), (5.0, 2.0, 2.0)) == []


def test_an_unknown_height_is_not_told():
    assert changes_along((5.0, 2.0, 2.0), (5.0, math.nan, math.nan), (5.0, 2.0, 2.0)) == []


def test_it_goes_on_from_its_state():
    first, second = SliceWatch(), SliceWatch()
    changes_along((5.0, 2.0, 2.0), (5.0, 4.0, 4.0), watch=first)
    second.restore(first.state())
    assert changes_along((5.0, 2.2, 2.2), watch=second) == [(4.0, 2.0)]
