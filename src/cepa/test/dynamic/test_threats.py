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
from cepa.dynamic.cost import Cost, progress_as_asked
from cepa.dynamic.kernels.rollout import PROGRESS
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, DistanceField, FreeSpace, Surroundings
from cepa.dynamic.rollouts import Rollouts
from cepa.dynamic.threats import threats

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


@pytest.mark.parametrize("last_m_s", [0.0, 0.2, 1.5])
def test_beside_what_moves_the_uav_does_not_hurry(last_m_s):
    # Given a slow reference, as at the end of a way, and something that moves but will not meet the UAV
    reference, last = np.array([0.2, 0.0, 0.0]), np.array([last_m_s, 0.0, 0.0])
    mover = np.array([[-4.0, 6.0, 0.0, -0.5, 0.3, 0.1]])
    commands, rollouts = candidates(reference, last, EVASION_M_S), Rollouts(PARAMETERS)
    # When it chooses the least costly command
    assessed = rollouts.assess(commands, moving_at(last_m_s), around(mover), np.array([1.0, 0.0]), COMMIT_S)
    outcomes = assessed.outcomes
    outcomes[:, PROGRESS] = progress_as_asked(outcomes[:, PROGRESS], 0.2 * MEETING_S)
    cost = Cost(PARAMETERS).of(commands, outcomes, last, 0.2, last_m_s)
    best = commands[np.argmin(np.where(assessed.is_admissible, cost, math.inf))]
    # Then it does not fly past the place that it is led to, though it might fly so fast to evade
    assert np.hypot(*best[:2]) <= 0.6 * EVASION_M_S
