"""What range finders see is added to the clouds that they belong to."""

import numpy as np
import pytest

from gridslam.volume import Pose, RangePoints

UP = Pose(np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), np.array([0.1, 0.0, 0.05]))
"""Looks along z of the cloud's frame."""
CLOUD = np.array([[1.0, 2.0, 3.0]], np.float32)


def added(stamp_s, pose=UP, range_m=2.0):
    ranges = RangePoints()
    ranges.take("up", 10.0, range_m, 0.1, 40.0)
    return ranges.added_to(CLOUD, stamp_s, lambda name: pose if name == "up" else None)


def test_a_fresh_range_is_a_point_where_its_beam_ended():
    np.testing.assert_allclose(added(10.05), [[1.0, 2.0, 3.0], [0.1, 0.0, 2.05]], atol=1e-6)


@pytest.mark.table("stamp_s", [9.8, 10.2])
def test_an_old_range_does_not_count(stamp_s):
    np.testing.assert_array_equal(added(stamp_s), CLOUD)


@pytest.mark.table("range_m", [np.inf, -np.inf, np.nan, 0.05, 41.0])
def test_a_range_that_tells_no_distance_does_not_count(range_m):
    np.testing.assert_array_equal(added(10.0, range_m=range_m), CLOUD)


def test_a_range_finder_whose_place_is_not_known_does_not_count():
    np.testing.assert_array_equal(added(10.0, pose=None), CLOUD)


def test_a_range_that_ends_takes_the_one_before_away():
    ranges = RangePoints()
    ranges.take("up", 10.0, 2.0, 0.1, 40.0)
    ranges.take("up", 10.05, np.inf, 0.1, 40.0)
    np.testing.assert_array_equal(ranges.added_to(CLOUD, 10.05, lambda _: UP), CLOUD)
