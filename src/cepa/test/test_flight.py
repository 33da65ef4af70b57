"""Closed loop with a planar UAV that lags as PX4 does: walls, traps, and a UAV that is held back.

`flights/test/flight` flies the simulated UAV through forest, hallway and boxes.
"""

import math

import numpy as np
import pytest
from planar_flight import BODY_RADIUS_M, Scene, Uav, fly, to_goal

from cepa import Improved

GOAL = (40.0, 0.0)


def test_the_uav_of_these_tests_lags_as_px4_does():
    # PX4, velocity step 0 -> 2 m/s: rise (10-90 %) 0.86-0.90 s, overshoot 10-12 %, 50 % after 0.52 s
    uav, speeds = Uav(), []
    for _ in range(2500):
        uav.step((2.0, 0.0), 0.0)
        speeds.append(uav.vx / 2.0)
    reached = [0.004 * int(np.argmax(np.array(speeds) >= share)) for share in (0.1, 0.5, 0.9)]
    assert reached[2] - reached[0] == pytest.approx(0.88, abs=0.06)
    assert reached[1] == pytest.approx(0.52, abs=0.05)
    assert max(speeds) == pytest.approx(1.11, abs=0.02)


def test_stops_in_front_of_a_wall_across_its_way_and_stays_there():
    wall = Scene(walls=np.array([(12.0, -30.0, 12.0, 30.0)]))
    rng = np.random.default_rng(0)
    flight = fly(Improved(), wall, to_goal(GOAL), Uav(), rng, 25.0)
    path = np.array(flight.path)
    assert flight.clearance_m > BODY_RADIUS_M + 0.1
    last = path[-len(path) // 5 :]
    assert np.ptp(last[:, 0]) < 0.4  # no limit cycle towards and away from the wall


@pytest.mark.table("offset", [0.0, 0.05])
def test_leaves_a_symmetric_trap_without_dithering(offset):
    # figure 8.7 in the small: a wall on the left, columns on the right, the UAV closer than r_lb to both
    columns = [(x, -0.62 - offset, 0.1) for x in (-0.7, 0.0, 0.7)]
    scene = Scene(np.array(columns), np.array([(-8.0, 0.45, 8.0, 0.45)]))
    rng = np.random.default_rng(1)
    flight = fly(Improved(), scene, lambda position: (0.0, 0.0), Uav(velocity=(0.05, 0.0)), rng, 6.0)
    assert flight.decisions[0].emergency
    assert flight.clearance_m > BODY_RADIUS_M
    assert not flight.decisions[-1].emergency
    along = np.sign([command[0] for command in flight.commands if abs(command[0]) > 0.1])
    assert np.count_nonzero(np.diff(along)) <= 1  # it may turn round once, at rest, but not go to and fro


def test_a_uav_that_is_held_back_does_not_run_away():
    scene = Scene(walls=np.array([(3.0, -3.0, 3.0, 3.0), (-3.0, 3.0, 3.0, 3.0), (-3.0, -3.0, 3.0, -3.0)]))
    flight = fly(Improved(), scene, to_goal(GOAL, speed=1.0), Uav(), np.random.default_rng(3), 20.0)
    assert flight.clearance_m > BODY_RADIUS_M
    assert max(math.hypot(*position) for position in flight.path) < 4.5
