"""What seems to move, but has stood there, as clouds have shown."""

import math

import numpy as np
import pytest
from spatial_flight import NO_SCAN, Boxes, motion_at

from cepa import CepaParameters, Dynamic
from cepa.dynamic.remembered.space_memory import SpaceMemory

BOX_TOP_M, SINKING_M = 1.75, 1.7
SEEMS_TO_MOVE = np.array([[3.2, 0.0, -0.5, 0.7, 0.6, 0.5]])
SIDE = np.stack([np.full(9, 3.0), np.linspace(-0.4, 0.4, 9), np.zeros(9)], axis=1)


def remembered_for(time_s, box_at):
    """What clouds have shown while a lidar has sunk below the top of a box. box_at: tells the box's y, m."""
    memory, position = SpaceMemory(CepaParameters()), np.array([0.0, 0.0, 1.9])
    for stamp_s in np.arange(0.0, time_s + 1e-6, 0.1):
        position[2] = 1.9 - (1.9 - SINKING_M) * stamp_s / time_s
        y = box_at(stamp_s)
        box = Boxes(np.array([[(3.0, y - 0.5, 0.0), (4.0, y + 0.5, BOX_TOP_M)]]))
        memory.take_in(box.cloud(position), motion_at(stamp_s, position))
    return memory, motion_at(time_s + 0.1, position)


def test_what_the_lidar_sinks_to_has_stood_if_clouds_have_shown_it_for_long():
    memory, motion = remembered_for(1.5, lambda _: 0.0)
    assert memory.have_stood(SEEMS_TO_MOVE, SIDE, motion).tolist() == [True]
    assert memory.have_stood(SEEMS_TO_MOVE, SIDE[:0], motion).tolist() == [False]  # out of sight
    aside, shift_m = SEEMS_TO_MOVE.copy(), np.array((0.0, 3.0, 0.0))
    aside[:, 1] += shift_m[1]
    both = np.concatenate((aside, SEEMS_TO_MOVE)), np.concatenate((SIDE, SIDE + shift_m))
    assert memory.have_stood(*both, motion).tolist() == [False, True]


def test_what_clouds_have_shown_only_just_has_not_stood():
    memory, motion = remembered_for(0.6, lambda _: 0.0)
    assert memory.have_stood(SEEMS_TO_MOVE, SIDE, motion).tolist() == [False]


@pytest.mark.table("speed_m_s", [0.6, 1.5])
def test_what_comes_along_has_not_stood(speed_m_s):
    memory, motion = remembered_for(2.0, lambda stamp_s: speed_m_s * (stamp_s - 2.1))
    assert memory.have_stood(SEEMS_TO_MOVE, SIDE, motion).tolist() == [False]


@pytest.mark.parametrize(("y_m", "evades"), [(0.0, False), (3.0, True)], ids=["the box", "what is new"])
def test_it_stays_before_what_has_stood_and_evades_what_comes(monkeypatch, y_m, evades):
    """The tracker says that something comes to the UAV, from where a box stands or from beside it."""
    box, position = Boxes(np.array([[(3.0, -0.5, 0.0), (4.0, 0.5, BOX_TOP_M)]])), np.array([0.0, 0.0, 1.7])
    steering = Dynamic()
    for stamp_s in np.arange(0.0, 1.5, 0.1):
        steering.steer(NO_SCAN, (0.0, 0.0), (0.0, 0.0), motion_at(stamp_s, position), box.cloud(position))
    points = SIDE + np.array((0.0, y_m, 0.0))
    comes = np.array([[3.2, y_m, -3.2, -y_m, 0.6, 0.1]])
    take_in = steering._separation._moving.take_in

    def told(*given):
        return take_in(*given)._replace(points=points, is_moving=np.ones(9, bool), movers=comes)

    monkeypatch.setattr(steering._separation._moving, "take_in", told)
    motion = motion_at(1.5, position)
    decision = steering.steer(NO_SCAN, (0.0, 0.0), (0.0, 0.0), motion, box.cloud(position))
    assert (math.hypot(*decision.velocity_xy) > 0.1) == evades


def test_a_long_thing_that_passes_has_not_stood():
    memory, position = SpaceMemory(CepaParameters()), np.array([0.0, 0.0, 1.9])
    for stamp_s in np.arange(0.0, 2.05, 0.1):
        front = 1.0 * (stamp_s - 2.0) + 2.0  # its rear is as far out of sight as before
        lorry = Boxes(np.array([[(3.0, front - 4.0, 0.0), (4.0, front, 3.0)]]))
        memory.take_in(lorry.cloud(position), motion_at(stamp_s, position))
    side = np.stack([np.full(41, 3.0), np.linspace(-2.0, 2.0, 41), np.zeros(41)], axis=1)
    passes = np.array([[3.0, 0.0, 0.0, 1.0, 2.0, 0.2]])
    assert memory.have_stood(passes, side, motion_at(2.1, position)).tolist() == [False]
