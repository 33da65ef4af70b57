"""A planar lidar's scan as a cloud: its geometry, and its motion undone against a slow reference."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gridslam import ScanError
from gridslam.volume import Pose, points_of_scan

LIMITS_M = (0.1, 10.0)
ANGLES = (-1.0, 0.02)
BEAMS = 101


def test_a_scan_at_rest_lies_in_the_lidars_plane():
    points = points_of_scan([1.0, 2.0, 3.0], (0.0, math.pi / 2), LIMITS_M, -1.0)
    np.testing.assert_allclose(points, ((1, 0, 0), (0, 2, 0), (-3, 0, 0)), atol=1e-6)


def test_only_ends_within_the_lidars_range_count():
    ranges = [math.nan, -math.inf, 0.05, 4.0, 11.0, math.inf]
    assert len(points_of_scan(ranges, (0.0, 0.1), LIMITS_M, -1.0)) == 1
    with pytest.raises(ScanError, match="no beam"):
        points_of_scan(ranges[:3], (0.0, 0.1), LIMITS_M, -1.0)


def test_beams_without_return_are_free_as_far_as_lidar_and_map_reach():
    lengths = np.linalg.norm(points_of_scan([4.0, 11.0, math.inf], (0.0, 0.1), LIMITS_M, 8.0), axis=1)
    assert lengths[0] == pytest.approx(4.0)
    assert (lengths[1:] > 8.0).all()  # the map cuts them at 8 m
    assert len(points_of_scan([4.0, math.inf], (0.0, 0.1), LIMITS_M, 30.0)) == 1  # the lidar sees 10 m only


def test_a_range_that_a_message_has_rounded_down_is_the_maps_range():
    limits_m = (0.02, float(np.float32(5.6)))  # below 5.6
    assert len(points_of_scan([math.inf], (0.0, 0.1), limits_m, 5.6)) == 1


def test_motion_during_a_scan_is_undone_beam_by_beam():
    turn, way_m = np.array((0.02, 0.12, -0.05)), np.array((0.03, -0.01, 0.02))
    last = Pose(Rotation.from_rotvec(turn).as_matrix(), way_m)
    ranges = np.linspace(1.0, 9.0, BEAMS)
    found = points_of_scan(ranges, ANGLES, LIMITS_M, -1.0, last)
    for beam in range(BEAMS):
        share, along = beam / (BEAMS - 1), ANGLES[0] + ANGLES[1] * beam
        end = ranges[beam] * np.array((math.cos(along), math.sin(along), 0.0))
        np.testing.assert_allclose(
            found[beam], Rotation.from_rotvec(share * turn).apply(end) + share * way_m, atol=1e-6
        )


def test_a_lidar_that_turns_while_it_scans_still_draws_a_straight_wall():
    last = Pose(Rotation.from_rotvec((0.0, 0.1, 0.0)).as_matrix(), np.zeros(3))
    along = ANGLES[0] + ANGLES[1] * np.arange(BEAMS)
    ranges = np.empty(BEAMS)
    for beam in range(BEAMS):  # a wall at x = 3, hit by each beam from where it points then
        turned = Rotation.from_rotvec((0.0, 0.1 * beam / (BEAMS - 1), 0.0))
        ranges[beam] = 3.0 / turned.apply((math.cos(along[beam]), math.sin(along[beam]), 0.0))[0]
    found = points_of_scan(ranges, ANGLES, LIMITS_M, -1.0, last)
    np.testing.assert_allclose(found[:, 0], 3.0, atol=1e-5)
    assert np.ptp(points_of_scan(ranges, ANGLES, LIMITS_M, -1.0)[:, 0]) > 0.01  # it would be bent


def test_a_scan_that_makes_no_sense_is_refused():
    with pytest.raises(ScanError, match="0 beams"):
        points_of_scan([], ANGLES, LIMITS_M, -1.0)
    with pytest.raises(ScanError, match="min < max"):
        points_of_scan([1.0], ANGLES, (2.0, 1.0), -1.0)
    with pytest.raises(ScanError, match="not finite"):
        points_of_scan([1.0], (math.nan, 0.1), LIMITS_M, -1.0)


def test_without_a_greatest_range_beams_without_return_are_free_as_far_as_the_map_reaches():
    limits_m = (0.1, math.inf)  # as pointcloud_to_laserscan publishes
    assert len(points_of_scan([4.0, math.inf], (0.0, 0.1), limits_m, -1.0)) == 1
    lengths = np.linalg.norm(points_of_scan([4.0, math.inf], (0.0, 0.1), limits_m, 8.0), axis=1)
    assert np.isfinite(lengths).all()
    assert lengths[1] > 8.0
