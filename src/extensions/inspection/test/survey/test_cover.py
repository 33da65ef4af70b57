"""A cover counts what its photographs show, and keeps none that it does not need."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inspection.survey import SurveyParameters
from inspection.survey.kernels.gains import sums_alone
from inspection.survey.views.cover import Cover, Shot

NAMES = ("plates", "frames")


def cover_and_shots(seed, share, class_share, already_m2=None):
    """30 patches of two things, and 12 photographs of some of them."""
    rng = np.random.default_rng(seed)
    patches = SimpleNamespace(
        areas_m2=rng.uniform(0.1, 1.0, 30), parts=rng.integers(0, len(NAMES), 30), names=NAMES
    )
    candidates = SimpleNamespace(
        patches=patches,
        reachable=rng.random(30) < 0.9,
        places_m=np.zeros((12, 3)),
        costs=rng.uniform(1.0, 3.0, 12),
        likely_gains=lambda chosen, worth: np.zeros(len(chosen)),
    )
    cover = Cover(candidates, SurveyParameters(share=share, class_share=class_share), already_m2)
    shots = [Shot(k, 0.0, 0.0, np.flatnonzero(rng.random(30) < 0.4)) for k in range(12)]
    return cover, candidates, shots


def plain_shares(cover, candidates, already_m2):
    """Of all and of each thing, from the photographs alone."""
    shown = np.zeros(30, bool)
    for shot in cover.shots:
        shown[shot.drawn] = True
    areas_m2 = candidates.patches.areas_m2 * candidates.reachable
    of = [candidates.patches.parts == k for k in range(len(NAMES))]
    shown_m2 = np.array([areas_m2[each & shown].sum() for each in of]) + already_m2
    whole_m2 = np.array([areas_m2[each].sum() for each in of]) + already_m2
    return shown_m2.sum() / whole_m2.sum(), shown_m2 / whole_m2


@given(st.integers(0, 2**32 - 1), st.lists(st.integers(0, 11), max_size=40))
def test_the_shares_are_those_of_the_photographs_in_it(seed, moves):
    already_m2 = np.array((0.5, 2.0))
    cover, candidates, shots = cover_and_shots(seed, 0.9, 0.8, already_m2)
    for k in moves:
        if any(each is shots[k] for each in cover.shots):
            cover.remove(shots[k])
        else:
            cover.add(shots[k])
    share, by_class = plain_shares(cover, candidates, already_m2)
    assert cover.share == pytest.approx(share)
    np.testing.assert_allclose(cover.class_shares(), by_class)


@given(st.integers(0, 2**32 - 1), st.sampled_from((0.5, 0.7, 1.0)), st.sampled_from((0.0, 0.8, 1.0)))
def test_no_photograph_is_kept_that_is_not_needed(seed, share, class_share):
    cover, _, shots = cover_and_shots(seed, share, class_share)
    for shot in shots:
        cover.add(shot)
    if not cover.is_enough():
        return
    cover.drop_idle()
    assert cover.is_enough()
    for shot in list(cover.shots):
        cover.remove(shot)
        assert not cover.is_enough()
        cover.add(shot)


@given(st.integers(0, 2**32 - 1), st.sampled_from((0.5, 0.8)))
def test_photographs_chosen_anew_are_enough_and_never_cost_more(seed, share):
    cover, candidates, shots = cover_and_shots(seed, share, 0.0)
    candidates.drawn = lambda place, yaw, tilt: shots[place].drawn
    candidates.likely_gains = lambda chosen, worth: np.array([worth[shots[k].drawn].sum() for k in chosen])
    candidates.best = lambda chosen, worth: np.array(
        [(worth[shots[k].drawn].sum(), 0.0, 0.0) for k in chosen]
    )
    for shot in shots:
        cover.add(shot)
    cost = cover.cost
    cover.improve(np.random.default_rng(seed), lambda: True)  # it ends all the same
    assert cover.cost <= cost + 1e-9
    whole, by_class = plain_shares(cover, candidates, np.zeros(2))
    assert whole >= share - 1e-6
    assert cover.share == pytest.approx(whole)
    np.testing.assert_allclose(cover.class_shares(), by_class)
    counts = sum(np.bincount(each.drawn, minlength=30) for each in cover.shots)
    np.testing.assert_array_equal(cover.counts, counts)


def test_what_one_photograph_alone_shows_is_summed_as_by_hand():
    drawn = [np.array((0, 1, 2)), np.array((2, 3)), np.array((4,))]
    counts, areas_m2, parts = np.array((1, 1, 2, 1, 2)), np.arange(1.0, 6.0), np.array((0, 1, 0, 0, 1))
    found = sums_alone(np.array((0, 3, 5, 6)), np.concatenate(drawn), counts, areas_m2, parts, 2)
    np.testing.assert_array_equal(found, ((1.0, 2.0), (4.0, 0.0), (0.0, 0.0)))
