"""A UAV whose lidar sees one plane climbs and sinks only into what a range finder has seen."""

import math

import numpy as np
import pytest
from spatial_flight import LEVEL, STEP_S, Boxes

from cepa import CepaParameters, Dynamic, LaserScan2D, Motion, MotionError, Ranging
from cepa.dynamic.constants.distance_fields import LAYERS
from cepa.dynamic.free_space.planar_sensors import LidarPlane
from cepa.dynamic.kernels.free_space import BY_REACH
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.observer import response_of
from cepa.dynamic.remembered.space_memory import SpaceMemory

BEAMS, PERIOD_S, SPEED_M_S = 360, 0.1, 1.5
ANGLES = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
AROUND = np.stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(BEAMS)], axis=1)
HALL = [[(-2.0, -3.0, 0.0), (30.0, -2.8, 9.0)], [(-2.0, 2.8, 0.0), (30.0, 3.0, 9.0)]]
END = [[(-2.2, -3.0, 0.0), (-2.0, 3.0, 9.0)]]
LOW_WALL = Boxes(np.array([[(3.0, -3.0, 0.0), (3.3, 3.0, 2.3)], *HALL, *END]))
CEILING = [[(-2.2, -3.0, 2.6), (30.0, 3.0, 9.0)]]
BEAM = Boxes(np.array([[(3.0, -3.0, 1.8), (3.3, 3.0, 9.0)], *HALL, *END, *CEILING]))
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def ranging(boxes, position, direction):
    """What a range finder of 10 m measures."""
    nearly = np.array([[1e-9, 1e-9, direction[2]]])
    return Ranging((0.0, 0.0, 0.0), direction, float(boxes.ranges(position, nearly)[0]), 0.05, 10.0)


def path_along_x(boxes, directions, patience_s, speed_m_s=SPEED_M_S, view_rad=math.pi):
    """Fly along a hall at 2 m with range finders in these directions; positions (n, 3), least clearance.

    The UAV never turns. view_rad: the lidar sees so far to both sides.
    """
    steering, position, state = Dynamic(), np.array([0.0, 0.0, 2.0]), np.zeros((3, 4))
    model = steering.parameters.response
    response, command, path, clearance_m = response_of(model, STEP_S), np.zeros(3), [position], math.inf
    seen = np.abs(ANGLES) < view_rad + 1e-9
    for number in range(round(patience_s / PERIOD_S)):
        ranges = boxes.ranges(position, AROUND)
        ranges = np.where(seen & (ranges <= 10.0), ranges, math.inf)
        scan = LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0, seen)
        steering.take_ranges([ranging(boxes, position, direction) for direction in directions])
        climb_ref = float(np.clip(2.0 - position[2], -1.0, 1.0))
        motion = Motion(number * PERIOD_S, tuple(position), LEVEL, tuple(state[:, 1]), climb_ref)
        decision = steering.steer(scan, (speed_m_s, 0.0), tuple(state[:2, 1]), motion)
        late, command = command, np.array([*decision.velocity_xy, decision.climb_m_s])
        state[:, 0] = 0.0
        commands = np.array([[0.0, 9.0, *late], [model.delay_s, 9.0, *command]])
        fly(state, commands, 0, 2, 0.0, PERIOD_S, response)
        position = position + state[:, 0]
        path.append(position)
        clearance_m = min(clearance_m, boxes.clearance(position, 0.35, 0.25, 0.1))
        if position[0] > 4.5:
            break
    return np.array(path), clearance_m


def test_it_climbs_over_a_low_wall_where_a_range_finder_sees_free_above():
    path, clearance_m = path_along_x(LOW_WALL, (UP, DOWN), 9.0)
    assert path[-1, 0] > 4.5
    assert clearance_m > 0.05
    assert path[np.abs(path[:, 0] - 3.15) < 0.3, 2].min() > 2.3 + 0.25


def test_it_sinks_under_a_beam_where_a_ceiling_is_above():
    path, clearance_m = path_along_x(BEAM, (UP, DOWN), 12.0)
    assert path[-1, 0] > 4.5
    assert clearance_m > 0.05
    assert path[:, 2].max() < 2.35


@pytest.mark.parametrize(("boxes", "direction"), [(LOW_WALL, DOWN), (BEAM, UP)], ids=["up", "down"])
def test_it_stays_where_no_range_finder_looks(boxes, direction):
    path, clearance_m = path_along_x(boxes, (direction,), 5.0)
    moved = -direction[2] * (path[:, 2] - 2.0)
    assert moved.max() < 0.15  # a layer
    assert path[:, 0].max() < 3.0
    assert clearance_m > 0.05


@pytest.mark.table("speed_m_s", [0.5, 2.0])
def test_it_does_not_creep_backwards_into_what_its_lidar_does_not_see(speed_m_s):
    path, clearance_m = path_along_x(LOW_WALL, (UP, DOWN), 6.0, -speed_m_s, math.radians(120.0))
    assert path[:, 0].min() > -1.0  # the wall is 2 m behind; what it sees aside lets it go back a little
    assert clearance_m > 0.5


def test_its_own_place_stays_unseen_when_it_may_remember_for_longer():
    brief, long = (SpaceMemory(CepaParameters(memory_s=memory_s)) for memory_s in (5.0, 20.0))
    place = (0.0, 0.0, 2.0), LEVEL, (0.0, 0.0, 0.0), 0.0
    side = SpaceMemory(CepaParameters()).take_in(None, Motion(0.0, *place)).distance.shape[1]
    blind = LidarPlane(np.full(360, -1.0), np.full((1, side, side), 9.0))
    for memory, stamp_s in ((brief, 0.1), (brief, 0.2), (long, 0.3)):
        if memory is long:
            long.take_over(brief)
        unseen = memory.take_in(None, Motion(stamp_s, *place), plane=blind).unseen
        middle = unseen.shape[1] // 2
        assert unseen[LAYERS // 2, middle, middle] == BY_REACH


def test_height_limits_hold():
    steering = Dynamic(CepaParameters(height_max=2.05))
    position = np.array([2.0, 0.0, 2.0])
    for number in range(6):
        steering.take_ranges([ranging(LOW_WALL, position, UP)])
        scan = LaserScan2D(LOW_WALL.ranges(position, AROUND), -math.pi, 2 * math.pi / BEAMS, 0.06, 60.0)
        motion = Motion(0.05 * number, tuple(position), LEVEL, (0.0, 0.0, 0.0), 0.0)
        assert steering.steer(scan, (SPEED_M_S, 0.0), (0.0, 0.0), motion).climb_m_s <= 0.05


@pytest.mark.table(
    ("range_m", "free_m"), [(3.0, 3.0), (math.inf, 10.0), (-math.inf, 0.0), (math.nan, 0.0), (0.01, 0.0)]
)
def test_what_a_range_says(range_m, free_m):
    assert Ranging((0.0, 0.0, 0.0), UP, range_m, 0.05, 10.0).free_m == free_m


@pytest.mark.table("wrong", [{"direction": (0.0, 0.0, 2.0)}, {"range_max_m": 0.01}])
def test_a_range_finder_that_makes_no_sense_is_refused(wrong):
    right = {"origin_m": (0.0, 0.0, 0.0), "direction": UP, "range_m": 1.0, "range_min_m": 0.05}
    with pytest.raises(MotionError, match="range finder"):
        Ranging(**{"range_max_m": 10.0, **right, **wrong})
