"""A dead end that the UAV has seen stays one when its wall is far away again."""

import math

import numpy as np
from planar_flight import Scene

from cepa import Dynamic, LaserScan2D, Motion, Reason

BEAMS, SPEED_M_S = 720, 2.0
ANGLES = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
AROUND = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
DEAD_END = Scene(
    walls=np.array([(8.0, -4.0, 8.0, 4.0), (-3.0, 4.0, 8.0, 4.0), (-3.0, -4.0, 8.0, -4.0)]),
)


def answer_at(steering, stamp_s, x_m):
    """Return the decision of a UAV that hovers in the middle of the dead end."""
    place = np.array([x_m, 0.0])
    scan = LaserScan2D(DEAD_END.ranges(place, AROUND), -math.pi, 2.0 * math.pi / BEAMS, 0.06, 30.0)
    motion = Motion(stamp_s, (x_m, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    return steering.steer(scan, (SPEED_M_S, 0.0), (0.0, 0.0), motion)


def test_it_does_not_turn_back_to_a_dead_end_where_only_the_wall_is_far_away():
    far_m, near_m = 1.5, 6.6
    assert answer_at(Dynamic(), 0.0, far_m).reason is Reason.CUSHION_CLEAR
    steering = Dynamic()
    near = answer_at(steering, 0.0, near_m)
    assert near.velocity_xy[0] < 0.0
    for scan in range(1, 5):
        far = answer_at(steering, 0.025 * scan, far_m)
        assert far.reason is Reason.STEERED
        assert far.velocity_xy[0] < 0.0
