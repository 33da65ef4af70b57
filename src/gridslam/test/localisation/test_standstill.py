"""Scans that change while odometry stands still are noticed; people before the lidar are not."""

import dataclasses

import numpy as np
from planar_world import scan_at
from rooms import UST, WALLS

from gridslam.localisation.standstill import Standstill, changed_share

RNG = np.random.default_rng(0)


def seen(x, stamp_s):
    return scan_at(WALLS, (x, -1.5, 0.0), UST, RNG, stamp_s)


def test_a_vehicle_that_moves_without_odometry_is_noticed():
    watch = Standstill()
    assert not any(watch.has_changed(seen(0.0, 0.1 * i), np.zeros(3)) for i in range(30))
    # then it moves at 1 m/s, and odometry does not
    noticed = [watch.has_changed(seen(0.1 * i, 3.0 + 0.1 * i), np.zeros(3)) for i in range(30)]
    assert any(noticed)
    assert sum(noticed) <= 2  # at most once in a second


def test_odometry_that_moves_is_in_order():
    watch = Standstill()
    moved = (watch.has_changed(seen(0.1 * i, 0.1 * i), np.array((0.1 * i, 0.0, 0.0))) for i in range(30))
    assert not any(moved)


def test_somebody_before_the_lidar_is_no_motion():
    watch = Standstill()
    first = seen(0.0, 0.0)
    watch.has_changed(first, np.zeros(3))
    near = np.where(np.arange(first.ranges_m.size) < 0.35 * first.ranges_m.size, 0.5, first.ranges_m)
    assert not watch.has_changed(dataclasses.replace(first, stamp_s=5.0, ranges_m=near), np.zeros(3))


def test_beams_without_a_return_say_nothing():
    first = seen(0.0, 0.0)
    none = dataclasses.replace(first, ranges_m=np.full_like(first.ranges_m, np.inf))
    assert changed_share(first, none) == 0.0
