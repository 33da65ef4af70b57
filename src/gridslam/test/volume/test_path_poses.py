"""Corrections of odometry from a path, in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from gridslam import PoseError
from gridslam.volume import Pose
from gridslam.volume.path_poses import OdometryHistory, odom_in_map


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


@pytest.mark.parametrize(
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
