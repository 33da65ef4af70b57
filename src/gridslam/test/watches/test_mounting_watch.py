"""A lidar that hangs upside down untold is found by the first turns; one that is in order never is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import planar_world
import pytest

from gridslam.errors import MountingError
from gridslam.watches.mounting_watch import MountingWatch

LIDAR = planar_world.Lidar(6.2, 180, 20.0, 0.01, 10.0)
ROUTE = np.array([(-8.0, -5.0), (0.0, -5.0), (0.0, 3.0), (-6.0, 3.0), (-6.0, 0.0)])
TRUTH = planar_world.along(ROUTE, 0.2)


def mirrored(scan):
    return replace(scan, angles_rad=-scan.angles_rad)


@pytest.fixture(scope="module", params=[0, 1, 2])
def log(request):
    walls = planar_world.scattered_boxes(request.param, TRUTH) if request.param else planar_world.hold()
    return planar_world.drive(walls, TRUTH, LIDAR, request.param)


def test_a_lidar_in_order_is_never_refused(log):
    watch = MountingWatch()
    for scan, base in zip(log.scans, log.odometry):
        watch.check(scan, base)


def test_a_mirrored_one_is_refused_from_the_third_turn_on(log):
    watch, refused = MountingWatch(), []
    for scan, base in zip(log.scans, log.odometry):
        try:
            watch.check(mirrored(scan), base)
            refused.append(False)
        except MountingError:
            refused.append(True)
    first = refused.index(True)
    assert all(refused[first:])
    turned_rad = np.abs(np.diff(np.unwrap(TRUTH[: first + 1, 2]))).sum()
    assert 0.75 <= turned_rad <= 4.8  # three turns of 0.25 rad are the least; the route has four corners


def test_without_a_turn_nothing_is_judged(log):
    watch = MountingWatch()
    straight = np.flatnonzero(TRUTH[:, 2] == 0.0)
    for index in straight[straight < 40]:
        watch.check(mirrored(log.scans[index]), log.odometry[index])
