"""Following the leg between two setpoints, against closed form."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inspection_tools import PositionController, PositionControllerParameters
from inspection_tools.leg import CORNER_M, Leg

STEP_S = 0.01
PLACES = st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))


def fly(setpoints, start, seconds=30.0, lag_s=0.0, **parameters):
    """Fly through setpoints, each within 0.5 m. The velocity follows with a lag. Return places."""
    controller = PositionController(PositionControllerParameters(**parameters))
    place, velocity, places, left = list(start), [0.0, 0.0], [], list(setpoints)
    controller.set_setpoint((*left.pop(0), 0.0))
    for step in range(round(seconds / STEP_S)):
        command = controller.update(step * STEP_S, (*place, 0.0), 0.0).velocity_m_s
        if left and math.dist(place, controller.setpoint_m[:2]) < 0.5:
            controller.set_setpoint((*left.pop(0), 0.0))
        share = 1.0 if lag_s == 0.0 else STEP_S / lag_s
        velocity = [v + share * (c - v) for v, c in zip(velocity, command)]
        place = [p + v * STEP_S for p, v in zip(place, velocity)]
        places.append(tuple(place))
    return places


@given(last=PLACES, here=PLACES, setpoint=PLACES, lookahead_m=st.floats(0.0, 5.0))
def test_the_aim_is_on_the_leg_between_the_foot_and_its_end(last, here, setpoint, lookahead_m):
    leg = Leg.of(last, here, setpoint)
    assert leg.begin_m == (last if math.dist(last, here) <= CORNER_M else here)
    way = leg.way(here, lookahead_m)
    aim = here[0] + way[0], here[1] + way[1]
    length = math.dist(leg.begin_m, setpoint)
    if length < 1e-6:
        return
    along = [(b - a) / length for a, b in zip(leg.begin_m, setpoint)]
    offset = (aim[0] - setpoint[0]) * along[1] - (aim[1] - setpoint[1]) * along[0]
    foot_m, aim_m = (sum((p - a) * u for p, a, u in zip(place, leg.begin_m, along)) for place in (here, aim))
    assert offset == pytest.approx(0.0, abs=1e-9)
    assert aim_m == pytest.approx(min(foot_m + lookahead_m, length), abs=1e-9)


@pytest.mark.table("speed", [0.5, 2.0])
def test_an_offset_from_the_leg_shrinks_exponentially(speed):
    """A small offset y at speed v obeys y' = -y / T with the lookahead T: in 0.5 s it shrinks to 1 / e."""
    beside_m = 0.2 * speed
    places = fly([(0.0, beside_m), (80.0, beside_m)], (0.0, 0.0), max_speed=speed, lookahead=0.5)
    offsets = [beside_m - y for x, y in places if x > speed**2]  # the acceleration is over
    for begin, end in zip(offsets[:60], offsets[50:110]):
        assert end / begin == pytest.approx(math.exp(-1.0), rel=0.02)


@pytest.mark.table("speed", [1.0, 2.0])
def test_behind_a_corner_the_uav_comes_back_to_the_leg(speed):
    """With a lag of 0.3 s, as PX4's. Flown straight to the setpoint the UAV is off the leg to its end."""
    corner = [(0.0, 0.0), (10.0, 0.0), (10.0, 20.0)]
    straight, followed = (
        fly(corner, (0.0, 0.0), lag_s=0.3, max_speed=speed, lookahead=value) for value in (0.0, 0.5)
    )
    off = [max(abs(x - 10.0) for x, y in places if 3.0 < y < 10.0) for places in (straight, followed)]
    assert off[1] < min(0.03, 0.2 * off[0])
    assert max(x for x, _ in followed) < 10.2


def test_a_uav_far_from_its_last_setpoint_flies_straight_from_where_it_is():
    controller = PositionController(PositionControllerParameters(lookahead=0.5))
    controller.set_setpoint((0.0, 0.0, 0.0))
    controller.update(0.0, (0.0, 5.0, 0.0), 0.0)
    controller.set_setpoint((10.0, 5.0, 0.0))
    x, y, _ = controller.update(0.1, (0.0, 5.0, 0.0), 0.0).velocity_m_s
    assert x > 0.0
    assert y == pytest.approx(0.0, abs=1e-12)


def test_the_end_is_reached_as_without_a_lookahead():
    for lookahead in (0.0, 0.5):
        end = fly([(0.0, 0.0), (4.0, 3.0)], (0.0, 0.0), lookahead=lookahead)[-1]
        assert end == pytest.approx((4.0, 3.0), abs=1e-3)


def test_a_uav_with_a_lag_does_not_overshoot_if_the_controller_knows_of_it():
    """With the lag of 0.5 s and a gain of 2 the approach is critically damped: s^2 + 4 s + 4."""
    flown = {"lag_s": 0.5, "seconds": 8.0, "max_speed": 1.5, "gain": 2.0, "braking_deceleration": 1.4}
    beyond = [max(x for x, _ in fly([(3.0, 0.0)], (0.0, 0.0), lag=lag, **flown)) - 3.0 for lag in (0.0, 0.5)]
    assert beyond[0] > 0.2
    assert beyond[1] < 0.02
    places = fly([(3.0, 0.0)], (0.0, 0.0), lag=0.5, **flown)
    assert places[-1][0] == pytest.approx(3.0, abs=0.01)
