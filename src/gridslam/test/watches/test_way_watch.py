"""A lidar that is turned untold, or a wrong metre, is found by the first ways; what is in order never is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import planar_world
import pytest

from gridslam.errors import MountingError
from gridslam.evaluation import Walls
from gridslam.watches.way_watch import WayWatch

LIDAR = planar_world.Lidar(4.7, 180, 10.0, 0.01, 10.0)
ROUTE = np.array([(-8.0, -5.0), (0.0, -5.0), (0.0, 3.0), (-6.0, 3.0)])
TRUTH = planar_world.along(ROUTE, 0.2)
CORRIDOR = Walls(np.array([(-50.0, -1.0, 50.0, -1.0), (-50.0, 1.0, 50.0, 1.0)]))


@pytest.fixture(scope="module", params=[0, 1, 2])
def log(request):
    walls = planar_world.scattered_boxes(request.param, TRUTH) if request.param else planar_world.hold()
    return planar_world.drive(walls, TRUTH, LIDAR, request.param)


def refused_at(log, turned_rad):
    """Return the number of the scan at which a lidar is refused that TF tells turned so, and the sentence."""
    watch = WayWatch()
    for number, (scan, base) in enumerate(zip(log.scans, log.odometry)):
        x, y, yaw = scan.lidar_in_base
        try:
            watch.check(replace(scan, lidar_in_base=(x, y, yaw + turned_rad)), base)
        except MountingError as error:
            return number, str(error)
    return None, ""


@pytest.mark.table("turned_deg", [0.0, 10.0, -10.0])
def test_a_lidar_in_order_is_never_refused(log, turned_deg):
    assert refused_at(log, math.radians(turned_deg)) == (None, "")


@pytest.mark.table("turned_deg", [45.0, -90.0, 180.0])
def test_a_turned_one_is_refused_from_the_fifth_way_on(log, turned_deg):
    number, sentence = refused_at(log, math.radians(turned_deg))
    way_m = float(np.hypot(*np.diff(TRUTH[: number + 1, :2], axis=0).T).sum())
    assert 5 * 0.5 <= way_m <= 8.0
    told_deg = [int(word) for word in sentence.split() if word.isdigit()]
    assert told_deg == pytest.approx([abs(turned_deg)] * 2, abs=3.0)
    if turned_deg != 180.0:  # left and right are one there
        assert ("to the left" in sentence) == ("less" in sentence) == (turned_deg > 0.0)


def test_a_bare_corridor_tells_nothing_about_the_way_along_it():
    route = planar_world.along(np.array([(-8.0, 0.0), (8.0, 0.0)]), 0.2)
    log = planar_world.drive(CORRIDOR, route, LIDAR, 1)
    assert refused_at(log, math.pi) == (None, "")


@pytest.mark.table("told", [0.5, 2.0])
@pytest.mark.table("seed", [1, 2])  # in the hold all beams of the deck look alike: it tells nothing
def test_a_wrong_metre_is_refused(seed, told):
    log = planar_world.drive(planar_world.scattered_boxes(seed, TRUTH), TRUTH, LIDAR, seed)
    number, sentence = refused_at(replace(log, odometry=log.odometry * (told, told, 1.0)), 0.0)
    assert number is not None
    assert float(sentence.split(" times as far")[0].split()[-1]) == pytest.approx(1.0 / told, rel=0.03)


@pytest.mark.table("told", [0.75, 1.3])
def test_wheels_that_slip_by_a_quarter_are_not_refused(log, told):
    assert refused_at(replace(log, odometry=log.odometry * (told, told, 1.0)), 0.0) == (None, "")


def test_once_ways_were_in_order_the_watch_has_ended(log):
    watch, straight = WayWatch(), 20
    for scan, base in zip(log.scans[:straight], log.odometry):
        watch.check(scan, base)
    for scan, base in zip(log.scans[straight:], log.odometry[straight:]):
        watch.check(replace(scan, lidar_in_base=(0.0, 0.0, math.pi)), base)
