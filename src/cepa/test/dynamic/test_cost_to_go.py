"""What the search for ways out keeps from scan to scan: dead ends, and narrow ways that led nowhere."""

import math

import numpy as np
import pytest
from planar_flight import Scene

from cepa import Dynamic, LaserScan2D, Motion, Reason

BEAMS, SPEED_M_S = 720, 2.0
ANGLES = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
AROUND = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
DEAD_END = Scene(
    walls=np.array([(8.0, -4.0, 8.0, 4.0), (-3.0, 4.0, 8.0, 4.0), (-3.0, -4.0, 8.0, -4.0)]),
)


DOOR_M, GATE_M = 1.15, (3.5, 6.0)
DOOR_AND_GATE = Scene(
    walls=np.array(
        [
            (2.0, -6.0, 2.0, -0.5 * DOOR_M),
            (2.0, 0.5 * DOOR_M, 2.0, GATE_M[0]),
            (-4.0, -6.0, 2.0, -6.0),
            (-4.0, GATE_M[1], 2.0, GATE_M[1]),
            (-4.0, -6.0, -4.0, GATE_M[1]),
        ]
    )
)
"""A narrow door ahead, and a wide gate to the left."""


def answer_at(steering, stamp_s, x_m, y_m=0.0, scene=DEAD_END, speed_m_s=SPEED_M_S):
    """Return the decision of a UAV that stands in the middle of the scene."""
    place = np.array([x_m, y_m])
    scan = LaserScan2D(scene.ranges(place, AROUND), -math.pi, 2.0 * math.pi / BEAMS, 0.06, 30.0)
    motion = Motion(stamp_s, (x_m, y_m, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    return steering.steer(scan, (speed_m_s, 0.0), (0.0, 0.0), motion)


def test_it_does_not_turn_back_to_a_dead_end_once_its_wall_is_far():
    far_m, near_m = 1.5, 6.6
    assert answer_at(Dynamic(), 0.0, far_m).reason is Reason.CUSHION_CLEAR
    steering = Dynamic()
    near = answer_at(steering, 0.0, near_m)
    assert near.velocity_xy[0] < 0.0
    for scan in range(1, 5):
        far = answer_at(steering, 0.025 * scan, far_m)
        assert far.reason is Reason.STEERED
        assert far.velocity_xy[0] < 0.0


def answers_before_the_door(steering, since_s, until_s, speed_m_s):
    stamps_s = np.arange(since_s, until_s, 0.1)
    return [answer_at(steering, at_s, 0.8, 0.6, DOOR_AND_GATE, speed_m_s).velocity_xy for at_s in stamps_s]


@pytest.mark.table("pause_s", [4.0, 10.0])
def test_a_uav_that_has_hovered_before_a_door_goes_on_through_it(pause_s):
    steering = Dynamic()
    before = answers_before_the_door(steering, 0.0, 0.5, 1.0)
    answers_before_the_door(steering, 0.5, 0.5 + pause_s, 0.0)
    after = answers_before_the_door(steering, 0.5 + pause_s, 1.0 + pause_s, 1.0)
    assert all(x > 0.5 and y < 0.0 for x, y in before + after)


def test_a_uav_that_gets_nowhere_before_a_door_tries_the_gate():
    answers = answers_before_the_door(Dynamic(), 0.0, 4.0, 1.0)
    assert answers[0][0] > 0.5
    assert answers[-1][1] > 0.5


def test_a_uav_that_comes_out_of_a_deep_dead_end_does_not_turn_back_to_it():
    """20 m deep: at the mouth its back wall is farther away than the search for ways looks."""
    scene = Scene(walls=np.array([(20.0, -2.0, 20.0, 2.0), (0.0, 2.0, 20.0, 2.0), (0.0, -2.0, 20.0, -2.0)]))
    steering, stamp_s = Dynamic(), 0.0
    for x_m in np.concatenate((np.arange(12.0, 18.5, 0.5), np.arange(18.0, 3.0, -0.25))):
        stamp_s += 0.25
        answer = answer_at(steering, stamp_s, x_m, scene=scene)
    assert answer.velocity_xy[0] < 0.0
    assert answer_at(Dynamic(), 0.0, x_m, scene=scene).velocity_xy[0] > 0.0  # who was not in it flies in


NARROW_DOOR = Scene(
    walls=np.array(
        [
            (2.0, -3.0, 2.0, -0.5),
            (2.0, 0.5, 2.0, 3.0),
            (-4.0, -3.0, 2.0, -3.0),
            (-4.0, 3.0, 2.0, 3.0),
            (-4.0, -3.0, -4.0, 3.0),
        ]
    )
)
"""A room whose only door is 1.0 m wide; r_LB on both sides of the UAV's middle leaves nothing."""


def test_a_door_of_one_metre_is_a_way_if_there_is_no_other():
    answer = answer_at(Dynamic(), 0.0, 0.5, 1.0, scene=NARROW_DOOR, speed_m_s=1.0)
    assert answer.reason is Reason.STEERED
    assert answer.velocity_xy[0] > 0.0
    assert answer.velocity_xy[1] < 0.0
