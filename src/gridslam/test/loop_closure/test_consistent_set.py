"""Matches that agree with each other, in closed form and beside planted sets."""

import math

import numpy as np
import pytest
from equal_steps import Steps, match

from gridslam import se2
from gridslam.loop_closure.consistent_set import (
    UncorrectedPath,
    contradictions,
    largest_consistent,
    supported,
)


def test_matches_that_agree_are_consistent_and_a_shifted_one_is_not():
    chain = Steps((1.0, 0.0, 2 * math.pi / 60), np.diag([0.01, 0.01, 0.002]) ** 2, 66)
    true = [match(i, i + 60, se2.between(chain.poses[i], chain.poses[i + 60])) for i in (0, 2, 4)]
    shifted = match(1, 61, se2.compose(true[0].newer_in_older, np.array([3.0, 0.0, 0.0])))
    path = UncorrectedPath(chain, chain.covariances, np.zeros(66))
    assert path.poses == pytest.approx(chain.poses)
    assert contradictions(path, true[0], true[1:]).max() < 1e-6
    assert contradictions(path, shifted, true).min() > 1000.0


def test_contradiction_is_the_chi_square_of_the_loop():
    """Both matches span one step more or less on a straight line: errors add along x."""
    chain = Steps((1.0, 0.0, 0.0), np.diag([0.03, 0.03, 1e-6]) ** 2, 20)
    first, second = match(0, 18, (18.0, 0.0, 0.0), 0.02), match(1, 20, (19.3, 0.0, 0.0), 0.02)
    # sum of variances along x: two matches, one step between the older ends, two between the newer ones
    expected = 0.3**2 / (2 * 0.02**2 + 3 * 0.03**2)
    found = contradictions(UncorrectedPath(chain, chain.covariances, np.zeros(20)), first, [second])[0]
    assert found == pytest.approx(expected, rel=0.01)


@pytest.mark.table("seed", range(20))
def test_largest_consistent_set_is_one_and_seldom_smaller_than_the_largest(seed):
    rng = np.random.default_rng(seed)
    wanted = rng.choice(14, 8, replace=False)  # a planted set of 8; chance pairs elsewhere
    consistent = rng.random((14, 14)) < 0.3
    consistent = consistent | consistent.T
    consistent[np.ix_(wanted, wanted)] = True
    np.fill_diagonal(consistent, True)
    found = largest_consistent(consistent)
    assert consistent[np.ix_(found, found)].all()
    assert len(found) >= 8


def test_a_lone_match_does_not_count():
    way_m = np.arange(100.0)
    matches = [match(0, 50, np.zeros(3)), match(1, 80, np.zeros(3)), match(3, 84, np.zeros(3))]
    assert supported(matches, [0, 1, 2], way_m, within_m=10.0) == [1, 2]
    two_of_one_moment = [match(0, 50, np.zeros(3)), match(20, 50, np.zeros(3))]
    assert supported(two_of_one_moment, [0, 1], way_m, within_m=10.0) == []
