"""What moves and would hit a UAV that brakes is evaded."""

import math

import numpy as np
import pytest

from cepa import CepaParameters
from cepa.dynamic.candidates import STANDSTILL, candidates
from cepa.dynamic.constants.response import MEETING_S, PATH_STEP_S
from cepa.dynamic.cost import Cost
from cepa.dynamic.kernels.response import roll
from cepa.dynamic.kernels.rollout import HIT
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, DistanceField, FreeSpace, Surroundings
from cepa.dynamic.rollouts import Rollouts

PARAMETERS = CepaParameters()
REFERENCE = np.array([2.0, 0.0, 0.0])
COMMIT_S = 0.1
COMES_M_S, RADIUS_M, GROWTH_M_S = 2.0, 0.9, 0.2


@pytest.mark.parametrize("own_m_s", [0.0, 1.0])
@pytest.mark.parametrize("off_m", [-0.5, 0.01, 0.5])
def test_what_comes_head_on_is_evaded_whatever_progress_that_costs(own_m_s, off_m):
    # Given a UAV that braking does not save
    mover = np.array([[4.5, off_m, -COMES_M_S, 0.0, RADIUS_M, GROWTH_M_S]])
    field = DistanceField(np.full((1, 151, 151), 1.3), 0.1, 1.0, 1.3)
    free_space = FreeSpace(np.full(360, 9.0), np.empty((0, 0, 0), np.uint8), 1.0)
    around = Surroundings(field, free_space, mover, NO_COST_TO_GO)
    state = np.zeros((3, 4))
    state[0, 1] = own_m_s
    commands, rollouts = candidates(REFERENCE, REFERENCE, 2.0), Rollouts(PARAMETERS)
    # When it chooses the least costly of the admissible commands
    admissible, results, *_ = rollouts.assess(commands, state, around, REFERENCE[:2] / 2.0, COMMIT_S)
    cost = Cost(PARAMETERS).of(commands, results, REFERENCE, 2.0, own_m_s)
    cost[~admissible] = math.inf
    best = commands[np.argmin(cost)]
    # Then flying on with it keeps the hull away from where the mover will be
    path = np.empty((round(MEETING_S / PATH_STEP_S), 3))
    roll(state, best, rollouts.response, len(path), path)
    t_s = PATH_STEP_S * np.arange(1, len(path) + 1)
    apart_m = np.hypot(path[:, 0] - (4.5 - COMES_M_S * t_s), path[:, 1] - off_m)
    assert (apart_m - RADIUS_M - GROWTH_M_S * t_s).min() > PARAMETERS.body_radius
    assert admissible[STANDSTILL]
    assert results[STANDSTILL, HIT] > 0.0


def open_field(movers):
    field = DistanceField(np.full((1, 151, 151), 1.3), 0.1, 1.0, 1.3)
    free_space = FreeSpace(np.full(360, 9.0), np.empty((0, 0, 0), np.uint8), 1.0)
    return Surroundings(field, free_space, np.array(movers), NO_COST_TO_GO)


@pytest.mark.parametrize("off_m", np.arange(-0.7, 0.71, 0.2))
def test_in_which_direction_it_may_leave_does_not_depend_on_who_of_a_group_is_before_it(off_m):
    # Given seven people abreast, 1.4 m apart, who hit a UAV that brakes from 3 m/s
    around = open_field([(6.1, off_m + 1.4 * k, -1.7, 0.0, 0.4, 0.5) for k in range(-3, 4)])
    state = np.zeros((3, 4))
    state[0, 1] = 3.0
    sideways = np.array([[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, -4.0, 0.0]])
    # When it looks to both sides; Then it may fly there
    assessed = Rollouts(PARAMETERS).assess(sideways, state, around, REFERENCE[:2] / 2.0, COMMIT_S)
    assert assessed.outcomes[0, HIT] > 0.0
    assert assessed.is_admissible.all()
