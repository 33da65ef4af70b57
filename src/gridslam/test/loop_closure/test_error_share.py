"""How large errors are, as shares of what covariances tell: closed forms along a straight way."""

import math

import numpy as np
import pytest
from room_paths import path_along

from gridslam.loop_closure.edges import Edge, Edges, Match
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.error_share import ErrorShares, error_shares, scaled
from gridslam.loop_closure.path.measured_path import odometry_covariances
from gridslam.loop_closure.path.pose_spread import pose_spread, with_usual_errors
from gridslam.loop_closure.path.step_uncertainty import CHI_SQUARE_75

SIGMA_M = 0.05
STEPS, STEP_M, SUPPORT_M = 40, 1.0, 16.0
COVARIANCES = np.tile(np.diag([SIGMA_M, SIGMA_M, 1e-6]) ** 2, (STEPS, 1, 1))
NO_LINKS = Edges.of([])
PATH = path_along(np.column_stack([STEP_M * np.arange(STEPS + 1), np.zeros((STEPS + 1, 2))]))
LOOP_M2 = 2.0 * SIGMA_M**2
"""Variance of a loop's place, x and y together, for each step in it."""


def closure(older, newer, off_sigmas):
    """A place found again, and so many standard deviations farther along than the path has it."""
    way_m, sigma_m = STEP_M * (newer - older), SIGMA_M * math.sqrt(newer - older)
    found = np.array((way_m + off_sigmas * sigma_m, 0.0, 0.0))
    return Match(older, newer, found, 1e-12 * np.eye(3), 0.9)


def links(error_sigmas, count=STEPS):
    """Exact links, from which each step of the path differs by so many standard deviations, along."""
    off = np.array((STEP_M - error_sigmas * SIGMA_M, 0.0, 0.0))
    return Edges.of([Edge(node, node + 1, off, 1e-12 * np.eye(3)) for node in range(count)])


def shares(of_links, closures, spread_m2=STEPS * LOOP_M2):
    return error_shares(PATH, COVARIANCES, of_links, closures, SUPPORT_M, spread_m2)


def test_before_anything_was_measured_errors_are_as_the_covariances_tell():
    assert shares(NO_LINKS, []) == (1.0, 1.0)
    assert shares(links(0.1, count=19), []) == (1.0, 1.0)


def test_links_give_the_first_value_for_scans_but_tell_nothing_of_odometry():
    first = math.sqrt(0.25 / CHI_SQUARE_75)
    assert shares(links(0.5), []) == pytest.approx((first, 1.0), rel=1e-6)
    assert shares(links(20.0), []) == (1.0, 1.0)


@pytest.mark.table("sigmas", [0.0, 1.5, 6.0])
def test_a_loop_as_long_as_the_way_counts_as_much_as_the_first_value(sigmas):
    # given an error along, and none across: half of the variance of x and y together
    mean = (1.0 + sigmas**2 / 2.0) / 2.0
    assert shares(NO_LINKS, [closure(0, STEPS, sigmas)]) == pytest.approx([math.sqrt(mean)] * 2, rel=1e-5)


def test_a_short_loop_tells_little_of_a_long_way():
    # given a loop of 4 m without an error, and a pose at the end of 40 m: it counts a tenth of the first
    assert shares(NO_LINKS, [closure(0, 4, 0.0)]) == pytest.approx([math.sqrt(1.0 / 1.1)] * 2, rel=1e-5)
    # and nearly all where the pose is known by far better
    near = shares(NO_LINKS, [closure(0, 4, 0.0)], spread_m2=0.01 * LOOP_M2)
    assert near == pytest.approx([math.sqrt(0.01 / 4.01)] * 2, rel=1e-5)


def test_closures_near_each_other_count_by_their_distance():
    # 4 m apart with a support of 16 m: the second counts a quarter; far apart, wholly
    near, far = [closure(0, 20, 3.0), closure(4, 24, 0.0)], [closure(0, 20, 3.0), closure(16, 36, 0.0)]
    spread_m2 = 20 * LOOP_M2
    (of_near, _), (of_far, _) = (shares(NO_LINKS, each, spread_m2) for each in (near, far))
    assert of_near == pytest.approx(math.sqrt((1.0 + 4.5) / 2.25), rel=1e-5)
    assert shares(NO_LINKS, near[::-1], spread_m2)[0] == of_near
    assert of_far == pytest.approx(math.sqrt((1.0 + 4.5) / 3.0), rel=1e-5)


def test_no_share_is_zero():
    assert shares(links(0.0), [], 0.0) == (0.01, 0.01)


BY_ODOMETRY = np.diag([0.1, 0.1, 0.2]) ** 2


def test_what_scans_have_measured_errs_as_scans_do_and_the_rest_as_odometry_does():
    # given a step that scans have measured to a hundredth of odometry's variance across, and not along
    turn = np.array(((0.6, -0.8, 0.0), (0.8, 0.6, 0.0), (0.0, 0.0, 1.0)))
    step = turn @ np.diag([0.1, 0.01, 0.02]) ** 2 @ turn.T
    (found,) = scaled(step[None], BY_ODOMETRY[None], ErrorShares(scans=0.5, odometry=2.0))
    measured = 0.99 * 0.5**2 + 0.01 * 2.0**2
    expected = turn @ np.diag([2.0**2 * 0.1**2, measured * 0.01**2, measured * 0.02**2]) @ turn.T
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
    # a step that is worse than odometry errs as that, and shares of 1 change nothing
    (open_step,) = scaled(4.0 * BY_ODOMETRY[None], BY_ODOMETRY[None], ErrorShares(0.1, 0.5))
    np.testing.assert_allclose(open_step, BY_ODOMETRY)
    np.testing.assert_allclose(scaled(step[None], BY_ODOMETRY[None], ErrorShares())[0], step, atol=1e-15)


@pytest.mark.table(("measured", "share"), [(0.0, 0.9), (1.0 - 1e-4, 0.1)])
def test_along_a_bare_corridor_small_errors_of_scans_do_not_make_the_place_certain(measured, share):
    # given scans that measure all of each step, or nothing along it
    p = LoopClosureParameters()
    of_odometry = odometry_covariances(PATH.steps, p)
    steps = of_odometry * (1.0 - np.array((measured, 1.0 - 1e-4, 1.0 - 1e-4)))[:, None] * np.eye(3)
    spread = pose_spread(PATH, steps, [], recognised=0)
    usual = with_usual_errors(spread, PATH, steps, [], ErrorShares(0.1, 0.9), p)
    along = math.sqrt(usual.in_map[0, 0] / spread.in_map[0, 0])
    assert along == 1.0  # what is published does not change
    assert usual.error_share == pytest.approx(share, rel=0.05)
