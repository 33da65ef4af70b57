"""Photographs follow SLAM's path: compared with the slow way, and in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera
from inspection.flight.slam_path import FollowedRecords, LevelPose, SlamPath, moved_record
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord, read_record

AHEAD = (-0.5, 0.5, -0.5, 0.5)
NOWHERE = LevelPose((0.0, 0.0, 0.0), 0.0)
PICTURE = np.zeros((48, 64, 3), np.uint8)


def record(stamp_s, place_m=(1.0, 2.0, 3.0)):
    return PhotographRecord(stamp_s, place_m, AHEAD, 0.002, 100.0, 90.0, view=1)


def matrix(pose):
    """Return the (4, 4) of a level pose: the slow way."""
    moved = np.eye(4)
    moved[:3, :3] = Rotation.from_rotvec((0.0, 0.0, pose.yaw_rad)).as_matrix()
    moved[:3, 3] = pose.place_m
    return moved


def odometry_at(stamp_s):
    """An arc of 5 m radius at 0.5 m/s."""
    turn = 0.1 * stamp_s
    return LevelPose((5.0 * math.sin(turn), 5.0 - 5.0 * math.cos(turn), 2.0), turn)


def flown(seconds=60.0):
    followed = FollowedRecords()
    for stamp_s in np.arange(0.0, seconds, 0.05):
        followed.note(stamp_s, odometry_at(stamp_s))
    return followed


def path_of(correction_at, stamps_s, height=True):
    """SLAM's path, if `odom` is there in the map at each stamp."""
    poses = []
    for stamp_s in stamps_s:
        odometry = odometry_at(stamp_s)
        place_m = matrix(correction_at(stamp_s)) @ (*odometry.place_m, 1.0)
        z_m = place_m[2] if height else 0.0
        poses.append((place_m[0], place_m[1], z_m, odometry.yaw_rad + correction_at(stamp_s).yaw_rad))
    return SlamPath(np.array(stamps_s, float), np.array(poses).reshape(-1, 4))


STAMPS_S = np.arange(0.02, 60.0, 0.5)
BEFORE, NOW = LevelPose((0.3, -0.2, 0.0), 0.1), LevelPose((-0.4, 0.7, 0.25), -0.3)


@pytest.mark.table("stamp_s", [0.1, 7.3, 33.0, 59.0])
def test_a_photograph_moves_with_the_path_as_a_rigid_body(stamp_s):
    followed = flown()
    told = record(stamp_s)
    followed.add(Path("a.jpg"), told, BEFORE)
    ((path, moved),) = followed.moved(path_of(lambda _: NOW, STAMPS_S))
    change = matrix(NOW) @ np.linalg.inv(matrix(BEFORE))
    assert path == Path("a.jpg")
    np.testing.assert_allclose(moved.position_m, (change @ (1.0, 2.0, 3.0, 1.0))[:3], atol=2e-3)
    turned = Rotation.from_matrix(change[:3, :3]) * Rotation.from_quat(AHEAD)
    assert (turned.inv() * Rotation.from_quat(moved.orientation_xyzw)).magnitude() < 1e-3
    assert (moved.told_position_m, moved.told_orientation_xyzw) == ((1.0, 2.0, 3.0), AHEAD)
    # The same path again moves nothing, and one as at first brings it back
    assert followed.moved(path_of(lambda _: NOW, STAMPS_S)) == []
    ((_, back),) = followed.moved(path_of(lambda _: BEFORE, STAMPS_S))
    np.testing.assert_allclose(back.position_m, (1.0, 2.0, 3.0), atol=2e-3)
    assert back.told_position_m == (1.0, 2.0, 3.0)


def test_a_loop_closure_of_a_metre_moves_what_was_taken_before_it_by_its_share():
    """SLAM spreads the metre evenly over 60 s. The map is level, so the path's height is odometry's."""
    followed = flown()
    for stamp_s in (6.0, 30.0, 54.0):
        followed.add(Path(f"{stamp_s}.jpg"), record(stamp_s), NOWHERE)
    drift = lambda stamp_s: LevelPose((stamp_s / 60.0, 0.0, 0.0), 0.0)  # noqa: E731
    moved = dict(followed.moved(path_of(drift, STAMPS_S, height=False)))
    for stamp_s in (6.0, 30.0, 54.0):
        expected = (1.0 + stamp_s / 60.0, 2.0, 3.0)
        np.testing.assert_allclose(moved[Path(f"{stamp_s}.jpg")].position_m, expected, atol=2e-3)


def test_a_photograph_that_the_path_does_not_reach_stays_where_it_is():
    followed = flown()
    followed.add(Path("late.jpg"), record(59.9), NOWHERE)
    assert followed.moved(path_of(lambda _: NOW, STAMPS_S[:100])) == []
    assert followed.moved(SlamPath(np.zeros(0), np.zeros((0, 4)))) == []
    assert FollowedRecords().moved(path_of(lambda _: NOW, STAMPS_S)) == []


def test_a_small_change_is_not_written():
    followed = flown()
    followed.add(Path("a.jpg"), record(10.0), NOWHERE)
    assert followed.moved(path_of(lambda _: LevelPose((0.004, 0.0, 0.0), 0.0), STAMPS_S)) == []


def test_after_a_clock_that_was_set_back_no_path_moves_photographs_of_before():
    followed = flown()
    followed.add(Path("a.jpg"), record(10.0), NOWHERE)
    for stamp_s in np.arange(5.0, 30.0, 0.05):
        followed.note(stamp_s, odometry_at(stamp_s))
    assert followed.moved(path_of(lambda _: NOW, np.arange(5.0, 30.0, 0.5))) == []


def test_the_folder_holds_the_corrected_record_and_lists(tmp_path):
    folder = PhotographFolder(tmp_path, SurveyCamera(64, 48))
    path = folder.save(PICTURE, record(10.0))
    corrected = moved_record(record(10.0), NOWHERE, LevelPose((1.0, 0.0, 0.0), 0.0))
    folder.correct(path, corrected)
    folder.correct_lists()
    assert read_record(path.with_suffix(".json")) == corrected
    assert corrected.position_m == pytest.approx((2.0, 2.0, 3.0))
    assert "10.000000 2.000000 2.000000 3.000000" in (tmp_path / "groundtruth.txt").read_text()
    assert not list(tmp_path.glob("*.part"))
