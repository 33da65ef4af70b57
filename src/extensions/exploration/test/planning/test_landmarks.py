"""A UAV whose lidar sees a little way stays where it meets something."""

import dataclasses
import math

import numpy as np
import pytest
from drawn_voxels import SIDE, block, planner_on, tiles_of, voxels_on
from hypothesis import given
from hypothesis import strategies as st

from exploration.planning import PathPlanner, PlannerParameters
from flight_basics.errors import NoPathError

NEAR = PlannerParameters(radius=1.4, margin=0.0, comfort=0.0, preference=0.0, landmark_reach=4.0)
"""Voxels have 1 m."""
ANYWHERE = dataclasses.replace(NEAR, landmark_reach=0.0)


def pool():
    """A free place of 30 x 30 x 9 m with walls at its ends along x, 1 m thick."""
    kinds = block(9, 30, 30)
    kinds[:, :, [0, 29]] = 2
    return kinds


def with_wall_at_the_back():
    kinds = pool()
    kinds[:, 0, :] = 2
    return kinds


def test_the_way_leads_along_the_walls():
    start, goal = np.array((3.5, 15.5, 4.5)), np.array((26.5, 15.5, 4.5))
    kinds = with_wall_at_the_back()
    straight = planner_on(kinds, ANYWHERE).plan(start, goal)
    assert straight.length_m == pytest.approx(23.0)
    around = planner_on(kinds, NEAR).plan(start, goal).points_m
    x, y, _ = voxels_on(around).T[::-1]
    assert (np.minimum(np.minimum(x, 29 - x), y) <= 4).all()


def test_a_goal_in_the_middle_is_refused():
    planner = planner_on(pool(), NEAR)
    with pytest.raises(NoPathError, match="too far from all that tells the lidar where it is"):
        planner.plan((3.5, 15.5, 4.5), (15.5, 15.5, 4.5))
    with pytest.raises(NoPathError, match=r"comes closest .* too far from all that tells the lidar"):
        planner.plan((3.5, 15.5, 4.5), (26.5, 15.5, 4.5))


def test_what_stands_higher_or_lower_does_not_count():
    kinds = with_wall_at_the_back()
    kinds[:4, 14:17, 14:17] = 2
    low, high = (15.5, 19.5, 2.5), (15.5, 19.5, 6.5)
    planner = planner_on(kinds, NEAR)
    assert planner.space(0.0, low).is_clear(low, low)
    with pytest.raises(NoPathError, match="too far from all"):
        planner.plan((3.5, 3.5, 6.5), high)


def test_a_post_is_no_wall():
    kinds = np.repeat(np.repeat(np.repeat(pool(), 2, 0), 2, 1), 2, 2)  # in voxels of 0.5 m
    kinds[:, 30, 30] = 2
    at_post = np.array((15.25, 14.25, 4.5))
    for length, is_wall in ((1, False), (2, True)):
        kinds[:, 30, 30 : 30 + length] = 2
        space = planner_on(kinds, NEAR, 0.5).space(0.0, (3.5, 15.5, 4.5))
        assert (space.far is not None and not space.far[space.grid.index_of(at_post)]) is is_wall


def test_from_too_far_away_it_may_come_nearer_but_not_go_farther():
    planner = planner_on(pool(), NEAR)
    start = np.array((9.5, 15.5, 4.5))
    assert planner.plan(start, (3.5, 15.5, 4.5)).length_m == pytest.approx(6.0)
    with pytest.raises(NoPathError):
        planner.plan(start, (13.5, 15.5, 4.5))


def test_where_nothing_was_ever_seen_it_flies_anywhere():
    planner = planner_on(block(9, 30, 30), NEAR)
    assert planner.plan((3.5, 15.5, 4.5), (26.5, 15.5, 4.5)).length_m == pytest.approx(23.0)


def test_what_is_seen_later_counts_at_once():
    planner = planner_on(pool(), NEAR)
    start, goal = (3.5, 15.5, 4.5), (26.5, 15.5, 4.5)
    with pytest.raises(NoPathError):
        planner.plan(start, goal)
    planner.update_map(1.0, SIDE, *tiles_of(with_wall_at_the_back()))
    assert planner.plan(start, goal).length_m > 23.0
    planner.parameters = ANYWHERE
    assert planner.plan(start, goal).length_m == pytest.approx(23.0)


@st.composite
def rooms(draw):
    """Kinds (6, 14, 14): free, with walls of any length."""
    kinds = block(6, 14, 14)
    for _ in range(draw(st.integers(0, 4))):
        low = [draw(st.integers(0, size - 1)) for size in kinds.shape]
        size = [draw(st.integers(1, 6)) for _ in kinds.shape]
        kinds[tuple(slice(a, a + b) for a, b in zip(low, size))] = 2
    return kinds


def away_of(kinds):
    """Slow and obvious: from each voxel to the nearest occupied one of its layer. One alone has 1 m."""
    away = np.full(kinds.shape, math.inf)
    for z, y, x in np.ndindex(kinds.shape):
        for b, a in np.argwhere(kinds[z] == 2):
            away[z, y, x] = min(away[z, y, x], math.hypot(b - y, a - x))
    return away


places = st.tuples(*(st.floats(0.01, size - 0.01) for size in (14, 14, 6)))


@given(kinds=rooms(), start=places, goal=places, reach=st.floats(1.5, 8.0))
def test_no_path_goes_farther_away_than_its_reach_or_its_start(kinds, start, goal, reach):
    planner = PathPlanner(dataclasses.replace(NEAR, radius=0.5, landmark_reach=reach))
    planner.update_map(1.0, SIDE, *tiles_of(kinds))
    try:
        points_m = planner.plan(start, goal).points_m
    except NoPathError:
        return
    away, passed = away_of(kinds), voxels_on(points_m)
    begin = away[tuple(np.floor(start).astype(int)[::-1])]
    most = reach if begin <= reach else begin + math.sqrt(2.0)
    assert (away[tuple(passed.T)] <= most + 1e-4).all()
