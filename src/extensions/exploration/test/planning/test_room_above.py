"""How far a UAV may rise, in drawn rooms: distances worked out by hand."""

import math

import numpy as np
import pytest
from drawn_voxels import block, planner_on
from hypothesis import given
from hypothesis import strategies as st

from exploration.planning import Limits, PathPlanner, PlannerParameters
from flight_basics.errors import PoseError

SIZE_M = 0.1
UAV = PlannerParameters(radius=0.35, margin=0.2)
KEPT_M, DRIFT_M = 0.55, 0.3
"""Radius and margin; what wind carries it farther to the side: to 0.5 m more than the radius."""
HERE = np.array((1.0, 1.0, 0.15))


def room(*occupied):
    """A planner that knows a room of 2 x 2 x 3 m with a floor, and what is occupied, by slices z, y, x."""
    kinds = block(30, 20, 20)
    kinds[0] = 2
    for part in occupied:
        kinds[part] = 2
    return planner_on(kinds, UAV, SIZE_M)


BEAM = np.s_[17:19, :]
"""From 1.7 to 1.9 m. Its lowest centres are 1.75 m high."""


def test_under_nothing_it_rises_as_far_as_it_wants():
    assert room().room_above_m(HERE, 1.88) == 1.88


def test_under_a_beam_it_keeps_the_clearance():
    # Given a beam right above; its lowest centres are 1.6 m above the UAV
    risen_m = room((*BEAM, np.s_[9:11])).room_above_m(HERE, 1.88)
    away_m = math.hypot(0.05, 1.60 - risen_m)
    assert KEPT_M <= away_m < KEPT_M + 0.06


def test_beside_a_beam_it_rises_until_the_corner_is_near():
    # Given a beam whose nearest centres are 0.45 m to the side
    risen_m = room((*BEAM, np.s_[14:16])).room_above_m(HERE, 1.88)
    assert KEPT_M <= math.hypot(0.45 - DRIFT_M, 1.60 - risen_m) < KEPT_M + 0.06
    # And one that is farther away than the clearance
    assert room((*BEAM, np.s_[19:20])).room_above_m(HERE, 1.88) == 1.88


def test_along_a_wall_it_rises_but_not_under_what_sticks_out_of_it():
    wall = np.s_[:, :, 14:16]
    assert room(wall).room_above_m(HERE, 1.88) == 1.88
    risen_m = room(wall, (*BEAM, np.s_[10:16])).room_above_m(HERE, 1.88)
    # It keeps from the beam what it has to the wall, 0.45 m
    assert 0.45 <= math.hypot(0.05, 1.60 - risen_m) < 0.45 + 0.06


def test_what_seems_to_stand_in_the_uav_does_not_let_it_near_a_beam():
    risen_m = room(np.s_[2:4, 10, 10], (*BEAM, np.s_[9:11])).room_above_m(HERE, 1.88)
    assert UAV.radius <= math.hypot(0.05, 1.60 - risen_m) < UAV.radius + 0.06


def test_right_under_something_there_is_no_room():
    assert room(np.s_[6:8, :, :]).room_above_m(HERE, 1.88) == 0.0


def test_a_small_uav_rises_under_a_deck_of_0_9_m():
    # Given a ceiling whose lowest centres are 0.95 m high, and a UAV that stands 0.15 m high
    kinds = block(10, 20, 20)
    kinds[0] = kinds[9] = 2
    small = planner_on(kinds, PlannerParameters(radius=0.2, margin=0.0), SIZE_M)
    # Then it keeps its radius and what it may overshoot, 0.35 m
    assert small.room_above_m(HERE, 1.88) == pytest.approx(0.95 - 0.35 - 0.15)


def test_what_is_unknown_is_no_obstacle_and_the_ceiling_is_one():
    assert PathPlanner(UAV).room_above_m(HERE, 1.88) == 1.88
    assert planner_on(block(4, 4, 4, kind=0), UAV, SIZE_M).room_above_m(HERE, 1.88) == 1.88
    under = planner_on(block(30, 20, 20), UAV, SIZE_M, limits=Limits(ceiling_m=1.0))
    assert under.room_above_m(HERE, 1.88) == pytest.approx(0.85)
    assert under.room_above_m(np.array((1.0, 1.0, 1.5)), 1.88) == 0.0


def test_a_place_that_is_not_finite_is_refused():
    with pytest.raises(PoseError, match="not three finite numbers"):
        room().room_above_m(np.array((1.0, math.nan, 0.0)), 1.0)


@given(
    st.lists(st.tuples(st.integers(5, 29), st.integers(0, 19), st.integers(0, 19)), max_size=12),
    st.floats(0.7, 1.3),
    st.floats(0.7, 1.3),
)
def test_on_its_way_up_it_keeps_its_distance_from_all_that_is_above(voxels, x_m, y_m):
    here_m = np.array((x_m, y_m, 0.15))
    risen_m = room(*voxels).room_above_m(here_m, 1.88)
    centres_m = [np.array((x, y, z)) * SIZE_M + 0.05 for z, y, x in voxels]
    is_above = [centre_m[2] - here_m[2] > 0.3 for centre_m in centres_m]
    beside_m = [math.dist(c[:2], here_m[:2]) for c, above in zip(centres_m, is_above) if not above]
    least_m = KEPT_M if min(beside_m, default=1.0) >= KEPT_M else UAV.radius
    near_m = KEPT_M + DRIFT_M
    for height_m in np.arange(0.05, risen_m + 1e-9, 0.05):
        for centre_m, above in zip(centres_m, is_above):
            assert not above or math.dist(centre_m, here_m + np.array((0.0, 0.0, height_m))) >= least_m - 1e-6
    # And it stops only where something is near
    next_m = here_m + np.array((0.0, 0.0, risen_m + 0.05))
    near = [math.dist(c, next_m) < near_m for c, above in zip(centres_m, is_above) if above]
    assert risen_m == 1.88 or any(near)
