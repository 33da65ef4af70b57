"""Padded scans as messages: what is unseen becomes an intensity only here."""

import math

import numpy as np
import pytest

from flight_basics.errors import ScanError
from inspection_tools import LidarPadding, ScanGeometry

conversions = pytest.importorskip("inspection_tools_ros.conversions", reason="needs ROS")


def test_an_unseen_beam_has_the_intensity_minus_one():
    padded = LidarPadding().pad(np.ones(3), ScanGeometry(3, -math.pi / 4, math.pi / 4), 0.1, 10.0)
    #            -180 -135 -90 -45 0 45 90 135
    with_source = [-1, -1, -1, 7, 8, 9, -1, -1]
    np.testing.assert_array_equal(conversions.intensities_of(padded, [7.0, 8.0, 9.0]), with_source)
    without = conversions.intensities_of(padded)
    np.testing.assert_array_equal(without, [-1, -1, -1, 0, 0, 0, -1, -1])
    assert without.dtype == np.float32


def test_padding_a_padded_scan_keeps_its_intensities():
    padding, geometry = LidarPadding(), ScanGeometry(1081, -0.75 * math.pi, math.radians(0.25))
    once = padding.pad(np.ones(1081, np.float32), geometry, 0.1, 10.0)
    twice = padding.pad(once.ranges, once.geometry, 0.1, 10.0)
    known = conversions.intensities_of(once)
    assert (known == conversions.UNSEEN_INTENSITY).sum() == 1440 - 1081
    np.testing.assert_array_equal(conversions.intensities_of(twice, known), known)


def test_intensities_beyond_a_turn_are_left_out():
    ranges = np.array([2, 5, 6, 7, 8, 3], np.float32)  # 5 beams a turn, and the first again
    padded = LidarPadding().pad(ranges, ScanGeometry(6, -math.pi, 2.0 * math.pi / 5), 0.1, 10.0)
    np.testing.assert_array_equal(conversions.intensities_of(padded, np.arange(6)), np.arange(5))


CASES = [  # angle_min, angle_max, increment, ranges, whether they agree
    (-1.5708, 1.5708, 0.0175, math.ceil(3.1416 / 0.0175), True),  # pointcloud_to_laserscan: 179.52 steps
    (-1.0, 1.0, 0.0101, math.ceil(2.0 / 0.0101), True),  # 198.02 steps
    (-1.0, 1.0, 0.0101, math.floor(2.0 / 0.0101), True),
    (-1.0, 1.0, 0.01, 200, True),  # 200 steps, and no last beam
    (-1.0, 1.0, 0.01, 201, True),
    (1.0, -1.0, -0.0175, math.ceil(2.0 / 0.0175), True),  # 114.29 steps, clockwise
    (-1.0, 1.0, 0.01, 199, False),
    (-1.0, 1.0, 0.01, 202, False),
    (-math.pi, math.pi, 0.007, 897, True),  # velodyne_laserscan: 897.6 steps
]


@pytest.mark.parametrize(("first", "last", "step", "ranges", "agree"), CASES)
def test_the_last_beam_may_lie_before_angle_max(first, last, step, ranges, agree):
    from sensor_msgs.msg import LaserScan

    angles = np.array((first, last, step), np.float32).tolist()  # as a message carries them
    scan = LaserScan(range_max=10.0, ranges=[1.0] * ranges)
    scan.angle_min, scan.angle_max, scan.angle_increment = angles
    if agree:
        assert conversions.scan_geometry(scan).beams == ranges
        return
    with pytest.raises(ScanError, match="check the driver"):
        conversions.scan_geometry(scan)
