"""Corrections of odometry from a path, in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gridslam import PoseError
from gridslam.volume import Pose
from gridslam.volume.path_poses import OdometryHistory, PathCorrections, odom_in_map


def history_along_x(stamps_s, climb=0.0):
    history = OdometryHistory()
    for stamp_s in stamps_s:
        history.add(stamp_s, Pose.level(stamp_s, 0.0, 0.0, climb * stamp_s))
    return history


def test_a_path_that_is_turned_about_the_start_turns_odom():
    """Given odometry along x, when the path says that the way went along y..."""
    stamps_s = np.arange(5.0)
    path = np.column_stack([np.zeros(5), stamps_s, np.full(5, np.pi / 2.0)])
    for pose in odom_in_map(stamps_s, path, history_along_x(stamps_s), np.array([0.0, 2.5, 9.0])):
        np.testing.assert_allclose(pose.rotation @ (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), atol=1e-12)
        np.testing.assert_allclose(pose.translation, 0.0, atol=1e-12)


def test_between_two_poses_the_correction_changes_evenly():
    path = np.array([(0.0, 0.0, 0.0), (4.0, 1.0, 0.0)])
    poses = odom_in_map(
        np.array([0.0, 4.0]), path, history_along_x(np.arange(5.0)), np.array([1.0, 4.0, 8.0])
    )
    np.testing.assert_allclose([pose.translation[1] for pose in poses], [0.25, 1.0, 1.0], atol=1e-12)


def test_odometry_is_interpolated_at_the_paths_stamps():
    path = np.array([(0.1, 2.0, 0.0), (0.3, 2.0, 0.0)])
    poses = odom_in_map(np.array([0.1, 0.3]), path, history_along_x([0.0, 0.2, 0.4]), np.array([0.2]))
    np.testing.assert_allclose(poses[0].translation, (0.0, 2.0, 0.0), atol=1e-12)


def test_odom_rises_by_what_the_path_is_higher_than_odometry():
    """Given odometry that climbs by 0.5 m/s, on a path that is level at 1 m, and on one without heights."""
    stamps_s, history = np.arange(5.0), history_along_x(np.arange(5.0), climb=0.5)
    path = np.column_stack([stamps_s, np.zeros((5, 2))])
    found = odom_in_map(stamps_s, path, history, np.array([0.0, 2.5, 9.0]), np.ones(5))
    np.testing.assert_allclose([pose.translation for pose in found], [(0, 0, 1), (0, 0, -0.25), (0, 0, -1)])
    found = odom_in_map(stamps_s, path, history, np.array([2.5]))
    np.testing.assert_allclose(found[0].translation, 0.0, atol=1e-12)


@pytest.mark.table("rise_m", [None, 0.3])
def test_where_odometry_begins_anew_the_correction_changes_with_that_step_alone(rise_m):
    """Given 1 m/s along x, and odometry that begins anew between 5.2 and 5.4 s, at x = 0 and turned..."""
    history, stamps_s = OdometryHistory(), np.arange(51) / 5.0
    for stamp_s in stamps_s:
        anew = stamp_s > 5.3
        turn = math.pi / 2.0 if anew else 0.0
        history.add(stamp_s, Pose.level(0.0 if anew else stamp_s, 5.4 - stamp_s if anew else 0.0, -turn, 0.0))
    path_s = np.array([0.0, 4.0, 8.0, 10.0])
    path = np.column_stack([path_s, np.zeros((4, 2))])
    heights_m = None if rise_m is None else np.full(4, rise_m)
    # when clouds before and after are put at the path, then each is where the vehicle was
    clouds_s = np.array([4.6, 5.2, 5.4, 6.0, 9.0])
    for stamp_s, pose in zip(clouds_s, odom_in_map(path_s, path, history, clouds_s, heights_m)):
        told = (stamp_s, 0.0, 0.0) if stamp_s < 5.3 else (0.0, 5.4 - stamp_s, 0.0)
        place = pose.rotation @ told + pose.translation
        np.testing.assert_allclose(place, (stamp_s, 0.0, rise_m or 0.0), atol=1e-9)
    corrections = PathCorrections(path_s, path, history, heights_m)
    assert [corrections.cover(stamp_s) for stamp_s in (5.2, 5.3, 5.4)] == [True, False, True]


def test_a_path_that_a_search_has_moved_is_no_jump_of_odometry():
    path = np.array([(0.0, 0.0, 0.0), (4.0, 3.0, 0.0)])
    (pose,) = odom_in_map(np.array([0.0, 4.0]), path, history_along_x(np.arange(5.0)), np.array([1.0]))
    np.testing.assert_allclose(pose.translation, (0.0, 0.75, 0.0), atol=1e-12)


@pytest.mark.table(
    ("stamps_s", "path"),
    [
        ([], np.zeros((0, 3))),
        ([1.0, 1.0], np.zeros((2, 3))),
        ([1.0, 2.0], np.full((2, 3), np.nan)),
        ([100.0, 200.0], np.zeros((2, 3))),
    ],
)
def test_a_path_that_tells_nothing_is_told(stamps_s, path):
    with pytest.raises(PoseError, match="stays as it is"):
        odom_in_map(np.array(stamps_s), path, history_along_x(np.arange(5.0)), np.array([1.0]))
