"""A levelled scan and the base in the plane, from a lidar and an odometry."""

import math

import numpy as np
import pytest

from gridslam.inputs.levelling import Levelling

LEAN_RAD = 0.2
LEANING = ((1.0, 2.0, 3.0), (math.sin(LEAN_RAD / 2), 0.0, 0.0, math.cos(LEAN_RAD / 2)))
"""Rolled to the right: the left side is up."""
LEFT_AND_RIGHT = (-math.pi / 2, math.pi)
AT_BASE = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def level(levelling, ranges):
    return levelling.level(7.0, np.array(ranges), LEFT_AND_RIGHT, (0.1, 30.0), AT_BASE, LEANING)


def test_beams_of_a_leaning_lidar_are_seen_from_above():
    scan, base = level(Levelling(floor_z_m=None), [4.0, 5.0])
    assert base == pytest.approx((1.0, 2.0, 0.0))
    assert scan.stamp_s == 7.0
    assert scan.ranges_m == pytest.approx([4.0 * math.cos(LEAN_RAD), 5.0 * math.cos(LEAN_RAD)])


def test_a_beam_at_the_floor_does_not_count():
    to_floor_m = 3.0 / math.sin(LEAN_RAD)
    scan, _ = level(Levelling(), [to_floor_m, 5.0])
    assert scan.ranges_m == pytest.approx([5.0 * math.cos(LEAN_RAD)])
    higher, _ = level(Levelling(floor_z_m=-5.0), [to_floor_m, 5.0])
    assert len(higher.ranges_m) == 2


def test_without_levelling_a_leaning_scan_counts_as_level():
    scan, _ = level(Levelling(is_on=False), [4.0, 5.0])
    assert scan.ranges_m == pytest.approx([4.0, 5.0])
