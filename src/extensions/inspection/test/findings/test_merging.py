"""Rust that no single photograph shows whole: its area and its pieces, from areas that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inspection.findings.merging import CELL_M, PIECE_M, merged
from inspection.findings.placing import Placed

APART_M, STEP_M = 0.06, 0.02
WALL, EYE_M = np.array((0.0, 1.0, 0.0)), np.array((2.0, 0.0, 1.0))


def rust(low, high, photograph, off_m=(0.0, 0.0, 0.0), kind="rust"):
    """Rust that fills a part of a wall at y = 2 m, from low to high (x, z), in a photograph."""
    x, z = (np.arange(a + 0.5 * STEP_M, b, STEP_M) for a, b in zip(low, high))
    points = np.stack(np.meshgrid(x, z), -1).reshape(-1, 2)
    points_m = np.column_stack((points[:, 0], np.full(len(points), 2.0), points[:, 1])) + off_m
    return Placed(kind, points_m, WALL, STEP_M**2 * len(points), photograph, 1.0, EYE_M)


def area_m2(findings):
    return sum(each.area_m2 for each in findings)


def test_a_corroded_wall_has_the_area_that_all_its_photographs_show_together():
    # Given rust on 4.4 x 1.6 m, and photographs that end within it
    windows = {"a.jpg": (0.3, 2.0), "b.jpg": (1.6, 3.4), "c.jpg": (3.0, 4.7)}
    found = merged([rust((a, 0.2), (b, 1.8), name) for name, (a, b) in windows.items()], APART_M)
    # Then up to 0.06 m beside the end of each is not counted
    assert area_m2(found) == pytest.approx(4.4 * 1.6, rel=0.03)
    places_m = [np.array(each.places_m) for each in found]
    assert all(np.ptp(each, axis=0).max() <= PIECE_M for each in places_m)
    assert [each.id for each in found] == list(range(1, len(found) + 1))
    # And each piece is told by its own places and photographs
    for each, own_m in zip(found, places_m):
        np.testing.assert_allclose(each.position_m, 0.5 * (own_m.min(0) + own_m.max(0)), atol=CELL_M)
    assert {name for each in found for name in each.photographs} == set(windows)
    assert any(each.photographs == ("a.jpg",) for each in found)


@settings(max_examples=settings.default.max_examples // 2)
@given(st.integers(0, 2**32 - 1))
def test_poses_that_are_off_and_any_number_of_photographs_change_the_area_little(seed):
    rng = np.random.default_rng(seed)
    placed = []
    for k, x in enumerate(np.arange(0.0, 5.0, rng.uniform(0.4, 1.0))):
        window = max(x, 0.5), min(x + 1.5, 4.5)
        if window[1] > window[0] + STEP_M:
            placed.append(rust((window[0], 0.0), (window[1], 1.5), f"{k}.jpg", 0.01 * rng.standard_normal(3)))
    assert area_m2(merged(placed, APART_M)) == pytest.approx(4.0 * 1.5, rel=0.08)


def test_a_spot_in_many_photographs_counts_once_and_is_one_finding_also_across_a_whole_metre():
    spots = [rust((0.9, 0.9), (1.1, 1.1), f"{k}.jpg", (0.01 * k, 0.0, 0.0)) for k in range(4)]
    (found,) = merged(spots, APART_M)
    assert found.area_m2 == pytest.approx(0.04)
    assert len(found.photographs) == 4


def test_a_long_crack_stays_one_and_tells_its_places():
    (found,) = merged([rust((0.0, 1.0), (2.6, 1.0 + STEP_M), "a.jpg", kind="crack")], APART_M)
    assert found.length_m == pytest.approx(2.6, abs=2 * STEP_M)
    assert np.ptp(np.array(found.places_m)[:, 0]) == pytest.approx(2.6, abs=0.1)


@pytest.mark.table(("off_m", "count"), [(0.01, 4), (0.5, 2)])
def test_spots_of_two_photographs_are_one_as_far_apart_as_the_poses_may_be_wrong(off_m, count):
    """Two spots, 0.9 m apart; the second photograph shows both 0.4 m beside."""
    at_m = ((0.0, 0.0), (0.9, 0.0))
    spots = [
        rust((x + moved, z), (x + moved + 0.1, z + 0.1), name)._replace(off_m=off_m)
        for name, moved in (("a.jpg", 0.0), ("b.jpg", 0.4))
        for x, z in at_m
    ]
    found = merged(spots, APART_M)
    assert len(found) == count
    assert [each.deviation_m for each in found] == [off_m] * count
    if count == 2:  # each photograph shows two spots, so there are two
        assert all(each.photographs == ("a.jpg", "b.jpg") for each in found)
        assert sorted(each.position_m[0] for each in found) == pytest.approx([0.05, 0.95], abs=0.011)
        assert [each.area_m2 for each in found] == pytest.approx(
            [0.01] * 2
        )  # each is one spot of 0.1 x 0.1 m


@pytest.mark.table(("x", "normal"), [(0.4, -WALL), (2.0, WALL)])
def test_the_other_side_of_a_plate_and_what_lies_far_away_is_another_spot_however_unsure_the_pose(x, normal):
    one, other = (
        rust((at, 0.0), (at + 0.1, 0.1), name)._replace(off_m=1000.0, normal=facing)
        for name, at, facing in (("a.jpg", 0.0, WALL), ("b.jpg", x, normal))
    )
    assert len(merged([one, other], APART_M)) == 2


def test_the_surest_photograph_tells_the_place():
    sure, unsure = (
        rust((x, 0.0), (x + 0.1, 0.1), name)._replace(off_m=off_m)
        for name, x, off_m in (("a.jpg", 0.0, 0.02), ("b.jpg", 0.6, 1.0))
    )
    (found,) = merged([unsure, sure], APART_M)
    assert found.position_m == pytest.approx((0.05, 2.0, 0.05), abs=0.011)
    assert found.deviation_m == 0.02
