"""What moves and would hit a UAV that brakes is evaded."""

import math

import numpy as np
import pytest
from planar_flight import SCAN_EVERY, STEP_S, Scene, Uav, fly, to_goal

from cepa import CepaParameters, Dynamic
from cepa.dynamic.candidates import STANDSTILL, candidates
from cepa.dynamic.constants.response import MEETING_S, PATH_STEP_S
from cepa.dynamic.cost import Cost, limit_progress
from cepa.dynamic.kernels.response import roll
from cepa.dynamic.kernels.rollout import HIT
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, DistanceField, FreeSpace, Surroundings
from cepa.dynamic.rollouts import Rollouts
from cepa.dynamic.threats import evasion_speed

PARAMETERS = CepaParameters()
REFERENCE = np.array([2.0, 0.0, 0.0])
COMMIT_S = 0.1
RNG = np.random.default_rng(1)
COMES_M_S, RADIUS_M, GROWTH_M_S = 2.0, 0.9, 0.2


@pytest.mark.table("own_m_s", [0.0, 1.0])
@pytest.mark.table("off_m", [-0.5, 0.01, 0.5])
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


@pytest.mark.table("off_m", np.arange(-0.7, 0.71, 0.2))
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


def test_who_comes_nearer_is_outrun_up_to_a_limit():
    def alone(x, speed):
        return np.array([[x, 0.0, -speed, 0.0, 0.3, 0.1]])

    assert evasion_speed(alone(6.0, 1.8), 2.0) == pytest.approx(2.7)
    assert evasion_speed(alone(-6.0, 1.8), 2.0) == 2.0  # goes away
    assert evasion_speed(alone(6.0, 1.2), 2.0) == 2.0
    assert evasion_speed(alone(6.0, 8.0), 2.0) == 3.0
    assert evasion_speed(alone(6.0, 8.0), 4.0) == 4.0
    assert evasion_speed(np.empty((0, 6)), 2.0) == 2.0


def test_the_faster_candidates_follow_the_others_and_are_only_there_to_evade():
    usual = candidates(REFERENCE, REFERENCE, 2.0)
    both = candidates(REFERENCE, REFERENCE, 2.0, 3.0)
    assert np.array_equal(candidates(REFERENCE, REFERENCE, 2.0, 2.0), usual)
    assert np.array_equal(both[: len(usual)], usual)
    assert np.hypot(*both[len(usual) :, :2].T) == pytest.approx(3.0)
    # However far they lead, they make no more progress than the best of the others that may be flown
    progress, is_faster = np.array([1.0, 4.0, 6.0, 0.5]), np.array([False, False, True, True])
    limit_progress(progress, 9.0, True, is_faster, np.array([True, False, True, True]))
    assert progress.tolist() == [1.0, 4.0, 1.0, 0.5]
    limit_progress(progress, 9.0, True, is_faster, is_faster)  # nothing else may be flown
    assert progress.tolist() == [1.0, 4.0, 1.0, 0.5]


@pytest.mark.table(("has_end", "farthest_m"), [(True, 0.5), (False, 0.3)])
def test_who_evades_loses_no_more_than_it_is_asked_to_gain(has_end, farthest_m):
    progress = np.array([0.5, -0.2, -4.0])
    limit_progress(progress, 0.4, has_end, np.zeros(3, bool), np.ones(3, bool))
    assert progress == pytest.approx([farthest_m, -0.2, -0.4])


class Runners(Scene):
    """Persons who run along -x; they begin at places (n, 2), and each scan is one period later."""

    def __init__(self, places, speed_m_s):
        super().__init__(np.column_stack((places, np.full(len(places), 0.3))))
        self._speed_m_s = speed_m_s

    def ranges(self, *args, **kwargs):
        self.circles[:, 0] -= self._speed_m_s * SCAN_EVERY * STEP_S
        return super().ranges(*args, **kwargs)


def test_people_abreast_who_are_faster_than_the_uav_do_not_drive_it_before_them():
    # Given seven people side by side, whom a UAV meets that is asked to fly slower than they run
    scene = Runners([(13.0, 1.5 * k - 4.5) for k in range(7)], 2.5)
    # When it flies towards them
    flight = fly(Dynamic(), scene, to_goal((20.0, 0.0)), Uav(velocity=(2.0, 0.0)), RNG, 8.0)
    # Then it gets out of their way, and is far on when they have passed
    assert not flight.contact
    assert flight.path[-1][0] > 10.0


def test_beside_a_runner_the_uav_does_not_fly_faster_than_it_is_asked_to():
    scene = Runners([(12.0, 3.5)], 2.5)
    flight = fly(Dynamic(), scene, to_goal((40.0, 0.0)), Uav(), RNG, 3.0)
    assert np.hypot(*np.array(flight.commands).T).max() < 2.0 + 1e-6
