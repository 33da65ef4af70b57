"""A UAV that wavers is led on: it tries what is narrow, keeps to a side, and tells what leads nowhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa import CepaParameters, Motion
from cepa.dynamic.cost_to_go.course import Course
from cepa.dynamic.cost_to_go.hold_up import HoldUp
from cepa.dynamic.cost_to_go.returns import Returns
from cepa.dynamic.cost_to_go.search import CostToGoSearch
from cepa.dynamic.cost_to_go.side import ChosenSide
from cepa.dynamic.remembered.space_memory import SpaceMemory

LEVEL, STEP_S, SPEED_M_S, WALL_X_M = (0.0, 0.0, 0.0, 1.0), 0.1, 2.0, 5.0
OPEN = np.ones((81, 81))
AHEAD = np.array([0.5, 0.0, 0.0])


def way_m(goal: np.ndarray, gap_m: float) -> tuple[float, float]:
    """Return how far a UAV flies to a goal behind a wall of 30 m, m, and where it passes the wall, m.

    The UAV is a point that flies along the way out; of the wall it knows what is within 10 m.
    """
    search, place, passed_y = CostToGoSearch(CepaParameters()), np.zeros(2), math.nan
    wall = np.column_stack((np.full(601, WALL_X_M), np.linspace(-15.0, 15.0, 601)))
    wall = wall[np.abs(wall[:, 1]) >= 0.5 * gap_m]
    flown_m, step_m = 0.0, STEP_S * SPEED_M_S
    while math.dist(place, goal) > 1.0 and flown_m < 120.0:
        near = wall - place
        near = near[np.hypot(*near.T) < 10.0]
        asked, motion = goal - place, Motion(flown_m / SPEED_M_S, (*place, 2.0), LEVEL, (0.0, 0.0, 0.0))
        found = search.search(near, Course(asked / np.hypot(*asked)), motion).cost_to_go
        place, flown_m = place + step_m * downhill(found.length[0]), flown_m + step_m
        if math.isnan(passed_y) and place[0] > WALL_X_M:
            passed_y = float(place[1])
    return flown_m, passed_y


@pytest.mark.table("goal_y", [-2.0, 3.0])
def test_a_wall_longer_than_the_window_is_gone_around(goal_y):
    # Straight to an end, along the other side and to the goal: 16 m, and 20 m at most; twice for wavering
    flown_m, passed_y = way_m(np.array([12.0, goal_y]), 0.0)
    assert flown_m < 80.0
    assert abs(passed_y) > 15.0


@pytest.mark.table("gap_m", [0.9, 0.97])
def test_a_gap_that_fits_is_passed_though_both_ends_of_the_wall_look_open(gap_m):
    flown_m, passed_y = way_m(np.array([12.0, 0.5]), gap_m)
    assert flown_m < 40.0
    assert abs(passed_y) < 0.5


def downhill(length: np.ndarray) -> np.ndarray:
    """Return the unit vector in which the way out gets shorter, over two cells."""
    middle = len(length) // 2
    steps = [(i, j) for i in range(-2, 3) for j in range(-2, 3) if max(abs(i), abs(j)) == 2]
    slopes = [(length[middle, middle] - length[middle + i, middle + j]) / math.hypot(i, j) for i, j in steps]
    i, j = steps[int(np.argmax(slopes))]
    return np.array([j, i]) / math.hypot(i, j)


def returns_of(places) -> list[float]:
    """Return the stamps at which a UAV that is at places (n, 2) one after the other has come back."""
    returns = Returns()
    return [STEP_S * k for k, (x, y) in enumerate(places) if returns.meets(STEP_S * k, x, y)]


def test_a_uav_that_flies_on_does_not_come_back():
    angles = np.linspace(0.0, 1.5 * math.pi, 200)
    assert returns_of([(0.2 * k, 0.0) for k in range(200)]) == []
    assert returns_of(5.0 * np.column_stack((np.cos(angles), np.sin(angles)))) == []


def test_who_leaves_a_dead_end_comes_back_once_and_who_wavers_each_time():
    there_and_back = [*np.arange(0.0, 8.0, 0.2), *np.arange(8.0, 0.0, -0.2)]
    assert len(returns_of([(x, 0.0) for x in there_and_back])) == 1
    assert len(returns_of([(x, 0.0) for x in 3 * there_and_back])) >= 4


def test_a_hover_that_is_asked_for_ends_the_trail():
    returns = Returns()
    for k, x in enumerate(np.arange(0.0, 8.0, 0.2)):
        assert not returns.meets(STEP_S * k, x, 0.0)
    for k, x in enumerate(np.arange(8.0, 0.0, -0.2)):  # the way home, after it has hovered
        assert not returns.meets(60.0 + STEP_S * k, x, 0.0)


@pytest.mark.table(
    ("hovers_s", "clear_s", "is_same"), [(0.0, 2.0, True), (0.0, 4.0, False), (1.0, 2.0, False)]
)
def test_a_short_clear_way_does_not_end_the_trail_and_a_long_one_or_a_hover_does(hovers_s, clear_s, is_same):
    # It flies 8 m there, hovers, flies clear ways, and flies back
    returns, places = Returns(), np.arange(0.0, 8.0, 0.2)
    for k, x in enumerate(places):
        returns.meets(STEP_S * k, x, 0.0)
    until_s = STEP_S * len(places) + hovers_s
    for k in range(round(clear_s / STEP_S)):
        returns.fly_clear(until_s + STEP_S * k)
    back = [returns.meets(until_s + clear_s + STEP_S * k, x, 0.0) for k, x in enumerate(places[::-1])]
    assert any(back) == is_same


def test_a_side_is_kept_from_the_second_return_on_until_the_straight_way_is_open():
    side, straight = ChosenSide(), Course(np.array([1.0, 0.0]))
    side.choose(1, (0.0, 1.0), 0.0)
    assert not side.is_chosen
    side.choose(2, (0.0, 1.0), 0.0)
    closed = OPEN.copy()
    closed[:, 40 + 20] = math.inf  # a wall 5 m ahead
    assert side.course(closed, straight, 1.0).direction.tolist() == [0.0, 1.0]
    assert side.course(OPEN, straight, 2.0) is straight
    assert not side.is_chosen


def test_a_side_is_given_up_after_its_time_or_near_the_end():
    closed = OPEN.copy()
    closed[:, 40 + 20] = math.inf
    for end, stamp_s in ((np.full(2, math.inf), 91.0), (np.array([3.0, 0.0]), 1.0)):
        side, course = ChosenSide(), Course(np.array([1.0, 0.0]), end)
        side.choose(2, (0.0, 1.0), 0.0)
        assert side.course(closed, course, stamp_s) is course


def told_by(moves_m_s: float, is_asked: bool, until_s: float) -> list[str]:
    hold_up = HoldUp()
    times = np.arange(0.0, until_s, STEP_S)
    return [s for t in times for s in hold_up.take_in(t, (moves_m_s * t, 0.0, 2.0), AHEAD, is_asked, 0)]


def test_a_uav_that_gets_nowhere_is_told_once():
    (sentence,) = told_by(0.0, True, 30.0)
    assert "has stayed within 0.5 m for 10 s" in sentence
    assert "planner:=true" in sentence
    assert told_by(0.0, False, 30.0) == told_by(0.1, True, 30.0) == []


def test_a_uav_that_flies_all_that_it_is_asked_to_within_a_small_space_is_not_held_up():
    # Given one that flies to and fro between two photographs, 0.4 m apart, and hovers 4 s at each
    hold_up, x = HoldUp(), 0.0
    for number in range(round(60.0 / STEP_S)):
        t = number * STEP_S
        goal = 0.4 * (int(t / 4.0) % 2)
        reference = np.array([1.0 * (goal - x) + 0.06 * math.copysign(1.0, math.sin(5.0 * t)), 0.0, 0.0])
        assert hold_up.take_in(t, (x, 0.0, 2.0), reference, True, 0) == ()
        x += reference[0] * STEP_S
    assert not hold_up.is_held


def test_a_slow_reference_that_is_not_flown_is_told_when_it_has_asked_for_a_metre():
    hold_up, slow = HoldUp(), np.array([0.06, 0.0, 0.0])
    times = np.arange(0.0, 30.0, STEP_S)
    (told_s,) = [t for t in times if hold_up.take_in(t, (0.0, 0.0, 2.0), slow, True, 0)]
    assert told_s == pytest.approx(1.0 / 0.06, abs=2.0 * STEP_S)


def test_a_uav_that_does_not_fly_is_not_held_up_and_its_time_begins_when_it_flies():
    """It waits for its take-off, flies, stands for a swap of its battery, and gets nowhere afterwards."""
    hold_up = HoldUp()
    told = []
    for t in np.arange(0.0, 100.0, STEP_S):
        hold_up.is_ready = 30.0 <= t < 38.0 or t >= 60.0
        told += [(t, s) for s in hold_up.take_in(t, (0.0, 0.0, 0.1), AHEAD, True, 4 if t < 60.0 else 0)]
        assert hold_up.is_ready or hold_up.held_s == 0.0
    (back_s, back), (held_s, held) = told
    assert (back_s, held_s) == pytest.approx((30.0, 70.0), abs=2.0 * STEP_S)
    assert "come back" in back
    assert "stayed within" in held


def test_each_further_return_is_told_from_the_third_on():
    hold_up = HoldUp()
    told = [hold_up.take_in(float(k), (5.0 * k, 0.0, 2.0), AHEAD, True, min(k, 4)) for k in range(8)]
    assert [len(sentences) for sentences in told] == [0, 0, 0, 1, 1, 0, 0, 0]
    assert "3 times in 120 s" in told[3][0]


@pytest.mark.table("is_held", [False, True])
def test_what_is_near_and_out_of_view_grows_old_only_while_the_uav_is_held_up(is_held):
    # Given something 1 m beside the UAV, which no beam meets any more, and behind which none ends
    memory = SpaceMemory(CepaParameters(memory_s=20.0))
    known = []
    for t in np.arange(0.0, 25.0, 0.5).tolist():
        motion = Motion(t, (5.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
        ends = np.array([[1.0, 0.0, 0.0]]) if t == 0.0 else np.empty((0, 3))
        space = memory.take_in(None, motion, beam_ends=ends, is_held=is_held and t > 2.0)
        known.append(len(space.points))
    # Then it is forgotten after memory_s, but only if it may be what holds the UAV up
    assert known[0] == known[42] == 1
    assert known[-1] == (0 if is_held else 1)
