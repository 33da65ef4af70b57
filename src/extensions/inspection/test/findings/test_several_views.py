"""Spots on a floor whose map is off in places are where the lines of sight of most photographs cross."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inspection.findings.merging import merged
from inspection.findings.placing import Placed
from inspection.findings.several_views import where_sights_cross

GAP_M, MOST_M, APART_M = 0.08, 8.0, 0.06
FLOOR = np.array((0.0, 0.0, 1.0))
TURNS = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
DISC = 0.05 * np.column_stack((np.cos(TURNS), np.sin(TURNS), 0.0 * TURNS))
AROUND = [np.array((2.0 * np.cos(a), 2.0 * np.sin(a), 2.5)) for a in np.linspace(0.0, 2.0 * np.pi, 7)[:-1]]
"""Where cameras stand about a spot in the origin; 2 m aside and 2.5 m above."""


def seen(middle_m, eye_m, photograph, too_near_m=0.0, kind="rust", area_m2=0.01):
    """A spot that a camera at eye_m sees around middle_m; its line of sight ends too early."""
    points_m = np.asarray(middle_m) + DISC
    times = 1.0 - too_near_m / np.linalg.norm(middle_m - eye_m)
    points_m = eye_m + times * (points_m - eye_m)
    return Placed(kind, points_m, FLOOR, times**2 * area_m2, photograph, times * 1.0, np.asarray(eye_m))


def middles_m(placed):
    return np.array([each.points_m.mean(axis=0) for each in placed])


def test_a_line_of_sight_that_ends_on_a_beam_that_is_not_there_goes_on_to_where_others_meet():
    spots = [seen(np.zeros(3), eye, f"{k}.jpg", 0.9 if k == 2 else 0.0) for k, eye in enumerate(AROUND)]
    assert len(merged(spots, APART_M)) == 2
    (found,) = merged(where_sights_cross(spots, GAP_M, MOST_M), APART_M)
    np.testing.assert_allclose(found.position_m, np.zeros(3), atol=1e-3)
    assert found.area_m2 == pytest.approx(0.01, rel=0.01)
    assert found.length_m == pytest.approx(0.1, abs=0.005)
    assert len(found.photographs) == len(AROUND)


def test_where_the_whole_surface_of_the_map_lies_too_near_the_spot_is_behind_it():
    """No line of sight ends in the right place: they end 0.2 to 0.4 m before it, as on a bump of the map."""
    early_m = (0.2, 0.25, 0.3, 0.35, 0.4, 0.3)
    spots = [seen(np.zeros(3), eye, f"{k}.jpg", m) for k, (eye, m) in enumerate(zip(AROUND, early_m))]
    assert np.linalg.norm(middles_m(spots), axis=1).min() > 0.15
    moved = where_sights_cross(spots, GAP_M, MOST_M)
    np.testing.assert_allclose(middles_m(moved), 0.0, atol=0.01)


def test_a_candidate_that_lies_on_two_surfaces_comes_in_parts():
    """Half of a spot is told on a bar 1 m before it: without the others it would be long, and in between."""
    whole = seen(np.zeros(3), AROUND[0], "half.jpg")
    near = AROUND[0] + 0.7 * (whole.points_m[:8] - AROUND[0])
    split = whole._replace(points_m=np.concatenate((near, whole.points_m[8:])))
    spots = [split] + [seen(np.zeros(3), eye, f"{k}.jpg") for k, eye in enumerate(AROUND[1:])]
    (found,) = merged(where_sights_cross(spots, GAP_M, MOST_M), APART_M)
    assert np.linalg.norm(found.position_m) < 0.02
    assert found.length_m < 0.15


def test_what_turns_out_to_be_too_far_away_is_left_out():
    """A bar that is not there brings a spot near that is 9 m away; others see it from nearer."""
    far = seen(np.zeros(3), np.array((7.0, 0.0, 5.7)), "far.jpg", 4.0)
    spots = [seen(np.zeros(3), eye, f"{k}.jpg") for k, eye in enumerate(AROUND)]
    assert len(merged([*spots, far], APART_M)) == 2
    (found,) = merged(where_sights_cross([*spots, far], GAP_M, MOST_M), APART_M)
    assert "far.jpg" not in found.photographs


def test_its_normal_is_that_of_the_surface_where_it_is():
    spots = [seen(np.zeros(3), eye, f"{k}.jpg") for k, eye in enumerate(AROUND)]
    on_bar = seen(np.zeros(3), AROUND[0], "bar.jpg", 0.9)._replace(normal=np.array((1.0, 0.0, 0.0)))
    *_, moved = where_sights_cross([*spots[1:], on_bar], GAP_M, MOST_M)
    np.testing.assert_allclose(moved.normal, FLOOR, atol=1e-9)


def test_a_crack_stays_where_its_photograph_places_it():
    cracks = [seen(np.zeros(3), eye, f"{k}.jpg", 0.1 * k, "crack") for k, eye in enumerate(AROUND)]
    assert where_sights_cross(cracks, GAP_M, MOST_M) == cracks


def test_nothing_stays_nothing():
    assert where_sights_cross([], GAP_M, MOST_M) == []


def test_spots_of_two_kinds_do_not_meet():
    first = seen(np.zeros(3), AROUND[0], "a.jpg", 0.5)
    second = seen(np.zeros(3), AROUND[2], "b.jpg", kind="blister")
    moved = where_sights_cross([first, second], GAP_M, MOST_M)
    assert {(each.kind, *each.points_m.mean(axis=0).round(6)) for each in moved} == {
        (each.kind, *each.points_m.mean(axis=0).round(6)) for each in (first, second)
    }


def test_one_other_photograph_is_enough_if_it_has_the_spot_there_on_the_surface():
    def off_m(*too_near_m):
        spots = [seen(np.zeros(3), eye, f"{m}.jpg", m) for eye, m in zip(AROUND[::2], too_near_m)]
        return np.linalg.norm(middles_m(where_sights_cross(spots, GAP_M, MOST_M)), axis=1)

    assert off_m(1.5, 0.0).max() < 0.01
    np.testing.assert_allclose(off_m(1.5, 0.9), (1.5, 0.9), atol=0.01)  # the lines may cross by chance
    assert off_m(1.5, 0.9, 1.1).max() < 0.01


spots_apart = st.integers(0, 2**32 - 1)


def many_spots(rng, share_early):
    """Spots on a floor of 12 x 12 m, 1 m apart or more, each in 5 to 8 photographs; with the true middles.

    Of the lines of sight of each, less than this share end too early, by 0.1 to 1.5 m.
    """
    true_m, placed, of = [], [], []
    cells = rng.permutation(36)[:8]
    for cell in cells:
        x_m, y_m = 2.0 * np.array(divmod(cell, 6)) + rng.uniform(-0.5, 0.5, 2)
        middle_m = np.array((x_m, y_m, 0.0))
        views = int(rng.integers(5, 9))
        early = rng.permutation(views) < int(share_early * views)
        turns = 2.0 * np.pi * (np.arange(views) + rng.uniform(-0.3, 0.3, views)) / views
        for turn, is_early in zip(turns, early):
            aside_m = 2.5 * np.array((np.cos(turn), np.sin(turn), 0.0))
            eye_m = middle_m + aside_m + rng.uniform(1.5, 3.0) * FLOOR
            told_m = rng.uniform(-0.02, 0.02, 3)
            name = f"{len(placed)}.jpg"
            placed.append(seen(middle_m + told_m, eye_m + told_m, name, is_early * rng.uniform(0.1, 1.5)))
            of.append(len(true_m))
        true_m.append(middle_m)
    return np.array(true_m)[of], placed


@settings(max_examples=settings.default.max_examples // 2)
@given(spots_apart)
def test_fewer_than_a_third_of_the_lines_of_sight_may_be_wrong(seed):
    true_m, placed = many_spots(np.random.default_rng(seed), 0.33)
    moved = where_sights_cross(placed, GAP_M, MOST_M)
    off_m = np.linalg.norm(middles_m(moved) - true_m, axis=1)
    assert off_m.max() < 0.15  # so near, a finding belongs to a defect


@settings(max_examples=settings.default.max_examples // 4)
@given(spots_apart)
def test_where_the_map_is_right_nothing_moves(seed):
    _, placed = many_spots(np.random.default_rng(seed), 0.0)
    for before, after in zip(placed, where_sights_cross(placed, GAP_M, MOST_M)):
        assert after.points_m.tolist() == before.points_m.tolist()
        assert after.area_m2 == before.area_m2


def corroded(rng):
    """A floor that is all rust in photographs of 1.4 x 1 m, and bits of it that are told apart."""
    placed = []
    for k in range(24):
        low = rng.uniform((0.0, 0.0), (4.0, 2.0))
        x, y = (np.arange(a, a + size, 0.04) for a, size in zip(low, (1.4, 1.0)))
        points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        middle_m = np.append(points.mean(axis=0), 0.0)
        eye_m = middle_m + rng.uniform((-1.5, -1.5, 1.5), (1.5, 1.5, 3.0))
        off_m = rng.uniform(-0.02, 0.02, 3)
        whole = np.column_stack((points, np.zeros(len(points)))) + off_m
        placed.append(Placed("rust", whole, FLOOR, 1.4, f"{k}.jpg", 1.0, eye_m + off_m))
        bit_m = middle_m + np.append(rng.choice((-1.0, 1.0), 2), 0.0) * (0.8, 0.6, 0.0)
        placed.append(seen(bit_m + off_m, eye_m + off_m, f"{k}.jpg"))
    return placed


@settings(max_examples=settings.default.max_examples // 4)
@given(spots_apart)
def test_a_corroded_floor_stays_where_it_is(seed):
    """The middle of what a photograph shows of it says nothing, and lines of sight cross anywhere."""
    placed = corroded(np.random.default_rng(seed))
    moved = where_sights_cross(placed, GAP_M, MOST_M)
    assert len(moved) == len(placed)
    off_m = np.linalg.norm(middles_m(moved) - middles_m(placed), axis=1)
    assert not off_m[::2].any()  # the wide ones
    assert (off_m > 0.15).mean() < 0.05


@settings(max_examples=settings.default.max_examples // 4)
@given(spots_apart)
def test_a_spot_stays_on_its_line_of_sight_and_the_order_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    _, placed = many_spots(rng, 0.5)
    moved = where_sights_cross(placed, GAP_M, MOST_M)
    for before, after in zip(placed, moved):
        a, b = (middles_m([each])[0] - before.eye_m for each in (before, after))
        np.testing.assert_allclose(np.cross(a, b), 0.0, atol=1e-9)
        assert a @ b > 0.0
    order = rng.permutation(len(placed))
    again = where_sights_cross([placed[k] for k in order], GAP_M, MOST_M)
    np.testing.assert_allclose(middles_m(again), middles_m(moved)[order], atol=1e-9)
