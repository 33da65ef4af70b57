"""The UAV keeps out of keep-out boxes as it keeps off obstacles."""

import math

import numpy as np
import pytest
from planar_flight import Scene, Uav, fly, to_goal

from cepa import Dynamic, KeepOut, KeepOutBox, ParameterError
from cepa.keep_out import REACH_M, WALL_STEP_M, MapPose, at_heights, limits_of, walls_of

BOX = KeepOutBox((3.0, 0.2, 0.0), (8.0, 4.0, 5.0), "hatch")


def distance_m(box, x, y):
    """From a place to a box in the plan; 0 inside."""
    return math.hypot(
        max(box.low_m[0] - x, x - box.high_m[0], 0.0), max(box.low_m[1] - y, y - box.high_m[1], 0.0)
    )


@pytest.mark.table("trunk_y", [-0.3, 0.0])
def test_a_uav_that_evades_a_trunk_does_not_cross_a_box(trunk_y):
    # Given a trunk on the way, and a box on the side on which it is nearer to pass
    steering, scene = Dynamic(), Scene(circles=np.array([(5.0, trunk_y, 0.3)]))
    steering.take_keep_out(KeepOut([BOX]))
    uav = Uav()
    flight = fly(steering, scene, to_goal((12.0, 0.0)), uav, np.random.default_rng(1), 25.0)
    # Then the UAV passes on the other side
    assert flight.reached
    assert not flight.contact
    assert min(distance_m(BOX, x, y) for x, y in flight.path) > steering.parameters.body_radius


def test_a_uav_that_is_led_into_a_box_stops_before_it():
    steering = Dynamic()
    steering.take_keep_out(KeepOut([KeepOutBox((4.0, -20.0, -9.0), (9.0, 20.0, 9.0))]))
    flight = fly(steering, Scene(), to_goal((6.0, 0.0)), Uav(), np.random.default_rng(2), 8.0)
    assert max(x for x, _ in flight.path) < 4.0 - steering.parameters.body_radius


def test_walls_are_closed_near_the_uav_and_none_for_a_uav_inside():
    walls = KeepOut([BOX]).walls((0.0, 0.0, 2.0))
    face = walls[np.abs(walls[:, 0] - 3.0) < 1e-9]
    for y, z in np.random.default_rng(3).uniform((0.2, -1.5), (4.0, 1.5), (50, 2)):
        assert np.hypot(*(face[:, 1:] - (y, z)).T).min() <= WALL_STEP_M
    assert np.abs(walls[:, 2]).max() <= 1.8 + 1e-9
    assert not len(KeepOut([BOX]).walls((4.0, 1.0, 2.0)))
    assert not len(KeepOut([BOX]).walls((30.0, 0.0, 2.0)))


def plain_walls(box, place, reach, step):
    """The points of a box's faces near a place, face by face."""
    low, high = np.array(box.low_m), np.array(box.high_m)
    near_low, near_high = np.maximum(low, place - reach), np.minimum(high, place + reach)
    if np.any(near_low > near_high):
        return np.empty((0, 3))
    sides = [np.linspace(a, b, math.ceil((b - a) / step) + 1) for a, b in zip(near_low, near_high)]
    faces = [np.empty((0, 3))]
    for axis in range(3):
        for end in (low[axis], high[axis]):
            if end in (near_low[axis], near_high[axis]):
                axes = [np.array([end]) if k == axis else sides[k] for k in range(3)]
                faces.append(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3))
    return np.concatenate(faces)


def test_walls_are_the_same_to_the_last_bit_as_face_by_face():
    rng, found = np.random.default_rng(4), 0
    for _ in range(100):
        low = rng.uniform(-12.0, 6.0, 3)
        box = KeepOutBox(tuple(low), tuple(low + rng.uniform(0.01, 9.0, 3)))
        place = rng.uniform(-4.0, 4.0, 3)
        if np.all((low < place) & (place < box.high_m)):
            continue
        expected = plain_walls(box, place, REACH_M, WALL_STEP_M)
        np.testing.assert_array_equal(walls_of(box, place), expected)
        found += len(expected) > 0
    assert found > 20


def test_walls_at_the_bodys_heights_are_told_once_for_each_place_in_the_plan():
    walls = KeepOut([BOX]).walls((0.0, 0.0, 2.0))
    body = at_heights(walls, -0.2, 0.3)
    assert np.all((body[:, 2] >= -0.2) & (body[:, 2] <= 0.3))
    columns = {(x, y) for x, y, z in walls.tolist() if -0.2 <= z <= 0.3}
    assert {(x, y) for x, y, _ in body.tolist()} == columns
    edges = 4  # a face's edge is also one of the next face
    assert len(body) <= len(columns) + edges
    assert not len(at_heights(walls, 5.0, 6.0))


def test_walls_stand_in_the_map_however_the_odometry_has_drifted():
    # Given an odometry that is turned by 90 degrees and shifted by (1, 2, 0) m in the map
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    keep_out = KeepOut([BOX], MapPose(turn, np.array([1.0, 2.0, 0.0])))
    position = np.array([0.5, 0.2, 2.0])
    in_map = (keep_out.walls(position) + position) @ turn.T + (1.0, 2.0, 0.0)
    on_face = np.abs(in_map[:, None, :] - (BOX.low_m, BOX.high_m)).min(axis=(1, 2)) < 1e-9
    assert len(in_map)
    assert on_face.all()


def test_the_file_of_path_planner_is_read():
    limits = {
        "ceiling": 8,
        "keep_out": [{"name": "hatch", "low": [3.0, 0.2, 0], "high": [8, 4, 5]}],
        "keep_in": {"low": [-2, -3, -4], "high": [2, 3, 4]},
    }
    boxes, ceiling_m = limits_of(limits).boxes, limits_of(limits).ceiling_m
    assert boxes[0] == BOX
    assert len(boxes) == 7
    assert ceiling_m == 8.0
    assert limits_of({}).ceiling_m == math.inf
    # And all around keep_in is kept out
    near = KeepOut(boxes[1:]).walls((0.0, 0.0, 0.0))
    for axis, end in ((0, 2.0), (0, -2.0), (1, 3.0), (1, -3.0)):
        assert np.isclose(near[:, axis], end).any()


def test_limits_that_make_no_sense_are_refused_as_a_parameter_is():
    with pytest.raises(ParameterError, match=r"limits: .*'floor'"):
        limits_of({"floor": 1})
