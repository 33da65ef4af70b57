"""Odometry whose position, or yaw, never changes is found where the scans tell that this is wrong."""

from __future__ import annotations

import numpy as np
import planar_world
import pytest

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.watches.still_part import StillPart

LIDAR = planar_world.Lidar(4.7, 180, 10.0, 0.01, 10.0)
ROUTE = np.array([(-8.0, -5.0), (0.0, -5.0), (0.0, 3.0), (-6.0, 3.0)])
TRUTH = planar_world.along(ROUTE, 0.2)
CORRIDOR = Walls(np.array([(-50.0, -1.0, 50.0, -1.0), (-50.0, 1.0, 50.0, 1.0)]))
NO_YAW, NO_WAY = np.array((1.0, 1.0, 0.0)), np.array((0.0, 0.0, 1.0))


@pytest.fixture(scope="module", params=[0, 1, 2])
def walls(request):
    return planar_world.scattered_boxes(request.param, TRUTH) if request.param else planar_world.hold()


def judged(scans, odometry):
    part = StillPart()
    for scan, base in zip(scans, odometry):
        part.add(scan, base)
    return part


def test_a_part_that_is_the_same_is_wrong_where_scans_turn_and_move(walls):
    log = planar_world.drive(walls, TRUTH, LIDAR, 1)
    assert not judged(log.scans, log.odometry).is_wrong
    same_yaw, same_position = (judged(log.scans, log.odometry * kept) for kept in (NO_YAW, NO_WAY))
    assert same_yaw.is_wrong
    assert same_yaw.has_moved
    assert same_position.is_wrong
    assert same_position.has_turned
    assert not judged(log.scans, log.odometry * 0.0).is_wrong  # both: others tell that


def test_a_vehicle_that_never_turns_is_in_order(walls):
    # given one that moves to all sides, and looks ahead
    truth = TRUTH * NO_YAW
    part = judged(planar_world.drive(walls, truth, LIDAR, 1).scans, truth)
    assert part.has_moved
    assert not part.has_turned
    assert not part.is_wrong


@pytest.mark.table("beside_m", [0.0, 0.3])
def test_a_lidar_that_turns_on_the_spot_is_in_order(walls, beside_m):
    # given one that stands beside the axis, and TF does not tell
    base = np.column_stack([np.full(60, -4.0), np.full(60, -5.0), 0.15 * np.arange(60.0)])
    lidar = se2.compose(base, np.array((beside_m, 0.0, 0.0)))
    part = judged(planar_world.drive(walls, lidar, LIDAR, 1).scans, base)
    assert part.has_turned
    assert not part.has_moved
    assert not part.is_wrong


@pytest.mark.table("kept", [NO_YAW, NO_WAY])
def test_a_bare_corridor_tells_nothing(kept):
    route = planar_world.along(np.array([(-8.0, 0.0), (8.0, 0.0)]), 0.2)
    log = planar_world.drive(CORRIDOR, route, LIDAR, 1)
    assert not judged(log.scans, log.odometry * kept).is_wrong


@pytest.mark.table("drifts", [NO_YAW, NO_WAY])
def test_people_before_a_vehicle_that_stands_are_no_way(walls, drifts):
    # given odometry that drifts in one part, and eight people who walk to and fro, 1.5 to 3.5 m from it
    rng, pose = np.random.default_rng(3), np.array((-4.0, -5.0, 0.0))
    ways, began = rng.uniform((1.5, 0.0), (3.5, 6.28), (8, 2)), rng.uniform(0.0, 6.28, 8)
    scans = []
    for stamp_s in 0.25 * np.arange(120.0):
        bearings = ways[:, 1] + 0.8 * np.sin(0.6 * stamp_s + began)
        people = pose[:2] + ways[:, :1] * np.column_stack([np.cos(bearings), np.sin(bearings)])
        ends_m = np.concatenate([walls.ends_m, *(square(middle) for middle in people)])
        scans.append(planar_world.scan_at(Walls(ends_m), pose, LIDAR, rng, stamp_s))
    part = judged(scans, pose + 0.001 * np.arange(120.0)[:, None] * drifts)
    assert part.has_moved != part.has_turned
    assert not part.is_wrong


def square(middle_xy, half_m=0.2):
    corners = middle_xy + half_m * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return np.column_stack([corners, np.roll(corners, 1, axis=0)])
