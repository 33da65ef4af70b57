"""What moves counts only if the UAV may meet it, and does not make it fly past its place."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cepa import CepaParameters
from cepa.dynamic.candidates import candidates
from cepa.dynamic.constants.choice import EVASION_M_S
from cepa.dynamic.constants.response import MEETING_S
from cepa.dynamic.cost import Cost, limit_progress
from cepa.dynamic.kernels.rollout import HIT, PROGRESS
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, DistanceField, FreeSpace, Surroundings
from cepa.dynamic.rollouts import Rollouts
from cepa.dynamic.threats import are_within, arrives_in_s, as_seen, fronts, is_within, threats

PARAMETERS = CepaParameters()
OPEN_FIELD = DistanceField(np.full((1, 151, 151), 1.3), 0.1, 1.0, 1.3)
OPEN_SPACE = FreeSpace(np.full(360, 9.0), np.empty((0, 0, 0), np.uint8), 1.0)
COMMIT_S = 0.1
NO_MOVERS = np.empty((0, 6))


def around(movers):
    return Surroundings(OPEN_FIELD, OPEN_SPACE, movers, NO_COST_TO_GO)


def moving_at(speed):
    state = np.zeros((3, 4))
    state[0, 1] = speed
    return state


coordinates, speeds = st.floats(-25.0, 25.0), st.floats(-4.0, 4.0)
a_mover = st.tuples(coordinates, coordinates, speeds, speeds, st.floats(0.0, 5.0), st.floats(0.0, 1.5))
NEAR_MOVER = (3.0, 0.0, -0.5, 0.0, 0.3, 0.1)
"""With it, paths are foreseen as far as whenever something moves."""


@given(st.lists(a_mover, max_size=4), st.floats(0.0, 2.0), st.floats(0.1, 2.0), st.floats(-math.pi, math.pi))
def test_what_is_left_out_changes_no_answer(movers, own_speed, reference_speed, heading_rad):
    # Given things that move, and one near the UAV
    movers = np.array([NEAR_MOVER, *movers])
    reference = reference_speed * np.array([math.cos(heading_rad), math.sin(heading_rad), 0.0])
    fastest = max(EVASION_M_S, reference_speed, own_speed)
    commands, rollouts = candidates(reference, reference, fastest), Rollouts(PARAMETERS)
    # When commands are judged by all of them, and by those that the UAV may meet
    met = threats(movers, fastest, PARAMETERS.r_ub)
    state, direction = moving_at(own_speed), reference[:2] / reference_speed
    by_all, by_met = (
        rollouts.assess(commands, state, around(each), direction, COMMIT_S) for each in (movers, met)
    )
    # Then nothing differs
    assert np.array_equal(by_all.is_admissible, by_met.is_admissible)
    assert np.array_equal(by_all.outcomes, by_met.outcomes)


def test_a_wall_that_seems_to_move_far_away_is_no_threat():
    far = np.array([[-20.0, 12.5, 1.6, -1.9, 4.5, 0.8]])
    assert len(threats(far, EVASION_M_S, PARAMETERS.r_ub)) == 0
    assert len(threats(0.4 * far, EVASION_M_S, PARAMETERS.r_ub)) == 1
    assert len(threats(NO_MOVERS, EVASION_M_S, PARAMETERS.r_ub)) == 0


@pytest.mark.table("last_m_s", [0.0, 0.2, 1.5])
def test_beside_what_moves_the_uav_does_not_hurry(last_m_s):
    # Given a slow reference, as at the end of a way, and something that moves but will not meet the UAV
    reference, last = np.array([0.2, 0.0, 0.0]), np.array([last_m_s, 0.0, 0.0])
    mover = np.array([[-4.0, 6.0, 0.0, -0.5, 0.3, 0.1]])
    commands, rollouts = candidates(reference, last, EVASION_M_S), Rollouts(PARAMETERS)
    # When it chooses the least costly command
    assessed = rollouts.assess(commands, moving_at(last_m_s), around(mover), np.array([1.0, 0.0]), COMMIT_S)
    outcomes = assessed.outcomes
    none_is, all_are = np.zeros(len(commands), bool), np.ones(len(commands), bool)
    limit_progress(outcomes[:, PROGRESS], 0.2 * MEETING_S, False, none_is, all_are)
    cost = Cost(PARAMETERS).of(commands, outcomes, last, 0.2, last_m_s)
    best = commands[np.argmin(np.where(assessed.is_admissible, cost, math.inf))]
    # Then it does not fly past the place that it is led to, though it might fly so fast to evade
    assert np.hypot(*best[:2]) <= 0.6 * EVASION_M_S


def person(x, y, vx=-1.4, vy=0.0):
    return (x, y, vx, vy, 0.4, 0.3)


def test_a_group_closes_what_is_between_and_the_way_that_it_comes():
    # Given three people abreast, 1.1 m apart, 6 m ahead
    points = fronts(np.array([person(6.0, y) for y in (-1.1, 0.0, 1.1)]))
    # Then no body fits between the points, from where the people are until 1.2 m before the UAV
    for x in np.arange(6.0 - 3.0 * 1.4, 6.0, 0.2):
        for y in np.arange(-1.1, 1.2, 0.1):
            assert np.hypot(*(points - (x, y)).T).min() < 0.35
    assert points[:, 0].min() > 1.2 - 0.3 - 1e-6
    assert np.abs(points[:, 1]).max() == pytest.approx(1.1)


@pytest.mark.table(
    "movers",
    [
        [person(6.0, 0.0)],
        [person(6.0, -2.0), person(6.0, 2.0)],  # a gap of 3.2 m
        [person(6.0, -0.6), person(6.0, 0.6, vx=1.4)],  # they pass each other
    ],
)
def test_who_moves_alone_closes_no_way(movers):
    assert not len(fronts(np.array(movers)))


def test_a_group_that_has_passed_closes_only_its_place():
    points = fronts(np.array([person(-2.0, 0.0), person(-2.0, 1.1)]))
    assert points[:, 0].min() > -2.0 - 0.31


def test_what_arrives_soonest_counts_from_above_and_from_below_where_the_body_is():
    columns = np.array([[1.0, 0, 0, 0, 0.8, 0, 4.0, 1.0], [0.0, 0, 0, 0, 1.0, 0, 2.0, -1.0]])
    assert arrives_in_s(columns, 0.35) == (4.0, 2.0)
    assert arrives_in_s(columns, 0.1) == (math.inf, 2.0)
    assert arrives_in_s(columns[:0], 0.35) == (math.inf, math.inf)


def test_movers_with_their_middle_in_a_column_are_within_it():
    columns = np.array([[1.0, 0, 0, 0, 0.5, 0, 4.0, 1.0], [9.0, 0, 0, 0, 0.5, 0, 4.0, 1.0]])
    movers = np.array([[1.4, 0.0, 0, 0, 0.3, 0], [1.6, 0.0, 0, 0, 0.3, 0], [9.0, 0.4, 0, 0, 0.3, 0]])
    assert are_within(movers, columns).tolist() == [True, False, True]
    assert are_within(movers[:0], columns).tolist() == []
    assert are_within(movers, columns[:0]).tolist() == [False] * 3


def test_the_uav_is_within_a_disc_that_holds_its_place():
    assert is_within(np.array([[1.0, 0.0, 0.0, 0.0, 1.1, 0.0]]))
    assert not is_within(np.array([[1.0, 0.0, 0.0, 0.0, 0.9, 0.0]]))
    assert not is_within(NO_MOVERS)


def people_abreast():
    """Return the points (m, 2) that a scan shows of five people abreast, 2.5 m ahead."""
    arc_rad = np.linspace(0.6 * math.pi, 1.4 * math.pi, 15)
    front = 0.3 * np.column_stack((np.cos(arc_rad), np.sin(arc_rad)))
    return np.concatenate([front + np.array((2.8, y)) for y in (-1.6, -0.8, 0.0, 0.8, 1.6)])


def test_where_the_disc_of_people_abreast_reaches_the_uav_it_flies_away_from_what_it_sees():
    commands = np.array([[0.0, 0.0, 0.0], [-2.5, 0.0, 0.0]])
    disc = around(np.array([[2.8, 0.0, -1.5, 0.0, 2.0, 0.4]]))
    flown = commands, np.zeros((3, 4)), disc, np.zeros(2), COMMIT_S
    rollouts = Rollouts(PARAMETERS)
    unseen = rollouts.assess_passing(*flown, np.empty((0, 2)))
    assert not unseen.passes
    assessed = rollouts.assess_passing(*flown, people_abreast())
    assert (assessed.outcomes[:, HIT] > 0.0).tolist() == [True, False]


@given(a_mover, st.floats(0.0, 0.3))
def test_discs_hold_all_that_the_scan_shows_and_move_alike(mover, delay_s):
    near = people_abreast()
    points = np.concatenate((near, near + np.array((30.0, 0.0))))
    discs = as_seen(np.array([mover]), points, delay_s)
    assert (discs[:, 2:4] == mover[2:4]).all()
    assert not discs[:, 5].any()
    way_m = delay_s * np.array(mover[2:4])
    own = points[np.hypot(*(points - mover[:2] + way_m).T) < mover[4]]
    apart_m = np.hypot(*(own[:, None] + way_m - discs[:, :2]).transpose(2, 0, 1))
    assert (apart_m.min(axis=1) <= discs[0, 4]).all()


def test_who_is_out_of_sight_keeps_the_disc():
    mover = (3.0, 1.0, -1.0, 0.0, 0.5, 0.4)
    assert as_seen(np.array([mover]), people_abreast() + 9.0, 0.1).tolist() == [[*mover[:5], 0.0]]


def test_who_walks_through_the_column_of_a_load_does_not_take_its_place():
    column = (2.8, 0.0, 0.0, 0.0, 1.5, 0.0)
    assert as_seen(np.array([column]), people_abreast(), 0.1).tolist() == [list(column)]
