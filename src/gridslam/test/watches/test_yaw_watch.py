"""Odometry whose yaw is in degrees is refused; other errors of the yaw, and fast turns, are not."""

from __future__ import annotations

import math

import numpy as np
import planar_world
import pytest

from gridslam.errors import MountingError
from gridslam.watches.yaw_watch import YawWatch

LIDAR = planar_world.Lidar(4.7, 180, 10.0, 0.01, 10.0)
ROUTE = np.array([(-8.0, -5.0), (-5.0, -5.0), (-5.0, -2.0), (-8.0, -2.0), (-8.0, -4.0)])
TRUTH = planar_world.along(ROUTE, 0.2)
PERIOD_S = 0.2


@pytest.fixture(scope="module", params=[0, 1, 2])
def walls(request):
    return planar_world.scattered_boxes(request.param, TRUTH) if request.param else planar_world.hold()


def refused(walls, truth, odometry=None, told=lambda yaw: yaw):
    """Return what is said of scans from true poses, if odometry's yaw is told so."""
    log = planar_world.drive(walls, truth, LIDAR, 1, seconds=PERIOD_S)
    watch = YawWatch()
    for scan, (x, y, yaw) in zip(log.scans, log.odometry if odometry is None else odometry):
        try:
            watch.check(scan, (x, y, math.remainder(told(yaw), 2.0 * math.pi)))
        except MountingError as error:
            return str(error)
    return ""


def on_the_spot(steps_rad):
    return np.column_stack(
        [np.full(len(steps_rad), -7.0), np.full(len(steps_rad), -5.0), np.cumsum(steps_rad)]
    )


def test_a_yaw_in_radians_is_in_order(walls):
    assert refused(walls, TRUTH) == ""


def test_a_yaw_in_degrees_is_refused(walls):
    assert "check whether it is in radians, not in degrees" in refused(walls, TRUTH, told=math.degrees)


def test_a_fast_turn_is_in_order(walls):
    assert refused(walls, on_the_spot(np.full(60, 4.0 * PERIOD_S))) == ""


def test_wheels_that_turn_a_vehicle_that_is_stuck_are_in_order(walls):
    told = on_the_spot(np.full(60, 1.8 * PERIOD_S))
    assert refused(walls, told * (1.0, 1.0, 0.0), told) == ""


def test_jumps_of_the_yaw_are_no_degrees(walls):
    jumps = np.zeros(len(TRUTH))
    jumps[30::4] = 1.0  # after the first corner
    told = TRUTH + np.cumsum(jumps)[:, None] * (0.0, 0.0, 1.0)
    assert refused(walls, TRUTH, told) == ""
