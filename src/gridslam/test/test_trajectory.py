"""Paths that share ancestors, and what odometry fills in between."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gridslam import StateError, se2
from gridslam.trajectory import Node, Trajectory, TrajectoryTree

PARTICLES = 3
parents = st.lists(st.integers(0, PARTICLES - 1), min_size=PARTICLES, max_size=PARTICLES).map(np.array)


@given(st.lists(parents, min_size=1, max_size=30))
def test_paths_equal_plain_copies(history):
    tree, copies, rng = TrajectoryTree(PARTICLES), [[] for _ in range(PARTICLES)], np.random.default_rng(0)
    for stamp, chosen in enumerate(history):
        poses = rng.uniform(-1.0, 1.0, (PARTICLES, 3))
        tree.extend(stamp, poses)
        copies = [[*path, pose] for path, pose in zip(copies, poses)]
        tree.resample(chosen)
        copies = [list(copies[parent]) for parent in chosen]
    again = TrajectoryTree.from_state(tree.state())
    for particle, path in enumerate(copies):
        np.testing.assert_array_equal(tree.path(particle), path)
        np.testing.assert_array_equal(again.path(particle), path)
    assert again.stamps_s == tree.stamps_s == list(range(len(history)))


def test_branches_without_particles_are_forgotten():
    tree = TrajectoryTree(30)
    for stamp in range(100):
        tree.extend(stamp, np.zeros((30, 3)))
        tree.resample(np.zeros(30, int))
    gc.collect()
    alive = sum(isinstance(thing, Node) for thing in gc.get_objects())
    assert len(tree.state().node_poses) == 100
    assert alive <= 100 + 30


def test_a_long_path_is_freed_without_recursion():
    tree = TrajectoryTree(1)
    for stamp in range(200_000):
        tree.leaves[0] = Node((0.0, 0.0, float(stamp)), tree.leaves[0])
    tree.leaves[0] = None


def test_odometry_fills_in_and_what_it_missed_is_spread_evenly():
    # given two poses, 2 s apart; odometry saw half the way in the first second and turned as it went
    odometry = np.array([(5.0, 5.0, 0.0), (5.5, 5.0, 0.1), (6.0, 5.1, 0.2), (7.0, 5.1, 0.2)])
    trajectory = Trajectory(np.array([10.0, 12.0]), np.array([(0.0, 0.0, 0.0), (1.1, 0.1, 0.3)]))
    filled = trajectory.filled(np.array([10.0, 11.0, 12.0, 13.0]), odometry)
    # then the poses are kept, the one between is odometry's and half of what it missed
    np.testing.assert_allclose(filled[[0, 2]], trajectory.poses_in_map, atol=1e-12)
    np.testing.assert_allclose(filled[1], (0.5 + 0.05, 0.0, 0.1 + 0.05), atol=1e-12)
    # and after the last one odometry carries on
    expected = se2.compose(trajectory.poses_in_map[1], se2.between(odometry[2], odometry[3]))
    np.testing.assert_allclose(filled[3], expected, atol=1e-12)


def test_what_odometry_missed_in_a_jump_belongs_to_that_step_alone():
    # given 1 m/s along x, and odometry that counts as at rest from 11 to 12 s, when it jumped
    odometry = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 0.0)])
    stamps, poses = np.arange(10.0, 15.0), np.column_stack([np.arange(5.0), np.zeros((5, 2))])
    trajectory = Trajectory(stamps[[0, 3, 4]], poses[[0, 3, 4]])
    filled = trajectory.filled(stamps, odometry, np.array([False, False, True, False, False]))
    # then each pose is where the vehicle was
    np.testing.assert_allclose(filled, poses, atol=1e-12)


@pytest.mark.table(
    "stamps_s", [(10.0, 12.0, 11.0), (10.0, 10.0, 12.0), (9.0, 10.0, 11.0), (10.1, 12.0, 13.0)]
)
def test_odometry_that_cannot_fill_in_is_refused(stamps_s):
    trajectory = Trajectory(np.array([10.0, 12.0]), np.zeros((2, 3)))
    with pytest.raises(StateError, match="must ascend"):
        trajectory.filled(np.array(stamps_s), np.zeros((3, 3)))
