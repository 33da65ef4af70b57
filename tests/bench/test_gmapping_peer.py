"""gmapping's row of `bench slam`: its poses are read from its log, and stand at their scans."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.peers import gmapping
from benchmarks.peers.environments import PeerError
from benchmarks.slam_rows import gmapping as row
from benchmarks.slam_rows.logs import LOGS

SAID = """\
\x1b[32mnew best pose: 0.000 0.000 0.000\x1b[0m
\x1b[32modom pose: 1.000 0.000 0.500\x1b[0m
\x1b[32mcorrection: -1.000 0.000 -0.500\x1b[0m
\x1b[32mnew best pose: 1.250 0.000 0.100\x1b[0m
\x1b[32modom pose: 2.000 0.000 0.500\x1b[0m
\x1b[32mTrajectory tree:\x1b[0m
\x1b[32m  1.300 0.000 0.150\x1b[0m
\x1b[32m  0.100 0.000 0.000\x1b[0m
\x1b[32m  0.000 0.000 0.000\x1b[0m
\x1b[32mReading is NULL\x1b[0m
Average Scan Matching Score=285.259
\x1b[32mnew best pose: 2.500 0.000 0.200\x1b[0m
\x1b[32modom pose: 3.000 0.000 -3.141\x1b[0m
"""


def test_the_last_tree_is_the_final_path_and_later_poses_follow_it():
    told = gmapping.parsed(SAID.splitlines())
    np.testing.assert_array_equal(told.online, [[0.0, 0.0, 0.0], [1.25, 0.0, 0.1], [2.5, 0.0, 0.2]])
    np.testing.assert_array_equal(told.final, [[0.1, 0.0, 0.0], [1.3, 0.0, 0.15], [2.5, 0.0, 0.2]])
    np.testing.assert_array_equal(told.odometry, [[1.0, 0.0, 0.5], [2.0, 0.0, 0.5], [3.0, 0.0, -3.141]])


def test_a_log_without_poses_is_refused():
    with pytest.raises(PeerError, match=r"^gmapping told 0 poses and 0 of odometry: not its log\?$"):
        gmapping.parsed(["[ INFO] replay stopped."])


def test_told_poses_stand_at_their_scans_also_across_half_a_turn():
    lidar_in_odom = np.array(
        [[1.0, 0.0, 0.5], [1.5, 0.0, 0.5], [2.0, 0.0, 0.5], [2.0, 0.0, 0.5], [3.0, 0.0, math.pi - 1e-4]]
    )
    told = gmapping.parsed(SAID.splitlines()).odometry
    assert gmapping.processed(told, lidar_in_odom).tolist() == [0, 2, 4]


def test_a_pose_that_no_scan_has_is_refused():
    with pytest.raises(PeerError, match="where the bag has no further scan"):
        gmapping.processed(np.array([[9.0, 0.0, 0.0]]), np.zeros((3, 3)))


def test_a_program_that_is_not_there_has_a_sentence_in_place_of_its_rows(tmp_path):
    found = row.measure(tmp_path / "slam_gmapping_replay", LOGS["csail"], tmp_path, [1])
    assert found["left_out"].endswith("is no program; give the path of slam_gmapping_replay.")
    assert row.as_table({"csail": {"gmapping": found}}) == f"csail: {found['left_out']}"
