"""The heights that fit odometry's climbs and those of the closures."""

import math

import numpy as np
import pytest
from equal_steps import match
from hypothesis import given
from hypothesis import strategies as st
from room_paths import path_of, snapshot_along

from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.consistent_set import UncorrectedPath, contradict_in_height
from gridslam.loop_closure.path.pose_graph import ROBUST_SCALE
from gridslam.loop_closure.space.heights import climb_sigmas_m, fitted_heights, step_variances_m2

P = LoopClosureParameters()


def path_with(heights_m):
    """A path along x, with a step of 1 m, at these heights by odometry."""
    heights_m = np.array(heights_m, float)
    poses = np.column_stack([np.arange(len(heights_m)), np.zeros((len(heights_m), 2))])
    return path_of(snapshot_along(poses, heights_m=heights_m), P)


def climbed(older, newer, climb_m, sigma_m=0.02):
    place = match(older, newer, np.zeros(3))
    return type(place)(older, newer, place.newer_in_older, place.covariance, 0.9, climb_m, sigma_m)


def cost(heights_m, path, closures):
    """What the heights should make least, as it stands in the literature."""
    off = (np.diff(heights_m) - path.climbs_m) ** 2 / step_variances_m2(path, P)
    robust = [
        ROBUST_SCALE**2
        * math.log1p(
            ((heights_m[c.newer] - heights_m[c.older] - c.climb_m) / c.climb_sigma_m / ROBUST_SCALE) ** 2
        )
        for c in closures
    ]
    return off.sum() + sum(robust)


def test_a_climb_is_as_uncertain_as_the_shortest_way_over_steps_and_closures():
    # given a way of 40 m with a closure from its 10th to its 35th node, and one that tells no climb
    path = path_with(np.zeros(41))
    closures = [climbed(10, 35, 0.0), climbed(0, 40, np.nan, np.nan)]
    found = climb_sigmas_m(path, closures, 40, P)
    for node, way_m in ((40, 0.0), (38, 2.0), (35, 5.0), (10, 5.1), (0, 15.1), (22, 17.1)):
        expected = math.hypot(P.climb_m_per_sqrt_m * math.sqrt(way_m), P.drift_share * way_m)
        assert found[node] == pytest.approx(expected, rel=0.01)


def test_a_closure_that_others_contradict_moves_nothing():
    path = path_with(np.zeros(60))
    closures = [climbed(i, i + 40, 0.0) for i in range(10)]
    found = fitted_heights(path, [*closures, climbed(12, 52, 1.0)], P)
    assert np.abs(found).max() < 0.02


@given(st.data())
def test_no_other_heights_fit_better(data):
    """The slope of the cost is zero, and the first node stays."""
    count = data.draw(st.integers(3, 12))
    path = path_with(data.draw(st.lists(st.floats(-2.0, 2.0), min_size=count, max_size=count)))
    closures = []
    for _ in range(data.draw(st.integers(1, 4))):
        older = data.draw(st.integers(0, count - 2))
        newer = data.draw(st.integers(older + 1, count - 1))
        off_m = data.draw(st.floats(-0.05, 0.05))
        climb_m = float(path.heights_m[newer] - path.heights_m[older]) + off_m
        closures.append(climbed(older, newer, climb_m, data.draw(st.floats(0.01, 0.1))))
    found = fitted_heights(path, closures, P)
    assert found[0] == path.heights_m[0]
    best = cost(found, path, closures)
    assert best <= cost(path.heights_m, path, closures) + 1e-9
    for node in range(1, count):
        for step_m in (1e-4, -1e-4):
            moved = found.copy()
            moved[node] += step_m
            assert best <= cost(moved, path, closures) + 1e-5


@pytest.mark.table("heights_m", [[0.0, np.nan, 0.0], [0.0, 0.1, 0.2]])
def test_heights_stay_where_nothing_tells_them(heights_m):
    path = path_with(heights_m)
    closures = [climbed(0, 2, np.nan, np.nan)] if np.isfinite(heights_m).all() else [climbed(0, 2, 0.0)]
    np.testing.assert_array_equal(fitted_heights(path, closures, P), path.heights_m)


def test_climbs_that_do_not_close_a_loop_contradict_each_other():
    # given a level way of 60 m: two level matches, one that is 1 m higher, one whose climb is not known
    path = path_with(np.zeros(61))
    uncorrected = UncorrectedPath(path, path.covariances, step_variances_m2(path, P))
    first, *others = [
        climbed(0, 50, 0.0),
        climbed(2, 52, 0.02),
        climbed(4, 54, 1.0),
        climbed(5, 55, np.nan, np.nan),
    ]
    assert contradict_in_height(uncorrected, first, others).tolist() == [False, True, False]
    # and far from each other along the way, odometry may have drifted by as much
    far = climbed(0, 10, 0.12)
    assert contradict_in_height(uncorrected, far, [climbed(50, 60, 0.0)]).tolist() == [False]
