"""What a UAV with clouds knows and flies: over, under, and only into what it has seen."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planar_flight import Scene
from spatial_flight import CLIMB_ERROR_M_S2, HEIGHT_M, NO_SCAN, Boxes, fly_along_x, motion_at

from cepa import CepaParameters, Cloud, Dynamic, LaserScan2D, ParameterError, Reason
from cepa.dynamic.candidates import REFERENCE, STANDSTILL, candidates, climbing
from cepa.dynamic.constants.distance_fields import LAYER_M, LAYERS
from cepa.dynamic.constants.response import AT_REST_M_S, AT_REST_M_S2, PATH_STEP_S
from cepa.dynamic.cost_to_go.course import Course
from cepa.dynamic.cost_to_go.search import CostToGoSearch, Layers
from cepa.dynamic.kernels.admissible import braking
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.kernels.rollout import roll_out
from cepa.dynamic.kernels.surroundings import (
    NO_COST_TO_GO,
    Braking,
    Cushions,
    DistanceField,
    FreeSpace,
    Horizon,
    Surroundings,
)
from cepa.dynamic.observer import response_of
from cepa.dynamic.remembered.space_memory import SpaceMemory

LOW_WALL = Boxes(np.array([[(6.0, -20.0, 0.0), (6.3, 20.0, 1.9)]]))
BEAM = Boxes(np.array([[(6.0, -20.0, 2.05), (6.3, 20.0, 6.0)]]))
NOTHING = Boxes(np.empty((0, 2, 3)))


@pytest.mark.parametrize(("boxes", "over"), [(LOW_WALL, True), (BEAM, False)], ids=["low wall", "overhang"])
def test_flies_over_a_wall_and_under_an_overhang_and_back_to_its_height(boxes, over):
    towards_it = -CLIMB_ERROR_M_S2 if over else CLIMB_ERROR_M_S2  # the worst that is allowed
    flight = fly_along_x(Dynamic(), boxes, 2.0, 11.0, patience_s=12.0, pushed_up_m_s2=towards_it)
    path = np.array(flight.positions)
    assert path[-1, 0] > 11.0
    assert min(flight.clearances_m) > 0.05
    passing = path[np.abs(path[:, 0] - 6.15) < 0.5, 2]
    assert (passing > 2.2).all() if over else (passing < 1.9).all()
    assert path[-1, 2] == pytest.approx(HEIGHT_M, abs=0.15)


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["over a wall", "under a beam"])
def test_carried_too_near_over_a_wall_it_climbs_and_under_a_beam_it_sinks(sign):
    # Drifting at 1 m/s whatever it commands, over a wall 1.2 m wide whose edge is within its body's heights
    edge_m = HEIGHT_M - 0.25 if sign > 0.0 else HEIGHT_M + 0.1
    low_m, high_m = (0.0, edge_m) if sign > 0.0 else (edge_m, 6.0)
    boxes = Boxes(np.array([[(4.0, -20.0, low_m), (5.2, 20.0, high_m)]]))
    steering = Dynamic()
    for number in range(37):
        position = np.array([0.9 + 0.1 * number, 0.0, HEIGHT_M])
        motion = motion_at(0.1 * number, position, (1.0, 0.0, 0.0))
        decision = steering.steer(NO_SCAN, (1.0, 0.0), (1.0, 0.0), motion, boxes.cloud(position))
    assert 4.4 < position[0] < 4.6
    assert decision.reason is Reason.MARGIN_LOST
    assert decision.climb_m_s == sign * steering.parameters.climb_max
    assert decision.velocity_xy == (0.0, 0.0)


def test_a_mover_that_the_scan_shows_counts_at_all_heights():
    # A cylinder comes along x at 1.5 m/s; the Puck's clouds show nothing but the floor
    steering, floor = Dynamic(), NOTHING
    angles = -math.pi + np.arange(720) * 2.0 * math.pi / 720
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for number in range(16):
        t_s = 0.1 * number
        scene = Scene(circles=np.array([[6.0 - 1.5 * t_s, 0.0, 0.3], [2.0, 6.0, 0.3], [-3.0, -5.0, 0.4]]))
        ranges = scene.ranges(np.zeros(2), directions)
        scan = LaserScan2D(np.where(ranges > 20.0, math.inf, ranges), -math.pi, 2 * math.pi / 720, 0.1, 20.0)
        motion = motion_at(t_s, (0.0, 0.0, HEIGHT_M))
        cloud = floor.cloud(np.array([0.0, 0.0, HEIGHT_M]))
        decision = steering.steer(scan, (2.0, 0.0), (0.0, 0.0), motion, cloud)
    assert steering.report().movers == 1
    assert decision.velocity_xy[0] < 1.9  # it does not fly on, neither above nor below
    assert decision.reason is not Reason.CUSHION_CLEAR


def test_beside_a_cameras_cloud_the_scan_counts():
    # A wall 1 m to the left, where the camera does not look
    angles = -math.pi + np.arange(360) * 2.0 * math.pi / 360
    ranges = np.where(np.abs(angles - 0.5 * math.pi) < 1.2, 1.0 / np.maximum(np.sin(angles), 0.1), math.inf)
    scan = LaserScan2D(ranges, -math.pi, 2.0 * math.pi / 360, 0.06, 10.0)
    ahead = Cloud(np.tile((4.0, 0.0, -1.9), (20, 1)), (-0.48, 0.48), 0.2, 10.0, (-0.61, 0.61))
    steering = Dynamic()
    decision = steering.steer(scan, (0.0, 1.0), (0.0, 0.0), motion_at(0.0, (0.0, 0.0, HEIGHT_M)), ahead)
    assert steering.report().clearance_m == pytest.approx(1.0 - CepaParameters().body_radius, abs=0.01)
    assert decision.velocity_xy[1] < 0.6
    assert decision.climb_m_s is not None


def test_without_clouds_it_stays_level_and_the_reference_climbs():
    assert Dynamic().steer(NO_SCAN, (1.0, 0.0), (1.0, 0.0), motion_at(0.0, (0.0, 0.0, 2.0))).climb_m_s is None
    level = Dynamic(CepaParameters(climb_max=0.0))
    cloud = LOW_WALL.cloud(np.array([4.0, 0.0, 2.0]))
    assert not level.wants_cloud
    assert (
        level.steer(NO_SCAN, (1.0, 0.0), (1.0, 0.0), motion_at(0.0, (4.0, 0.0, 2.0)), cloud).climb_m_s is None
    )


@cache
def approach(place, **changes):
    """Return the last answer of a UAV that is moved along x at 2 m/s, whatever it answers."""
    boxes, steering = {"low wall": LOW_WALL, "beam": BEAM}[place], Dynamic(CepaParameters(**changes))
    for x in np.arange(0.0, 4.6, 0.2):
        position = np.array([x, 0.0, HEIGHT_M])
        motion = motion_at(0.5 * x, position, (2.0, 0.0, 0.0))
        decision = steering.steer(NO_SCAN, (2.0, 0.0), (2.0, 0.0), motion, boxes.cloud(position))
    return np.array([*decision.velocity_xy, decision.climb_m_s])


@pytest.mark.table(
    ("name", "value", "place"),
    [
        ("climb_max", 0.3, "low wall"),
        ("height_max", 2.1, "low wall"),
        ("height_min", 1.9, "beam"),
        ("body_below", 0.05, "low wall"),
        ("body_above", 0.6, "beam"),
    ],
)
def test_every_parameter_of_clouds_changes_the_answer(name, value, place):
    assert np.linalg.norm(approach(place, **{name: value}) - approach(place)) > 0.1


def test_it_stops_before_a_wall_that_is_too_high_to_be_seen_over():
    wall = Boxes(np.array([[(6.0, -20.0, 0.0), (6.3, 20.0, 9.0)]]))
    flight = fly_along_x(Dynamic(), wall, speed=2.0, distance_m=11.0, patience_s=10.0)
    assert max(position[0] for position in flight.positions) < 5.6
    assert min(flight.clearances_m) > 0.1


def test_a_climb_is_not_into_what_was_never_seen():
    memory = SpaceMemory(CepaParameters())
    position = np.array([0.0, 0.0, 2.0])
    unseen = memory.take_in(NOTHING.cloud(position), motion_at(0.0, position)).unseen
    middle, side = LAYERS // 2, unseen.shape[1] // 2
    assert not unseen[middle, side, side]  # its own place
    assert unseen[-1, side, side]  # right above
    far = side + 30  # 6 m ahead the Puck sees 1.6 m up
    assert not unseen[middle + 3, side, far]
    later = memory.take_in(None, motion_at(1.0, position)).unseen
    np.testing.assert_array_equal(later, unseen)  # no cloud came: what was seen stays so


def test_a_cloud_without_returns_shows_nothing():
    memory = SpaceMemory(CepaParameters())
    dark = Cloud(np.empty((0, 3)), (-0.26, 0.26), 0.5, 100.0)
    unseen = memory.take_in(dark, motion_at(0.0, (0.0, 0.0, 2.0))).unseen
    side = unseen.shape[1] // 2
    seen_cells = np.argwhere(unseen[LAYERS // 2] == 0) - side
    assert np.abs(seen_cells).max() <= 2  # nothing but the own place


def test_it_remembers_a_beam_out_of_view_until_its_time_is_over():
    beam, p = Boxes(np.array([[(2.0, -5.0, 2.2), (2.2, 5.0, 2.4)]])), CepaParameters(memory_s=2.0)
    memory, ahead = SpaceMemory(p), (LAYERS // 2 + 2, 75, 75 + 4)  # 0.3 m up, 0.4 m ahead
    for number, x in enumerate(np.arange(0.0, 1.6, 0.1)):
        position = np.array([x, 0.0, 2.0])
        space = memory.take_in(beam.cloud(position), motion_at(0.1 * number, position))
    assert space.distance[ahead] < 0.2
    gone = memory.take_in(None, motion_at(9.0, position))
    assert gone.distance[ahead] == pytest.approx(memory.far_m)


def test_it_forgets_what_later_clouds_see_through():
    person = Boxes(np.array([[(3.0, -0.3, 0.0), (3.4, 0.3, 3.0)], [(8.0, -9.0, 0.0), (8.2, 9.0, 9.0)]]))
    away, position = Boxes(person.corners[1:]), np.array([0.0, 0.0, 2.0])
    memory = SpaceMemory(CepaParameters())
    there = memory.take_in(person.cloud(position), motion_at(0.0, position)).distance[
        LAYERS // 2, 75, 75 + 30
    ]
    for number in range(1, 4):
        space = memory.take_in(away.cloud(position), motion_at(0.1 * number, position))
    assert there < 0.2
    assert space.distance[LAYERS // 2, 75, 75 + 30] > 1.0


def test_a_jump_of_the_odometry_drops_the_memory():
    memory, position = SpaceMemory(CepaParameters()), np.array([4.0, 0.0, 2.0])
    assert memory.take_in(LOW_WALL.cloud(position), motion_at(0.0, position)).points.size
    assert not memory.take_in(None, motion_at(0.1, (7.0, 0.0, 2.0))).points.size


@pytest.mark.parametrize("has_clouds", [True, False], ids=["clouds", "planar"])
def test_what_is_seen_before_odometry_comes_is_no_obstacle_afterwards(has_clouds):
    # Or walls stand where the UAV flies, as long as they are out of view: it does not know where it was then
    place, walls = np.array([0.0, 0.4, HEIGHT_M]), Boxes(np.array([[(-9.0, 1.6, 0.0), (9.0, 1.8, 6.0)]]))
    wall = Scene(walls=np.array([[-9.0, 1.6, 9.0, 1.6]]))
    angles = -math.pi + np.arange(720) * 2.0 * math.pi / 720
    ranges = wall.ranges(place[:2], np.stack([np.cos(angles), np.sin(angles)], axis=1))
    scan = LaserScan2D(np.where(ranges > 20.0, math.inf, ranges), -math.pi, 2 * math.pi / 720, 0.1, 20.0)
    sees = (NO_SCAN, walls.cloud(place)) if has_clouds else (scan, None)
    late, timely = Dynamic(), Dynamic()
    late.steer(sees[0], (0.0, 0.0), (0.0, 0.0), None, sees[1])
    for number in range(3):
        motion = motion_at(0.1 + 0.1 * number, place)
        for steering in (late, timely):
            steering.steer(sees[0], (0.0, 1.0), (0.0, 0.0), motion, sees[1])
    view = late.view()
    assert view is not None
    assert len(view.remembered_m)
    assert view.remembered_m[:, 1].min() > 1.2 - 0.01  # from the UAV: 1.6 m - 0.4 m
    np.testing.assert_array_equal(view.remembered_m, timely.view().remembered_m)


@pytest.mark.table(
    ("change", "word"),
    [
        ({"climb_max": 1.5}, "climb_max"),
        ({"climb_max": -0.1}, "climb_max"),
        ({"body_below": 4.0, "body_above": 1.5}, "body_below and body_above must be at most 5 m together"),
        ({"height_min": 3.0, "height_max": 2.0}, "height_min"),
        ({"body_below": 0.0}, "body_below"),
        ({"body_above": math.nan}, "body_above"),
    ],
)
def test_parameters_of_clouds_that_make_no_sense_are_refused(change, word):
    with pytest.raises(ParameterError, match=word):
        replace(CepaParameters(), **change)


@settings(max_examples=3)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_flight_among_boxes_drawn_at_random_touches_one(seed):
    rng = np.random.default_rng(seed)
    low = rng.uniform((2.0, -4.0, 0.0), (7.0, 4.0, 2.5), (4, 3))
    boxes = Boxes(np.stack([low, low + rng.uniform(0.05, 2.0, (4, 3))], axis=1))
    flight = fly_along_x(Dynamic(), boxes, speed=3.0, distance_m=9.0, patience_s=6.0)
    assert min(flight.clearances_m) > 0.0


def first_fault(path, around, keep):
    """Return the first step on a path (n, 3) that is too near to something, or not in what was seen."""
    distance, cell_m, layer_m, _ = around.field
    _, unseen, unseen_cell_m = around.free_space
    layers, n, _ = distance.shape
    half, unseen_half = n // 2, unseen.shape[1] // 2
    for step, (x, y, z) in enumerate(path):
        layer = math.floor(z / layer_m + 0.5) + layers // 2
        if not 0 <= layer < layers:
            return step
        corners = [
            distance[layer, math.floor(y / cell_m) + half + i, math.floor(x / cell_m) + half + j]
            for i in (0, 1)
            for j in (0, 1)
        ]
        row, column = (math.floor(c / unseen_cell_m + 0.5) + unseen_half for c in (y, x))
        if max(corners) < keep[step] or unseen[layer, row, column]:
            return step
    return None


@given(seed=st.integers(0, 2**32 - 1))
def test_no_admissible_path_leads_too_near_or_into_what_was_not_seen(seed):
    rng = np.random.default_rng(seed)
    response = response_of(CepaParameters().response, PATH_STEP_S)
    horizon, commands = Horizon(4, 60, 32, 12), rng.uniform((-3.0, -3.0, -0.8), (3.0, 3.0, 0.8), (60, 3))
    distance = np.full((LAYERS, 151, 151), 1.3)
    unseen = (rng.random((LAYERS, 75, 75)) < 0.02).astype(np.uint8)  # as the memory has it
    for layer, row, column in rng.integers((0, 10, 10), (LAYERS, 141, 141), (80, 3)):
        distance[layer, row - 5 : row + 6, column - 5 : column + 6] = rng.uniform(0.0, 0.7)
    middle = LAYERS // 2
    distance[middle - 1 : middle + 2, 65:86, 65:86], unseen[middle - 1 : middle + 2, 35:40, 35:40] = (
        1.3,
        False,
    )
    field, free_space = DistanceField(distance, 0.1, LAYER_M, 1.3), FreeSpace(np.empty(0), unseen, 0.2)
    around = Surroundings(field, free_space, np.empty((0, 6)), NO_COST_TO_GO)
    start, keep, ahead = np.zeros((3, 4)), np.full(64, 0.55), np.array([1.0, 0.0])
    clearance, beyond = np.empty(64), np.empty(64)
    cushions = Cushions(0.5, 1.2, 0.5, 0.55, np.zeros(64))
    nearest, judged, margin = braking(start, response, around, horizon, cushions, clearance, beyond)
    admissible, results = np.empty(60, np.bool_), np.zeros((60, 5))
    rules = horizon, cushions, Braking(clearance, beyond, nearest, judged)
    roll_out(start, commands, response, around, *rules, ahead, admissible, results)
    assert clearance.min() >= 0.6  # so braking at once excuses nothing
    assert margin == clearance.min() - 0.55
    assert beyond.max() <= 0.0
    for command, is_admissible in zip(commands, admissible):
        path, state = [], start.copy()
        given = np.array([[0.0, horizon.commit * PATH_STEP_S, *command]])
        for step in range(horizon.commit + horizon.brake):
            fly(state, given, 0, 1, step * PATH_STEP_S, (step + 1) * PATH_STEP_S, response)
            rests = np.linalg.norm(state[:, 1]) < AT_REST_M_S and np.hypot(*state[:2, 2]) < AT_REST_M_S2
            if step >= horizon.commit and rests:
                break
            path.append(state[:, 0].copy())
        if is_admissible:
            assert first_fault(path, around, keep) is None


def layers_with_wall(ahead_m, gap_layer=None):
    """Return layers of distances in a hallway with a wall across it, which one layer may lead over."""
    axis = 0.1 * (np.arange(151) - 75)
    sides = np.minimum(1.3, np.abs(np.abs(axis) - 3.0))[:, None]
    distance = np.tile(np.minimum(sides, np.abs(axis - ahead_m)[None, :]), (LAYERS, 1, 1))
    if gap_layer is not None:
        distance[gap_layer] = sides
    return Layers(distance, 0.1, LAYER_M * np.abs(np.arange(LAYERS) - LAYERS // 2))


def test_a_way_leads_back_only_when_what_closes_it_is_near():
    search, ahead = CostToGoSearch(CepaParameters(window_m=15.0)), np.array([1.0, 0.0])
    middle = 30  # of the grid of ways, 15 m in cells of 0.25 m

    def gain(layers, stamp_s):
        found = search.search_layers(layers, Course(ahead), motion_at(stamp_s, (0.0, 0.0, 2.0)))
        length = found.cost_to_go.length[0]
        return length[middle, middle] - length[middle, middle + 3]  # m, for 0.75 m ahead

    assert gain(layers_with_wall(5.0), 0.0) > 0.1
    assert gain(layers_with_wall(1.5, gap_layer=-1), 1.0) > 0.1  # over it
    assert gain(layers_with_wall(1.5), 2.0) < -0.1
    assert gain(layers_with_wall(5.0), 10.0) < -0.1  # it keeps turning back
    assert gain(layers_with_wall(5.0), 30.0) > 0.1  # until memory_s is over


@pytest.mark.table("climb", [-2.0, 0.0, 0.3])
def test_the_candidates_climb_at_most_as_fast_as_they_may(climb):
    level = candidates(np.array([2.0, 0.0, 1.0]), np.array([1.0, 1.0, -0.2]), 2.0)
    commands = climbing(level, climb, 0.8)
    assert np.abs(commands[:, 2]).max() == pytest.approx(0.8)
    np.testing.assert_array_equal(commands[STANDSTILL], 0.0)
    np.testing.assert_array_equal(commands[REFERENCE], (2.0, 0.0, 0.8))
    np.testing.assert_array_equal(commands[: len(level), :2], level[:, :2])
    assert set(commands[STANDSTILL + 1 : len(level), 2]) == {max(climb, -0.8)}
