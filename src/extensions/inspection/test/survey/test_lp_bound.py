"""The bound is below every cover, however good, and near the relaxation's optimum."""

from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from inspection.survey.views.lp_bound import PatchSample, lp_bounds

PATCHES, PLACES = 24, 10


def candidates_and_cover(seed, taken):
    """Each place draws one set of patches; the cover has the photographs of some places."""
    rng = np.random.default_rng(seed)
    shows = rng.random((PLACES, PATCHES)) < 0.3
    shows[rng.integers(0, PLACES, PATCHES), np.arange(PATCHES)] = True
    drawn = [np.flatnonzero(each) for each in shows]
    candidates = SimpleNamespace(
        places_m=np.zeros((PLACES, 3)),
        begins=np.cumsum([0] + [len(each) for each in drawn]),
        seen=np.concatenate(drawn),
        drawn=lambda place, yaw, tilt: drawn[place],
        best=lambda places, worth: np.array([(worth[drawn[k]].sum(), 0.0, 0.0) for k in places]),
    )
    shots = [SimpleNamespace(drawn=drawn[k]) for k in taken]
    counts = shows[list(taken)].sum(axis=0)
    return shows, candidates, SimpleNamespace(shots=shots, areas_m2=np.ones(PATCHES), counts=counts)


def fewest(shows, left_out):
    """How many photographs a cover needs that leaves out so many patches at most, by trying all."""
    for number in range(PLACES + 1):
        for chosen in combinations(range(PLACES), number):
            if (~shows[list(chosen)].any(axis=0)).sum() <= left_out:
                return number
    raise AssertionError("All places together show all patches.")


def relaxed(shows, left_out):
    """The optimum of the relaxation with the photographs of all places."""
    costs = np.concatenate((np.ones(PLACES), np.zeros(PATCHES)))
    matrix = np.vstack((np.hstack((-shows.T.astype(float), -np.eye(PATCHES))), 1.0 - costs))
    return linprog(costs, A_ub=matrix, b_ub=np.append(-np.ones(PATCHES), left_out), method="highs").fun


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.sampled_from((0.75, 1.0)))
def test_bounds_rise_to_the_relaxation_and_no_cover_is_below(seed, share):
    shows, candidates, cover = candidates_and_cover(seed, range(PLACES))
    bounds = list(lp_bounds(candidates, cover, share, np.random.default_rng(seed)))
    left_out = (1.0 - share) * PATCHES
    assert bounds == sorted(bounds)
    assert bounds[-1] <= fewest(shows, left_out) + 1e-6
    assert bounds[-1] == pytest.approx(relaxed(shows, left_out), rel=0.01)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_columns_that_the_cover_lacks_are_found(seed):
    shows, candidates, cover = candidates_and_cover(seed, range(0, PLACES, 2))
    left_out = float((cover.counts == 0).sum())
    *_, bound = lp_bounds(candidates, cover, 1.0, np.random.default_rng(seed))
    optimum = relaxed(shows, left_out)
    assert 0.9 * optimum <= bound <= optimum + 1e-6


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_with_fair_prices_no_photograph_is_worth_more_than_one(seed):
    shows, candidates, cover = candidates_and_cover(seed, range(PLACES))
    rng = np.random.default_rng(seed)
    sample = PatchSample(candidates, cover, 1.0, rng)
    prices = rng.random(PATCHES)
    fair = sample.fair(prices, sample.best_views(prices)[:, 0], [])
    for each in shows:
        assert fair[sample.rows_of(np.flatnonzero(each))].sum() <= 1.0 + 1e-9
    assert fair.sum() >= prices.sum() / max(prices[sample.rows_of(np.flatnonzero(e))].sum() for e in shows)


def test_a_relaxation_that_is_not_solved_gives_no_bound():
    _, candidates, cover = candidates_and_cover(1, ())
    cover.shots = [SimpleNamespace(drawn=np.array((0,)))]  # it cannot show the 23 others
    cover.counts = np.ones(PATCHES, int)
    assert not list(lp_bounds(candidates, cover, 1.0, np.random.default_rng(1)))
