"""How a UAV with clouds climbs and sinks where it is told to."""

import math

import numpy as np
import pytest
from spatial_flight import CLIMB_ERROR_M_S2, NO_SCAN, Boxes, fly_up, motion_at

from cepa import CepaParameters, Dynamic, Ranging
from cepa.dynamic.constants.distance_fields import HEIGHT_ERROR_M
from cepa.dynamic.constants.response import CLIMB_LAG_S
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.observer import response_of

NOTHING = Boxes(np.empty((0, 2, 3)))


@pytest.mark.parametrize("hole_m", [1.4, pytest.param(1.6, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("start_m", "goal_m"),
    [
        (1.3, 4.4),
        (4.4, 1.3),
        pytest.param(1.3, 3.2, marks=pytest.mark.long),
        pytest.param(4.4, 2.6, marks=pytest.mark.long),
    ],
)
def test_it_climbs_and_sinks_through_a_hole_in_a_deck(start_m, goal_m, hole_m):
    # A deck in a room of 5.6 m, with a square hole; the reference leads nearly straight through it
    half, far = 0.5 * hole_m, 3.0
    deck = [
        ((-far, -far, 2.8), (-half, far, 2.95)),
        ((half, -far, 2.8), (far, far, 2.95)),
        ((-half, -far, 2.8), (half, -half, 2.95)),
        ((-half, half, 2.8), (half, far, 2.95)),
    ]
    boxes = Boxes(np.array([*deck, ((-far, -far, 5.6), (far, far, 5.8))]))
    steering = Dynamic(CepaParameters(r_lb=0.5, r_ub=1.2))
    start, goal = np.array([-0.3, 0.1, start_m]), np.array([0.05, 0.0, goal_m])
    flight = fly_up(steering, boxes, start, goal, math.copysign(1.0, goal_m - start_m), 20.0)
    assert flight.positions[-1][2] == pytest.approx(goal_m, abs=0.31)
    assert min(flight.clearances_m) > 0.05


@pytest.mark.table("sign", [1.0, -1.0])
def test_along_a_wall_it_turns_back_to_where_it_came_from_when_it_is_told_to(sign):
    """It has not seen the wall farther on yet: that is no reason to go on."""
    walls = [((0.5, -3.0, 0.0), (0.7, 3.0, 20.0)), ((-3.0, 0.5, 0.0), (3.0, 0.7, 20.0))]
    steering, boxes = Dynamic(CepaParameters(r_lb=0.5, r_ub=1.2, window_m=0.0)), Boxes(np.array(walls))
    # Given a UAV that has flown 3 m along the walls, and is led a little towards them, too
    ends = [np.array([0.1, 0.1, 10.0 + sign * far_m]) for far_m in (0.0, 3.0)]
    there = fly_up(steering, boxes, np.array([0.0, 0.0, 10.0]), ends[1], sign, 12.0)
    # When it is told to come back
    back = fly_up(steering, boxes, there.positions[-1], ends[0], -sign, 12.0, begin_s=20.0)
    # Then it does
    heights_m = np.array(back.positions)[:, 2]
    assert heights_m[-1] == pytest.approx(10.0, abs=0.31)
    assert (-sign * np.diff(heights_m) > -0.02).all()
    assert min(back.clearances_m) > 0.05


def test_the_vertical_disturbance_moves_it_by_at_most_the_height_error():
    state, given, step_s = np.zeros((3, 4)), np.array([[0.0, 9.0, 0.0, 0.0, 0.0]]), 0.001
    response = response_of(CepaParameters().response, step_s)
    for step in range(1000):
        state[2, 1] += CLIMB_ERROR_M_S2 * step_s
        fly(state, given, 0, 1, step * step_s, (step + 1) * step_s, response)
    lag_s = CLIMB_LAG_S
    straying_m = CLIMB_ERROR_M_S2 * lag_s * (1.0 - lag_s * (1.0 - math.exp(-1.0 / lag_s)))
    assert state[2, 0] == pytest.approx(straying_m, rel=0.01)
    assert straying_m <= HEIGHT_ERROR_M


@pytest.mark.table("sign", [1.0, -1.0])
def test_where_nothing_is_it_climbs_and_sinks_as_fast_as_climb_max(sign):
    # The reference asks for more. Range finders show that nothing is above and below
    steering, height_m, climb = Dynamic(), 20.0, 0.0
    ways = [Ranging((0.0, 0.0, 0.0), (0.0, 0.0, up), 12.0, 0.1, 12.0) for up in (1.0, -1.0)]
    climbs = []
    for number in range(40):
        position = np.array([0.0, 0.0, height_m])
        motion = motion_at(0.1 * number, position, (0.0, 0.0, climb), climb_ref=sign)
        steering.take_ranges(ways)
        decision = steering.steer(NO_SCAN, (0.0, 0.0), (0.0, 0.0), motion, NOTHING.cloud(position))
        climb += (decision.climb_m_s - climb) * (1.0 - math.exp(-0.1 / CLIMB_LAG_S))
        height_m += 0.1 * climb
        climbs.append(decision.climb_m_s)
    assert climbs[10:] == pytest.approx([sign * steering.parameters.climb_max] * 30)
