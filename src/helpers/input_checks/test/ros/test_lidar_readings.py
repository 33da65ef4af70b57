"""Scans and clouds of drivers that tell a range for nothing, and of those that do as REP-117 says."""

import math

import numpy as np
import pytest

pytest.importorskip("input_checks_ros.lidar_readings", reason="the workspace is not built, or not sourced")
from sensor_msgs.msg import LaserScan, PointCloud2, PointField

from input_checks_ros.lidar_readings import LidarReadings, times_of

BEAMS = 360


def scan(number, far, range_max=8.0, **changes):
    """The upper half meets a wall 2 m ahead, the other half nothing."""
    ranges = np.full(BEAMS, far, np.float32)
    ranges[: BEAMS // 2] = 2.0 + 0.001 * number
    message = LaserScan(range_min=0.1, range_max=range_max, ranges=ranges)
    message.header.frame_id, message.header.stamp.secs = "laser", 100 + number
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize(("far", "range_max"), [(8.0, 8.0), (8.0, 8.1)])
def test_far_values_become_inf_and_the_reach_ends_there(far, range_max):
    said = []
    given = scan(0, far, range_max)
    told = LidarReadings(said.append).scan(given)
    np.testing.assert_array_equal(told.ranges[: BEAMS // 2], given.ranges[: BEAMS // 2])
    assert np.isposinf(told.ranges[BEAMS // 2 :]).all()
    assert told.range_max == 8.0
    assert (told.header, told.range_min) == (given.header, given.range_min)
    assert given.ranges[-1] == np.float32(far)  # other subscribers have the same message
    assert len(said) == 1
    assert "range_max" in said[0]


@pytest.mark.parametrize("far", [math.inf, math.nan, 0.0, 7.0])
def test_other_scans_pass_as_they_are(far):
    readings = LidarReadings(pytest.fail)
    given = scan(0, far)
    assert readings.scan(given) is given


def test_padded_beams_tell_nothing_and_stay():
    """lidar_padding gives them range_max and the intensity -1."""
    readings = LidarReadings(pytest.fail)
    intensities = np.zeros(BEAMS, np.float32)
    intensities[BEAMS // 2 :] = -1.0
    given = scan(0, 8.0, intensities=intensities)
    assert readings.scan(given) is given
    readings = LidarReadings(lambda _: None)
    intensities[BEAMS // 2 : BEAMS * 3 // 4] = 0.0
    told = readings.scan(scan(0, 8.0, intensities=intensities)).ranges
    assert np.isposinf(told[BEAMS // 2 : BEAMS * 3 // 4]).all()
    assert (told[BEAMS * 3 // 4 :] == 8.0).all()


def test_two_lidars_have_each_their_own_far_value():
    readings = LidarReadings(lambda _: None)
    readings.scan(scan(0, 8.0))
    other = scan(1, 8.0, range_max=30.0)
    other.header.frame_id = "rear"
    assert readings.scan(other) is other


def cloud(number, far, field=None):
    """Points on a sphere of 2 m and a little, and some at the far value."""
    rng = np.random.default_rng(number)
    ways = rng.normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    ways[100:] *= far
    ways[:100] *= 2.0 + rng.normal(0.0, 0.01, (100, 1))
    kinds = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), *([] if field is None else [field])]
    rows = np.zeros(200, kinds)
    rows["x"], rows["y"], rows["z"] = ways.T
    message = PointCloud2(height=1, width=200, point_step=rows.dtype.itemsize)
    message.fields = [
        PointField(name, rows.dtype.fields[name][1], {"<f4": 7, "<u4": 6}[rows.dtype[name].str], 1)
        for name in rows.dtype.names
    ]
    if field is not None:
        rows[field[0]] = np.linspace(0, 1e8, 200)
    message.data, message.row_step = rows.tobytes(), len(rows.tobytes())
    message.header.frame_id, message.header.stamp.secs = "lidar", 100 + number
    return message


def test_points_at_a_far_value_end_nowhere_or_beyond_what_is_free():
    readings = LidarReadings(lambda _: None)
    readings.look_ahead([cloud(number, 30.0) for number in range(12)])
    points = readings.points(cloud(0, 30.0))
    assert np.isfinite(points[:100]).all()
    assert np.isnan(points[100:]).all()
    free = readings.points(cloud(1, 30.0), free_up_to_m=30.0)
    np.testing.assert_allclose(np.linalg.norm(free[100:], axis=1), 60.0, rtol=1e-6)
    assert np.isnan(readings.points(cloud(2, 30.0), free_up_to_m=40.0)[100:]).all()


def test_the_times_of_points_are_read_from_their_field():
    assert times_of(cloud(0, 30.0)) is None
    times = times_of(cloud(0, 30.0, ("t", "<u4")))
    assert (times.field, times.first_s) == ("t", 0.0)
    assert times.last_s == pytest.approx(0.1)
