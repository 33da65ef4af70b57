"""Padded scans as messages: what is unseen becomes an intensity only here."""

import math

import numpy as np
import pytest

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
