"""SLAM's drift between closed loops."""

import math

import numpy as np
import pytest

from exploration.planning import PathPlanner
from flights.exploring.drift import Drift
from flights.exploring.volume_of_flight import VolumeOfFlight
from gridslam.volume import VolumeParameters

OFFSETS = np.array(((0.4, 0.0, 0.1), (0.0, -0.2, 0.0)))


def test_it_grows_evenly_and_each_closed_loop_takes_it_back():
    drift = Drift((10.0, 14.0), OFFSETS)
    for stamp_s, x, y, yaw in (
        (5.0, 0.2, 0.0, 0.05),
        (9.999, 0.4, 0.0, 0.1),
        (10.0, 0.0, 0.0, 0.0),
        (13.0, 0.0, -0.15, 0.0),
        (20.0, 0.0, 0.0, 0.0),
    ):
        odom = drift.odom_in_map(stamp_s)
        np.testing.assert_allclose(odom.translation, (x, y, 0.0), atol=1e-3)
        assert math.atan2(odom.rotation[1, 0], odom.rotation[0, 0]) == pytest.approx(yaw, abs=1e-3)
    assert [drift.closed_until(stamp_s) for stamp_s in (9.9, 10.0, 14.0)] == [0, 1, 2]


def test_what_is_drawn_stays_within_its_bounds():
    drift = Drift.drawn(np.random.default_rng(3), (6.0, 15.0), 0.4, 0.03, 300.0)
    between_s = np.diff((0.0, *drift.closed_s))
    assert between_s.min() >= 6.0
    assert between_s.max() <= 15.0
    assert drift.closed_s[-1] < 300.0
    assert np.linalg.norm(drift.offsets[:, :2], axis=1).max() <= 0.4
    assert np.abs(drift.offsets[:, 2]).max() <= 0.03


def test_offsets_that_belong_to_other_loops_are_refused():
    with pytest.raises(ValueError, match="2 closed loops need as many offsets"):
        Drift((1.0, 2.0), np.zeros((3, 3)))


def test_a_closed_loop_moves_the_clouds_to_where_odometry_told_them():
    # Given a wall 3 m ahead, mapped with a drift of 0.6 m
    drift = Drift((2.0,), np.array(((0.6, 0.0, 0.0),)))
    volume = VolumeOfFlight(PathPlanner(), VolumeParameters(0.2))
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(-1.0, 1.0, 0.05), np.arange(-1.0, 1.0, 0.05)))
    wall = np.stack((np.full(len(y), 3.05), y, z), axis=1).astype(np.float32)
    lidar = drift.odom_in_map(9.0)
    volume.add(1.99, wall, lidar, drift.odom_in_map(1.99))
    volume.tell_planner()
    assert nearest_m(volume) == pytest.approx(3.65, abs=0.15)
    # When the loop is closed, then map and planner have the wall where it is
    volume.close_loop()
    volume.tell_planner()
    assert nearest_m(volume) == pytest.approx(3.05, abs=0.15)


def nearest_m(volume):
    """Return the distance of the wall in what is shown."""
    return float(np.median(volume.shown.centres(2)[:, 0]))
