"""What comes while walls stand near: the UAV leaves past them, and is not pressed into a corner."""

import math

import numpy as np
import pytest
from flight_beside import fly_beside

from cepa import CepaParameters
from cepa.dynamic.constants.response import MEETING_S, PATH_STEP_S
from cepa.dynamic.kernels.rollout import HIT, LOSS
from cepa.dynamic.kernels.surroundings import NO_COST_TO_GO, DistanceField, FreeSpace, Surroundings
from cepa.dynamic.rollouts import Rollouts
from cepa.dynamic.ways_out.straight_ways import straight_ways

AHEAD = (0.9, -8.0, 0.0), (1.2, 8.0, 8.0)
LEFT, RIGHT = ((-8.0, 0.8, 0.0), (1.2, 1.1, 8.0)), ((-8.0, -1.2, 0.0), (1.2, -0.9, 8.0))
PLACES = {"wall": [AHEAD], "corner": [AHEAD, LEFT], "niche": [AHEAD, LEFT, RIGHT]}
NOWHERE, NO_POINTS = np.zeros(2), np.empty((0, 2))


def back(position):
    """Return the v_ref that leads back to the origin."""
    return tuple(np.clip(-0.5 * position[:2], -0.7, 0.7).tolist())


@pytest.mark.parametrize("has_puck", [pytest.param(False, marks=pytest.mark.long), True])
@pytest.mark.table(
    ("place", "edge_m", "sinks_m_s"), [("wall", 1.5, 0.5), ("corner", 1.5, 0.5), ("niche", 1.5, 0.3)]
)
def test_a_load_that_sinks_near_walls_touches_nobody(place, edge_m, sinks_m_s, has_puck):
    """The UAV hovers under it, and wants back; the way out of a niche is under the middle of the load."""
    half = 0.5 * edge_m

    def load_at(t):
        bottom_m = max(5.0 - sinks_m_s * t, 0.01)
        return (0.1 - half, -0.05 - half, bottom_m), (0.1 + half, half - 0.05, bottom_m + edge_m)

    hovers, until_s = (0.0, 0.0, 2.0), 4.5 / sinks_m_s
    nearest = fly_beside(load_at, back, until_s, hovers, has_puck=has_puck, walls=np.array(PLACES[place]))
    assert nearest.box_m > 0.0
    assert nearest.walls_m > 0.0


@pytest.mark.parametrize("has_puck", [False, pytest.param(True, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("half_m", "speed", "from_m"),
    [
        (0.25, 0.8, (-6.0, 2.0)),
        (0.25, 1.2, (-5.0, 0.5)),
        pytest.param(0.25, 1.2, (-6.0, 0.0), marks=pytest.mark.long),
        (0.6, 1.72, (-3.8, 6.6)),
        pytest.param(0.6, 1.78, (-2.0, -6.7), marks=pytest.mark.long),
    ],
)
def test_a_person_or_a_truck_that_comes_to_a_uav_before_a_wall_touches_nobody(
    half_m, speed, from_m, has_puck
):
    """It stops just before where the UAV hovers."""
    away_m = math.hypot(*from_m)

    def comes_at(t):
        share = max(1.0 - speed * t / away_m, (2.0 * half_m - 0.3) / away_m)
        x, y = share * from_m[0], share * from_m[1]
        return (x - half_m, y - half_m, 0.0), (x + half_m, y + half_m, 1.75)

    hovers, until_s = (0.0, 0.0, 1.2), away_m / speed + 4.0
    nearest = fly_beside(comes_at, back, until_s, hovers, has_puck=has_puck, walls=np.array(PLACES["wall"]))
    assert nearest.box_m > 0.0
    assert nearest.walls_m > 0.0


def before_a_wall(wall_m, movers):
    """Return surroundings with a wall that far ahead (x), seen everywhere."""
    x_m = 0.1 * (np.arange(151) - 75)
    field = np.broadcast_to(np.clip(wall_m - x_m, 0.0, 1.3), (151, 151))[None].copy()
    free_space = FreeSpace(np.full(360, 9.0), np.empty((0, 0, 0), np.uint8), 1.0)
    return Surroundings(DistanceField(field, 0.1, 1.0, 1.3), free_space, np.array(movers), NO_COST_TO_GO)


def test_who_stops_at_a_wall_is_met_there_by_what_comes():
    """A wall is 2 m ahead, and somebody comes along it. A UAV that flies to the wall is there before him."""
    speed, from_m, radius_m = 1.0, 3.0, 0.3
    met, alone = (
        Rollouts(CepaParameters())
        .assess(np.array([[2.0, 0.0, 0.0]]), np.zeros((3, 4)), before_a_wall(2.0, movers), NOWHERE, 0.1)
        .outcomes[0]
        for movers in ([[1.6, from_m, 0.0, -speed, radius_m, 0.0]], [[1.6, 40.0, 0.0, -speed, radius_m, 0.0]])
    )
    assert met[LOSS] == alone[LOSS] > 0.0
    assert alone[HIT] == 0.0
    # He has come within his radius and r_LB when he has walked 3 m, less these two
    least_m = CepaParameters().r_lb + radius_m
    met_s = (1.0 - met[HIT]) * MEETING_S
    assert met_s == pytest.approx((from_m - least_m) / speed, abs=0.15)
    assert met_s / PATH_STEP_S == pytest.approx(round(met_s / PATH_STEP_S))


def test_where_all_ways_meet_what_may_move_those_pass_that_pass_it_as_it_moves():
    """It comes along x, ever less sure; a wall is behind the UAV. Aside there is room."""
    aside = np.array([[0.0, 0.0, 0.0], [0.0, 1.5, 0.0], [1.5, 0.0, 0.0]])
    around = before_a_wall(1.2, [[-3.0, 0.0, 1.0, 0.0, 0.4, 1.2]])
    rollouts = Rollouts(CepaParameters())
    unsure = rollouts.assess(aside, np.zeros((3, 4)), around, NOWHERE, 0.1)
    assert not unsure.passes
    passing = rollouts.assess_passing(aside, np.zeros((3, 4)), around, NOWHERE, 0.1, NO_POINTS)
    assert (passing.outcomes[:, HIT] > 0.0).tolist() == [True, False, True]


def test_straight_ways_are_as_wide_as_what_they_pass():
    ways = straight_ways(before_a_wall(1.0, np.empty((0, 6))).field)
    for k in (0, 9, 18, 40, 71):
        for s in (0, 4, 30):
            x_m = ways.steps_m[: s + 1] * ways.directions[k, 0]
            clear_m = np.clip(1.0 - x_m, 0.0, 1.3)
            assert ways.clearance_m[s, k] == pytest.approx(clear_m[-1], abs=0.06)  # half a cell
            assert ways.narrowest_m[s, k] == pytest.approx(clear_m.min(), abs=0.06)
    assert ways.here_m == pytest.approx(1.0)
    away = ways.soonest(ways.clearance_m >= 1.29, 1.3, NOWHERE)
    assert away.direction[0] < -0.8  # the nearest cell is as near in a few directions
    # 0.2 m narrower at first, which counts five times; and no way was there before, which counts half a turn
    assert away.length_m == pytest.approx(0.3 + 5.0 * 0.2 + 0.5, abs=0.1)
    assert ways.soonest(ways.clearance_m > 2.0, 1.3, NOWHERE) is None
