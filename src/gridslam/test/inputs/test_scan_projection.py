"""What a leaning, inclined or inverted lidar measures of a wall comes out as that wall; the floor goes."""

import dataclasses
import math

import numpy as np
import planar_world
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gridslam import ScanError, se2
from gridslam.evaluation import Walls
from gridslam.inputs.attitude import matrix_of_lean, matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.inputs.scan_projection import project

UPRIGHT = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
FOV = {"angle_min_rad": -2.0, "angle_increment_rad": 0.01, "range_min_m": 0.1, "range_max_m": 100.0}
angles = st.floats(-0.3, 0.3)
headings = st.floats(-3.1, 3.1)
offsets = st.tuples(*[st.floats(-0.3, 0.3)] * 3)


def ends_in_base(scan):
    x, y, yaw = scan.lidar_in_base
    bearings = scan.angles_rad + yaw
    return np.stack((x + scan.ranges_m * np.cos(bearings), y + scan.ranges_m * np.sin(bearings)), axis=1)


def turn(axis, angle_rad):
    """Rodrigues' formula, written out: the slow way to a rotation."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle_rad) * cross + (1 - math.cos(angle_rad)) * cross @ cross


def pose_matrix(rotation, translation_xyz):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation_xyz
    return matrix


def mounting_of(heading, roll, pitch, offset, inverted=False):
    rotation = turn((0, 0, 1), heading) @ turn((0, 1, 0), pitch) @ turn((1, 0, 0), roll + math.pi * inverted)
    return pose_matrix(rotation, offset)


def beams(count, mounting, lean, angle_min_rad=-2.0, angle_increment_rad=0.01):
    """(origin (3,), directions (n, 3)) in the levelled base frame, beam by beam."""
    rotation = lean @ mounting[:3, :3]
    angles_rad = [angle_min_rad + index * angle_increment_rad for index in range(count)]
    directions = [rotation @ (math.cos(angle), math.sin(angle), 0.0) for angle in angles_rad]
    return lean @ mounting[:3, 3], np.array(directions)


def test_upright_in_the_middle_and_level_it_is_the_scan_itself():
    ranges = np.linspace(1.0, 5.0, 401)
    scan = project(ranges, lidar_in_base=UPRIGHT, stamp_s=7.5, **FOV)
    np.testing.assert_allclose(scan.ranges_m, ranges, rtol=1e-12)
    np.testing.assert_allclose(scan.angles_rad, -2.0 + 0.01 * np.arange(401), atol=1e-12)
    assert (scan.lidar_in_base, scan.stamp_s, scan.range_max_m) == ((0.0, 0.0, 0.0), 7.5, 100.0)


def test_upside_down_left_is_right():
    upside_down = ((0.1, 0.2, -0.05), (1.0, 0.0, 0.0, 0.0))
    scan = project(np.full(401, 3.0), lidar_in_base=upside_down, **FOV)
    np.testing.assert_allclose(scan.angles_rad, 2.0 - 0.01 * np.arange(401), atol=1e-12)
    np.testing.assert_allclose(scan.lidar_in_base, (0.1, 0.2, 0.0), atol=1e-12)


def test_a_lidar_that_looks_back_keeps_its_beams_and_says_so_in_its_pose():
    backwards = ((-0.2, 0.0, 0.1), (0.0, 0.0, 1.0, 0.0))
    scan = project([2.0], 0.0, 0.01, 0.1, 10.0, backwards)
    np.testing.assert_allclose(scan.angles_rad, [0.0], atol=1e-12)
    np.testing.assert_allclose(ends_in_base(scan), [(-2.2, 0.0)], atol=1e-12)


def test_leaning_forward_shortens_the_beam_ahead_by_the_cosine():
    scan = project([2.0], 0.0, 0.01, 0.1, 10.0, UPRIGHT, attitude_rad=(0.0, 0.25))
    np.testing.assert_allclose(scan.ranges_m, [2.0 * math.cos(0.25)])


@given(headings, angles, angles, angles, angles, offsets, st.booleans())
def test_an_upright_wall_stays_where_it_is(heading, roll, pitch, uav_roll, uav_pitch, offset, inverted):
    # Given a wall at x = 4 m of the levelled base frame, and what each beam measures of it
    mounting = mounting_of(heading, roll, pitch, offset, inverted)
    origin, directions = beams(401, mounting, matrix_of_lean(uav_roll, uav_pitch))
    with np.errstate(divide="ignore"):
        ranges = (4.0 - origin[0]) / directions[:, 0]
    ranges[(ranges < 0.0) | (ranges > 100.0)] = np.inf
    # When the scan is projected
    scan = project(ranges, lidar_in_base=mounting, attitude_rad=(uav_roll, uav_pitch), **FOV)
    # Then every beam that is not too steep ends at the wall, where the slow way has it
    level = np.abs(directions[:, 2]) < math.sin(math.radians(45.0))
    np.testing.assert_array_equal(np.isfinite(scan.ranges_m), np.isfinite(ranges[level]))
    hits = level & np.isfinite(ranges)
    expected = origin[:2] + ranges[hits, None] * directions[hits, :2]
    ends = ends_in_base(scan)[np.isfinite(scan.ranges_m)]
    np.testing.assert_allclose(ends, expected, atol=1e-9)
    np.testing.assert_allclose(ends[:, 0], 4.0, atol=1e-9)


@given(angles, angles, offsets, st.floats(0.5, 30.0))
def test_the_floor_is_dropped_and_the_wall_above_it_is_not(uav_roll, uav_pitch, offset, height_m):
    # Given a flat floor below the UAV, and a wall 3 m to each side seen by the beams above the floor
    mounting = pose_matrix(np.eye(3), offset)
    origin, directions = beams(401, mounting, matrix_of_lean(uav_roll, uav_pitch))
    lidar_height_m = height_m + origin[2]
    with np.errstate(divide="ignore", over="ignore"):
        to_floor = np.where(directions[:, 2] < 0.0, -lidar_height_m / directions[:, 2], np.inf)
    to_wall = 3.0 / np.hypot(directions[:, 0], directions[:, 1])
    attitude = {"lidar_in_base": mounting, "attitude_rad": (uav_roll, uav_pitch), "height_m": height_m}
    # When a beam ends at whatever comes first
    first = np.minimum(to_floor, to_wall)
    end_heights_m = lidar_height_m + first * directions[:, 2]
    scan = project(np.append(first, np.inf), **attitude, **FOV)
    # Then exactly those that end at the floor, or just above it, are missing
    clearances_m = end_heights_m - min(0.15, lidar_height_m / 2.0)
    assume(np.abs(clearances_m).min() > 1e-6)
    expected = np.arctan2(directions[:, 1], directions[:, 0])[clearances_m > 0.0]
    np.testing.assert_allclose(scan.angles_rad[:-1] + scan.lidar_in_base[2], expected, atol=1e-9)


def test_without_a_height_no_beam_is_dropped_for_the_floor():
    ranges = np.full(401, 50.0)
    scan = project(ranges, lidar_in_base=UPRIGHT, attitude_rad=(0.0, 0.3), **FOV)
    assert scan.ranges_m.size == 401


def test_a_lidar_on_the_floor_sees_no_floor():
    ranges = np.full(401, 50.0)
    scan = project(ranges, lidar_in_base=UPRIGHT, attitude_rad=(0.0, 0.01), height_m=0.0, **FOV)
    assert scan.ranges_m.size == 401


def test_a_lidar_that_leans_at_rest_sees_the_floor_as_well():
    inclined = pose_matrix(turn((0, 1, 0), 0.2), (0.0, 0.0, 0.1))
    measured = 0.5 / math.sin(0.2)
    scan = project([measured, 1.0], 0.0, 1e-9, 0.1, 10.0, inclined, height_m=0.4)
    np.testing.assert_allclose(scan.ranges_m, [math.cos(0.2)])


def test_ranges_mean_what_rep_117_says():
    ranges = [1.0, np.inf, -np.inf, np.nan, 0.05, 0.1, 0.0, -1.0, 10.0, 10.5]
    scan = project(ranges, 0.0, 0.1, 0.1, 10.0, UPRIGHT)
    np.testing.assert_allclose(scan.ranges_m, [1.0, np.inf, 0.1, 10.0, np.inf])
    np.testing.assert_allclose(scan.angles_rad, [0.0, 0.1, 0.5, 0.8, 0.9], atol=1e-12)


@pytest.mark.table("count", [20, 180, 1081, 10_000])
def test_an_increment_of_the_other_sign_is_the_scan_in_the_other_order(count):
    ranges = np.linspace(1.0, 9.0, count)
    increment = 2.0 * math.pi / count
    one = project(ranges, -3.0, increment, 0.1, 10.0, UPRIGHT, attitude_rad=(0.1, -0.2))
    last = -3.0 + (count - 1) * increment
    other = project(ranges[::-1], last, -increment, 0.1, 10.0, UPRIGHT, attitude_rad=(0.1, -0.2))
    assert one.ranges_m.size == count
    np.testing.assert_allclose(ends_in_base(other)[::-1], ends_in_base(one), atol=1e-9)


@pytest.mark.table(
    ("change", "words"),
    [
        ({"ranges_m": []}, "row of numbers"),
        ({"ranges_m": [[1.0, 2.0]]}, "row of numbers"),
        ({"ranges_m": [np.nan, -np.inf]}, "No beam"),
        ({"angle_min_rad": np.nan}, "finite"),
        ({"angle_increment_rad": 0.0}, "angle_increment"),
        ({"range_max_m": 0.1}, "range_max"),
        ({"range_max_m": np.nan}, "range_max"),
        ({"range_max_m": np.inf, "ranges_m": [np.inf, np.nan, 0.05]}, "No beam of the scan has a return"),
        ({"lidar_in_base": ((0, 0, 0), (0, 0, 0, 0.5))}, "norm"),
        ({"lidar_in_base": ((0, 0, 0), (0, 0, 0, np.nan))}, "norm"),
        ({"lidar_in_base": ((0, 0, np.inf), (0, 0, 0, 1))}, "three finite"),
        ({"lidar_in_base": np.eye(3)}, "4 x 4"),
        ({"lidar_in_base": np.diag((1.0, 1.0, -1.0, 1.0))}, "no rotation"),
        ({"attitude_rad": (np.nan, 0.0)}, "attitude"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(change, words):
    good = {"ranges_m": [1.0, 2.0], "lidar_in_base": UPRIGHT, **FOV}
    with pytest.raises(ScanError, match=words):
        project(**{**good, **change})


@given(headings, st.floats(-1.5, 1.5), headings)
def test_roll_pitch_and_yaw_come_back(roll, pitch, yaw):
    rotation = turn((0, 0, 1), yaw) @ turn((0, 1, 0), pitch) @ turn((1, 0, 0), roll)
    np.testing.assert_allclose(turn((0, 0, 1), yaw) @ matrix_of_lean(roll, pitch), rotation, atol=1e-12)
    np.testing.assert_allclose(roll_pitch_yaw_of(rotation), (roll, pitch, yaw), atol=1e-6)


@given(st.floats(-3.1, 3.1), offsets)
def test_a_quaternion_is_the_turn_about_its_axis(angle, offset):
    axis = np.add(offset, (0.0, 0.0, 0.5))
    axis /= np.linalg.norm(axis)
    quaternion = (*(math.sin(angle / 2) * axis), math.cos(angle / 2))
    np.testing.assert_allclose(matrix_of_quaternion(quaternion), turn(axis, angle), atol=1e-12)


def test_without_a_greatest_range_the_farthest_return_counts():
    # pointcloud_to_laserscan publishes range_max +inf by default
    fov = {**FOV, "range_max_m": np.inf}
    scan = project(np.array([3.0, np.inf, 8.0, np.nan]), lidar_in_base=UPRIGHT, **fov)
    np.testing.assert_array_equal(scan.ranges_m, [3.0, np.inf, 8.0])
    assert scan.range_max_m == pytest.approx(8.0, abs=0.1)
    assert scan.range_max_m > 8.01  # or the return would count as none, see `ranges_for`


@pytest.mark.table("moved", [(0.0, 0.0, 0.3), (0.2, -0.1, 0.0), (0.15, 0.05, -0.4)])
@pytest.mark.table("mounting", [(0.0, 0.0, 0.0), (0.2, -0.1, 0.7)])
def test_a_lidar_that_moves_while_it_scans_sees_straight_walls(moved, mounting):
    # given a room of 8 x 6 m, each beam of which is measured where the lidar is by then
    walls = Walls.from_polygons([np.array([(-4.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-4.0, 3.0)])])
    ranges = np.empty(401)
    for index in range(401):
        x, y, yaw = se2.compose(index / 400 * np.array(moved), mounting)
        ranges[index] = planar_world.cast(walls.ends_m, (x, y), np.array([yaw - 2.0 + 0.01 * index]))[0]
    ranges[200] = np.inf
    in_base = pose_matrix(turn((0, 0, 1), mounting[2]), (*mounting[:2], 0.0))
    # when the motion is undone
    scan = project(ranges, lidar_in_base=in_base, moved=moved, **FOV)
    # then all beams end at the walls, seen from where the base was at the first
    hits = np.isfinite(scan.ranges_m)
    seen = dataclasses.replace(scan, angles_rad=scan.angles_rad[hits], ranges_m=scan.ranges_m[hits])
    x, y = ends_in_base(seen).T
    away = np.minimum(np.abs(4.0 - np.abs(x)), np.abs(3.0 - np.abs(y)))
    assert len(x) == 400
    assert away.max() < 1e-9
    assert max(np.abs(x).max() - 4.0, np.abs(y).max() - 3.0) < 1e-9
    # and the beam without a return points where it pointed
    assert scan.angles_rad[200] == pytest.approx(moved[2] / 2)


@pytest.mark.table("moved", [(0.0, 0.0), (np.nan, 0.0, 0.0)])
def test_a_motion_that_is_none_is_refused(moved):
    with pytest.raises(ScanError, match="motion during the scan"):
        project(np.ones(401), lidar_in_base=UPRIGHT, moved=moved, **FOV)
