"""How uncertain the newest pose is, by closed forms along a straight way, and a dense inverse."""

import math

import numpy as np
import pytest
from room_paths import path_along

from gridslam import se2
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.path.pose_spread import pose_spread, systematic_errors

ALONG_M, ACROSS_M, TURN_RAD = 0.03, 0.02, 0.01
STEPS, STEP_M = 12, 0.5


@pytest.fixture
def straight():
    """A path of 12 steps of 0.5 m towards y, and the covariances of its steps."""
    poses = np.column_stack(
        [np.zeros(STEPS + 1), STEP_M * np.arange(STEPS + 1), np.full(STEPS + 1, np.pi / 2)]
    )
    return path_along(poses), np.tile(np.diag([ALONG_M, ACROSS_M, TURN_RAD]) ** 2, (STEPS, 1, 1))


def along_across(steps):
    """Variances along and across after so many steps: each turn's error moves what comes after it."""
    levers_m = STEP_M * np.arange(steps)
    return steps * ALONG_M**2, steps * ACROSS_M**2 + TURN_RAD**2 * float(levers_m @ levers_m)


def test_without_closures_the_errors_of_all_steps_add_up(straight):
    path, steps = straight
    spread = pose_spread(path, steps, [], recognised=0)
    along, across = along_across(STEPS)
    assert np.diag(spread.in_map) == pytest.approx((across, along, STEPS * TURN_RAD**2))  # y is along
    assert spread.since_recognised_m == pytest.approx(math.sqrt(max(along, across)))
    assert spread.in_map_m == pytest.approx(spread.since_recognised_m)


def test_only_the_way_since_the_place_that_was_recognised_counts(straight):
    path, steps = straight
    spread = pose_spread(path, steps, [], recognised=STEPS - 4)
    assert spread.since_recognised_m == pytest.approx(math.sqrt(max(along_across(4))))
    assert spread.in_map_m == pose_spread(path, steps, [], recognised=0).in_map_m
    assert pose_spread(path, steps, [], recognised=STEPS).since_recognised_m == 0.0


def test_an_error_of_odometrys_metre_adds_up_where_scans_do_not_measure_the_way(straight):
    # given scans that measure nothing along the way, and nearly everything across
    path, _ = straight
    odometry = np.tile(np.diag([ALONG_M, ALONG_M, TURN_RAD]) ** 2, (STEPS, 1, 1))
    steps = np.tile(np.diag([ALONG_M, 1e-3 * ALONG_M, 1e-6]) ** 2, (STEPS, 1, 1))
    off_m = systematic_errors(path, steps, odometry, share_off=0.05)
    np.testing.assert_allclose(off_m, np.tile((0.0, 0.05 * STEP_M), (STEPS, 1)), atol=1e-6)  # y is along
    # then it is 5 % of the way, beside the root of the squares of what is random
    spread = pose_spread(path, steps, [], 0, off_m)
    assert spread.since_recognised_m == pytest.approx(
        math.hypot(0.05 * STEPS * STEP_M, math.sqrt(STEPS) * ALONG_M), rel=1e-3
    )
    # and where scans measure the way too, nothing is left of it
    measured = systematic_errors(path, 1e-6 * odometry, odometry, share_off=0.05)
    np.testing.assert_allclose(measured, 0.0, atol=1e-6)


PLACE = np.diag([0.02, 0.02, 0.003]) ** 2


def closure(older, newer):
    """A place that was found again exactly where the straight path has it."""
    return Match(older, newer, np.array(((newer - older) * STEP_M, 0.0, 0.0)), PLACE, 0.9)


def test_a_closure_and_the_way_tell_the_place_together(straight):
    path, steps = straight
    way = pose_spread(path, steps, [], recognised=0).in_map
    spread = pose_spread(path, steps, [closure(0, STEPS)], recognised=0)
    together = np.linalg.inv(np.linalg.inv(way) + np.linalg.inv(PLACE))
    np.testing.assert_allclose(spread.in_map, together, atol=1e-10)
    # since then, the shortest way counts, which leads over the closure
    assert spread.since_recognised_m == pytest.approx(0.02)


def test_closures_behind_the_way_that_joins_both_parts_of_a_map_do_not_tell_where_the_second_is(straight):
    path, steps = straight
    way = pose_spread(path, steps, [], recognised=0).in_map_m
    loops = [closure(older, STEPS) for older in range(6, 9)]
    spread = pose_spread(path, steps, loops, recognised=STEPS)
    # The way to node 6 alone, seen from 3 m behind it, is less by a little only
    until = pose_spread(path, steps * (np.arange(STEPS) < 6)[:, None, None] + 1e-12 * np.eye(3), [], 0)
    assert until.in_map_m < spread.in_map_m < way
    assert spread.since_recognised_m == 0.0


def test_many_loops_are_weighed_as_the_dense_inverse_does():
    # given a bent path, and closures between nodes drawn at random
    rng = np.random.default_rng(3)
    poses = np.cumsum(rng.uniform(-1.0, 1.0, (9, 3)), axis=0)
    path, steps = path_along(poses), np.tile(np.diag([ALONG_M, ACROSS_M, TURN_RAD]) ** 2, (8, 1, 1))
    ends = [(0, 5), (1, 8), (2, 6), (3, 8)]
    loops = [Match(*pair, se2.between(*poses[list(pair)]), PLACE, 0.9) for pair in ends]
    pairs = np.array([*((i, i + 1) for i in range(8)), *ends])
    whitening = np.repeat(np.sqrt([np.diag(steps[0]), np.diag(PLACE)]), (8, 4), axis=0)
    measured = se2.between(poses[pairs[:, 0]], poses[pairs[:, 1]])

    def errors(moves):
        moved = se2.compose(poses, np.vstack([np.zeros(3), moves.reshape(-1, 3)]))
        return (se2.between(measured, se2.between(*moved[pairs.T])) / whitening).ravel()

    small = 1e-6 * np.eye(24)
    jacobian = np.array([(errors(move) - errors(-move)) / 2e-6 for move in small]).T
    of_newest = np.linalg.inv(jacobian.T @ jacobian)[-3:, -3:]
    cos, sin = np.cos(poses[-1, 2]), np.sin(poses[-1, 2])
    turn = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    found = pose_spread(path, steps, loops, recognised=0).in_map
    np.testing.assert_allclose(found, turn @ of_newest @ turn.T, rtol=1e-5, atol=1e-9)


def test_a_wrong_step_without_a_scan_counts_wholly(straight):
    path, steps = straight
    steps[3] = np.diag([10.0, 10.0, 0.3]) ** 2
    assert pose_spread(path, steps, [], recognised=0).since_recognised_m > 10.0
    assert pose_spread(path, steps, [], recognised=5).since_recognised_m < 0.3
