"""Scans that no lidar measures: one range on all beams, and one scan again and again on the way."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import planar_world
import pytest

from gridslam import ScanError
from gridslam.evaluation import Walls
from gridslam.inputs.levelling import Levelling
from gridslam.inputs.scan_watch import ScanWatch
from gridslam.parameters import SlamParameters
from gridslam.session import SlamSession

LIDAR = planar_world.Lidar(math.tau, 360, 8.0, 0.0, 10.0)
AT_BASE = ((0.1, 0.0, 0.2), (0.0, 0.0, 0.0, 1.0))
ROOM = Walls.from_polygons([np.array([(-4.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-4.0, 3.0)])])
CORRIDOR = Walls.from_polygons([np.array([(-60.0, -1.0), (60.0, -1.0), (60.0, 1.0), (-60.0, 1.0)])])
"""So long that the lidar never sees its ends: without noise all scans along it are the same."""


def watched(watch, ranges, pose, stamp_s=0.0):
    """Give a watch a scan of `LIDAR`, on a level base at x, y, yaw; return it levelled."""
    x, y, yaw = pose
    base = ((x, y, 1.0), (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))
    angles = float(LIDAR.angles_rad[0]), float(np.diff(LIDAR.angles_rad)[0])
    scan, base_in_odom = Levelling().level(stamp_s, ranges, angles, (0.05, LIDAR.range_m), AT_BASE, base)
    watch.check(ranges, scan, base_in_odom)
    return scan, base_in_odom


def seen(walls, pose):
    return planar_world.scan_at(walls, pose, LIDAR, np.random.default_rng(0)).ranges_m


@pytest.mark.table("others", [2.0, np.inf, np.nan, 60.0])
def test_one_range_on_all_beams_is_refused_and_so_if_some_beams_have_no_return(others):
    ranges = np.full(360, 2.0)
    ranges[100:140] = others
    with pytest.raises(ScanError, match="tell the same range, 2 m, as no room does"):
        watched(ScanWatch(), ranges, (0.0, 0.0, 0.0))


@pytest.mark.table("returns", [0, 5])
def test_scans_of_hardly_a_return_are_none_of_these(returns):
    ranges = np.full(360, np.inf)
    ranges[:returns] = 2.0
    for x in (0.0, 1.0, 2.0):
        watched(ScanWatch(), ranges, (x, 0.0, 0.0))


@pytest.mark.table("step", [(0.05, 0.0, 0.0), (0.0, 0.05, 0.0), (0.0, 0.0, 0.04), (0.03, 0.02, 0.01)])
def test_a_scan_that_comes_again_and_again_is_refused_once_the_odometry_has_moved(step):
    watch, ranges = ScanWatch(), seen(ROOM, (0.5, 0.2, 0.3))
    for number in range(3):
        watched(watch, ranges, number * np.array(step))
    for number in range(3, 40):  # it may take up to 0.8 m, in a direction in which the room is long
        with contextlib.suppress(ScanError):
            watched(watch, ranges, number * np.array(step))
    with pytest.raises(ScanError, match="comes again, equal in every beam, though odometry has moved by"):
        watched(watch, ranges, 40 * np.array(step))
    watched(watch, seen(ROOM, (0.5, 0.2, 0.4)), 60 * np.array(step))  # and the lidar measures again


def test_equal_scans_where_the_world_looks_alike_are_none_of_these():
    watch = ScanWatch()
    for x in np.arange(0.0, 20.0, 0.1):
        watched(watch, seen(CORRIDOR, (0.0, 0.0, 0.0)), (x, 0.0, 0.0))
    watch, ranges = ScanWatch(), seen(ROOM, (0.5, 0.2, 0.3))
    for _ in range(50):
        watched(watch, ranges, (1.0, 2.0, 0.3))  # at rest
    watched(watch, ranges, (6.0, 2.0, 0.3))  # odometry has jumped, and the vehicle is at rest
    watched(watch, ranges, (6.0, 2.0, 0.3))


def test_constant_scans_at_the_start_do_not_turn_the_heading():
    """Given a lidar that sends 3 m on all beams while the UAV turns by 1 rad, when it then measures..."""
    session, watch, errors = SlamSession(SlamParameters(particles=5), False), ScanWatch(), 0
    for number in range(40):
        pose = (0.02 * number, 0.0, min(0.05 * number, 1.0))
        ranges = (
            np.full(360, 3.0)
            if number < 20
            else seen(ROOM, np.add(pose, (0.1 * math.cos(pose[2]), 0.1 * math.sin(pose[2]), 0.0)))
        )
        try:
            session.process(*watched(watch, ranges, pose, 0.1 * number))
        except ScanError:
            errors += 1
    assert errors == 20
    assert session.slam.base_in_map == pytest.approx((0.78, 0.0, 1.0), abs=0.03)
