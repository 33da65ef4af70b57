"""The level part of a leaning lidar's scan, against a box room in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_basics.errors import ScanError
from inspection_tools import LevelBeamsParameters, LevelFrame, ScanGeometry
from inspection_tools.level_beams import is_whole, level_part

GEOMETRY = ScanGeometry(1081, -0.75 * math.pi, math.radians(0.25))
ANGLES = GEOMETRY.angle_min_rad + GEOMETRY.angle_increment_rad * np.arange(GEOMETRY.beams)
LIMITS_M = (0.06, 10.0)
HALF_M = np.array((4.0, 3.0, 1.5))
"""Of a room around the lidar's level frame."""
ASKED = LevelBeamsParameters()
ANGLE = st.floats(-0.8, 0.8)


def rotation_of(roll, pitch, yaw=0.0):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    about_x = np.array(((1, 0, 0), (0, cr, -sr), (0, sr, cr)))
    about_y = np.array(((cp, 0, sp), (0, 1, 0), (-sp, 0, cp)))
    return np.array(((cy, -sy, 0), (sy, cy, 0), (0, 0, 1))) @ about_y @ about_x


def in_a_room(rotation, place=(0.0, 0.0, 0.0)):
    """Ranges of a lidar at a place in the room."""
    directions = rotation[:, :2] @ np.stack((np.cos(ANGLES), np.sin(ANGLES)))
    with np.errstate(divide="ignore", over="ignore"):
        ways = (np.copysign(HALF_M[:, None], directions) - np.reshape(place, (3, 1))) / directions
    return ways.min(axis=0)


def walls_at(azimuths):
    """Horizontal distance from the middle to the walls."""
    with np.errstate(divide="ignore"):
        return np.minimum(HALF_M[0] / np.abs(np.cos(azimuths)), HALF_M[1] / np.abs(np.sin(azimuths)))


def level(ranges, rotation, place=(0.0, 0.0, 0.0), asked=ASKED):
    return level_part(ranges, GEOMETRY, LIMITS_M, rotation, np.array(place), asked)


def test_the_scan_of_a_level_lidar_passes_unchanged():
    ranges = np.array(in_a_room(np.eye(3)), np.float32)
    ranges[:4] = (np.inf, -np.inf, np.nan, 11.0)
    np.testing.assert_array_equal(level(ranges, np.eye(3)), ranges)


@given(ANGLE, ANGLE)
def test_whatever_is_kept_is_a_wall_at_its_true_horizontal_distance(roll, pitch):
    rotation, place = rotation_of(roll, pitch), np.array((0.02, -0.01, 0.03))
    found = level(in_a_room(rotation, place), rotation, place)
    kept = np.isfinite(found)
    assert not np.isinf(found).any()
    # A beam's azimuth is rounded to the grid by half a step, and an oblique wall turns that into distance
    slack_m = np.abs(walls_at(ANGLES + 0.0022) - walls_at(ANGLES - 0.0022)) + 1e-3
    assert (np.abs(found - walls_at(ANGLES)) <= slack_m)[kept].all()


def test_a_steep_lidar_tells_nothing_ahead_but_all_beside_it():
    found = level(in_a_room(rotation_of(0.0, 0.6)), rotation_of(0.0, 0.6))
    ahead = np.abs(ANGLES) < 1.2
    assert np.isnan(found[ahead]).all()  # floor and high walls are neither obstacles nor free
    beside = np.abs(np.abs(ANGLES) - math.pi / 2) < 0.03
    np.testing.assert_allclose(found[beside], HALF_M[1], atol=0.03)


def test_a_near_obstacle_is_seen_by_a_steep_lidar():
    ranges = np.full(1081, 9.0, np.float32)
    ranges[540] = 0.5  # 0.28 m below the lidar, when it looks down by 0.6 rad
    rotation = rotation_of(0.0, 0.6)
    assert np.isnan(level(ranges, rotation)[540])
    found = level(ranges, rotation, asked=LevelBeamsParameters(height=0.3))
    assert found[540] == pytest.approx(0.5 * math.cos(0.6))


def test_too_close_is_kept_and_no_return_only_where_the_beam_is_flat():
    ranges = np.full(1081, np.inf, np.float32)
    ranges[540] = -np.inf
    found = level(ranges, rotation_of(0.0, 0.5))
    assert found[540] == -np.inf
    is_free = np.isposinf(found)
    # |sin elevation| = sin 0.5 |cos azimuth of the beam|, at most sin 0.035
    widest = math.pi / 2 - math.asin(math.sin(0.035) / math.sin(0.5))
    beside = np.abs(np.abs(ANGLES) - math.pi / 2)
    assert is_free[beside < math.pi / 2 - widest - 0.02].mean() > 0.8
    assert not is_free[np.abs(ANGLES) < widest - 0.02].any()


def test_a_scan_is_whole_while_the_lidar_leans_less_than_the_slope():
    assert is_whole(rotation_of(0.02, 0.02, 0.5), ASKED)
    assert not is_whole(rotation_of(0.03, 0.03), ASKED)
    assert not is_whole(rotation_of(0.0, -0.04), ASKED)


def test_the_frame_has_the_lidars_place_and_heading_and_no_lean():
    half = 0.35
    frame = LevelFrame.below((0.1, 0.0, 0.2), (0.0, math.sin(half), 0.0, math.cos(half)))  # 0.7 rad down
    assert frame.yaw_rad == pytest.approx(0.0)
    rotation, place = frame.pose_of((0.13, 0.0, 0.2), (0.0, math.sin(half), 0.0, math.cos(half)))
    np.testing.assert_allclose(rotation, rotation_of(0.0, 0.7), atol=1e-12)
    np.testing.assert_allclose(place, (0.03, 0.0, 0.0), atol=1e-12)


def test_a_lidar_upside_down_is_refused():
    with pytest.raises(ScanError, match="upright"):
        LevelFrame.below((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def test_a_scan_of_another_length_and_wrong_limits_are_refused():
    with pytest.raises(ScanError, match="1081 beams"):
        level(np.ones(10), np.eye(3))
    with pytest.raises(ScanError, match="range_min"):
        level_part(np.ones(1081), GEOMETRY, (2.0, 1.0), np.eye(3), np.zeros(3), ASKED)
