"""A trunk beside the way is passed where the way is wide: no corner is cut for a little progress."""

import math

import numpy as np
import pytest
from planar_flight import BODY_RADIUS_M, Scene, Uav, fly, to_goal

from cepa import CepaParameters, Dynamic
from cepa.dynamic.constants.cost_to_go import SLOWER
from cepa.dynamic.kernels.rollout import PROGRESS
from cepa.dynamic.kernels.surroundings import CostToGo, DistanceField, FreeSpace, Surroundings
from cepa.dynamic.rollouts import Rollouts, cost_horizon_s

PARAMETERS = CepaParameters()
NOTHING_MOVES, ALL_SEEN = np.empty((0, 6)), FreeSpace(np.full(360, 9.0), np.empty((0, 0, 0), np.uint8), 1.0)
FOREST = np.array(
    [
        (26.81, -0.07, 0.297),
        (28.12, -3.05, 0.289),
        (29.86, 2.81, 0.299),
        (30.97, -1.07, 0.272),
        (32.21, -3.49, 0.184),
        (32.28, 1.63, 0.251),
        (34.81, -3.81, 0.157),
        (34.94, 0.17, 0.277),
    ]
)
"""Trunks of Experiment 1's forest: x, y, radius, m."""


@pytest.mark.table("distance_m", [1.3, 1.0, 0.8, 0.6])
def test_a_metre_of_the_way_out_is_a_metre_of_progress_however_near_an_obstacle_is(distance_m):
    # Given a way out along x, which keeps one distance from a wall; a metre of it costs what `slowness` says
    field = DistanceField(np.full((1, 151, 151), distance_m), 0.1, 1.0, 1.3)
    nearness = max(0.0, (PARAMETERS.r_ub - distance_m) / (PARAMETERS.r_ub - PARAMETERS.r_lb))
    metre_costs = 1.0 + nearness + SLOWER * nearness**2
    left_m = 0.25 * np.arange(40, -41, -1) + 10.0
    way = CostToGo(np.tile(metre_costs * left_m, (81, 1))[None], 0.25, 0.0, 0.0, math.inf)
    around = Surroundings(field, ALL_SEEN, NOTHING_MOVES, way)
    state = np.zeros((3, 4))
    state[0, 1] = 2.0
    # When the UAV flies on along it
    ahead = np.array([1.0, 0.0])
    assessed = Rollouts(PARAMETERS).assess(np.array([[2.0, 0.0, 0.0]]), state, around, ahead, 0.1)
    # Then its progress is what it flies
    assert assessed.is_admissible.all()
    assert assessed.outcomes[0, PROGRESS] == pytest.approx(2.0 * cost_horizon_s(PARAMETERS), rel=1e-3)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))])
def test_the_trunk_at_x_31_of_the_forest_is_passed_in_the_middle_of_its_gap(seed):
    # Two trunks leave 2.26 m between them, so the middle is 1.13 m away from both
    scene = Scene(FOREST)
    uav = Uav((26.0, -2.2), yaw=0.05, velocity=(2.0, 0.0))
    flight = fly(Dynamic(), scene, to_goal((40.0, 0.0)), uav, np.random.default_rng(seed), 4.5)
    assert flight.path[-1][0] > 34.0
    assert flight.clearance_m - BODY_RADIUS_M > 0.6
