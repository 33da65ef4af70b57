"""Weights and resampling: the filter's statistics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gridslam.filter import resampling

logs = st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=40).map(np.array)


@given(logs, st.floats(1e-3, 10.0))
def test_weights_are_normalised_and_keep_their_ratios(log_weights, gain):
    weights = resampling.normalised(log_weights, gain)
    assert weights.sum() == pytest.approx(1.0)
    assert (weights >= 0.0).all()
    best = np.argmax(log_weights)
    expected = np.exp(gain * (log_weights - log_weights[best]))
    np.testing.assert_allclose(weights / weights[best], expected, atol=1e-300)  # below: denormal numbers


@given(logs, st.floats(-1e5, 1e5))
def test_weights_do_not_depend_on_the_likelihoods_unit(log_weights, shift):
    ours, shifted = (resampling.normalised(values, 0.1) for values in (log_weights, log_weights + shift))
    np.testing.assert_allclose(ours, shifted, atol=1e-9)


@pytest.mark.table(
    ("weights", "expected"),
    [
        ([0.25] * 4, 4.0),  # all equal: as many as there are
        ([1.0, 0.0, 0.0], 1.0),  # one has it all
        ([0.5, 0.5, 0.0, 0.0], 2.0),
        ([2 / 3, 1 / 3], 9 / 5),  # 1 / (4/9 + 1/9)
    ],
)
def test_effective_number_in_closed_form(weights, expected):
    assert resampling.effective_number(np.array(weights)) == pytest.approx(expected)


def test_entropy_in_closed_form():
    assert resampling.entropy(np.full(8, 1 / 8)) == pytest.approx(math.log(8))
    assert resampling.entropy(np.array([1.0, 0.0])) == 0.0


@given(logs, st.floats(0.0, 1.0, exclude_max=True))
def test_every_particle_gets_its_share_of_children_rounded(log_weights, uniform):
    weights = resampling.normalised(log_weights, 1e-3)
    children = np.bincount(resampling.systematic(weights, uniform), minlength=weights.size)
    share = weights * weights.size
    assert children.sum() == weights.size
    assert (children >= np.floor(share - 1e-9)).all()
    assert (children <= np.ceil(share + 1e-9)).all()


@settings(max_examples=20)
@given(st.lists(st.floats(0.01, 1.0), min_size=2, max_size=12).map(np.array))
def test_resampling_is_unbiased(weights):
    # the mean over the whole range of the one random number is exact: it is the integral of a step function
    weights = weights / weights.sum()
    grid = (np.arange(2000) + 0.5) / 2000
    children = np.mean(
        [np.bincount(resampling.systematic(weights, u), minlength=weights.size) for u in grid], axis=0
    )
    np.testing.assert_allclose(children, weights * weights.size, atol=2e-3 * weights.size)
