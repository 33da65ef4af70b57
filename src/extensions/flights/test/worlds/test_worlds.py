"""The worlds are what their generator writes, valid SDF, dense, wide and free where they are said to be."""

import math

import numpy as np
import pytest

from flights.errors import ScenarioError
from flights.worlds import experiment_1, floor_plan, generator
from flights.worlds.scenario import SCENARIOS
from simulation_tools.sdf.elements import Cylinder
from simulation_tools.sdf.parser import load_world

START, GOAL = np.array((0.0, 0.0)), np.array((40.0, 0.0))
FLIGHT_HEIGHT_M = 2.0
BODY_RADIUS_M = 0.4  # the Iris with its rotors, generously


@pytest.fixture(params=SCENARIOS)
def name(request):
    return request.param


@pytest.fixture
def world(name, worlds_folder):
    return load_world(str(worlds_folder / f"{name}.world"), ())


def distance_to_polygon(point, corners):
    """Least distance to the polygon's edges; 0 inside (corners counter-clockwise)."""
    following = np.roll(corners, -1, axis=0)
    edges, to_point = following - corners, point - corners
    inside = np.all(edges[:, 0] * to_point[:, 1] - edges[:, 1] * to_point[:, 0] >= 0)
    along = np.clip((edges * to_point).sum(axis=1) / (edges**2).sum(axis=1), 0, 1)
    return 0.0 if inside else np.linalg.norm(to_point - along[:, None] * edges, axis=1).min()


def test_there_are_the_four_of_table_8_1():
    assert tuple(experiment_1.MAKERS) == SCENARIOS == ("empty", "sparse", "forest", "hallway")


def test_an_unknown_world_is_refused_with_the_choices():
    choices = "empty, sparse, forest, hallway, room, hold, hold_3d, hold_3d_cargo, ballast_tank"
    with pytest.raises(ScenarioError, match=f"no world 'jungle'; choose one of {choices}"):
        generator.make("jungle")


@pytest.mark.table("any_name", generator.MAKERS)
def test_the_file_is_what_the_generator_writes(any_name, worlds_folder):
    assert (worlds_folder / f"{any_name}.world").read_text() == generator.make(any_name)


def test_the_file_is_small(name, worlds_folder):
    assert (worlds_folder / f"{name}.world").stat().st_size < 150_000


def test_the_simulator_knows_everything_in_it(world):
    assert world.warnings == ()


def test_start_and_goal_are_free_for_a_take_off_and_a_landing(world):
    for outline in floor_plan.outlines(world):
        for place in (START, GOAL):
            assert distance_to_polygon(place, outline.outline_xy) >= BODY_RADIUS_M + 0.6, outline.name


def test_a_lidar_at_flight_height_sees_all_that_is_in_the_way(world):
    """Nothing solid ends within 0.4 m above or below the lidar's plane."""
    for outline in floor_plan.outlines(world):
        if outline.blocks(FLIGHT_HEIGHT_M):
            assert outline.top_m >= FLIGHT_HEIGHT_M + 0.4, outline.name
        else:
            assert outline.top_m <= 1.2 or outline.bottom_m >= FLIGHT_HEIGHT_M + 0.6, outline.name


def test_the_straight_way_is_blocked_except_in_the_empty_field(name, world):
    line = np.linspace(START, GOAL, 401)
    shapes = [o.outline_xy for o in floor_plan.outlines(world) if o.blocks(FLIGHT_HEIGHT_M)]
    blocked = any(distance_to_polygon(p, shape) < BODY_RADIUS_M for p in line for shape in shapes)
    assert blocked is (name != "empty")


def test_the_forest_is_dense_but_passable(worlds_folder):
    world = load_world(str(worlds_folder / "forest.world"), ())
    trunks = [m for m in world.models if m.name.startswith("tree_")]
    spots = np.array([m.pose.position_m[:2] for m in trunks])
    radii = [m.links[0].collisions[0].geometry.radius_m for m in trunks]
    apart = np.linalg.norm(spots[:, None] - spots[None, :], axis=2) + 1e9 * np.eye(len(spots))
    assert 100 <= len(trunks) <= 200
    assert all(isinstance(m.links[0].collisions[0].geometry, Cylinder) for m in trunks)
    assert min(radii) >= 0.12
    assert max(radii) <= 0.30
    assert apart.min() >= 2.6
    assert np.median(apart.min(axis=1)) < 3.0  # nobody is alone


def test_the_hallway_is_three_metres_wide(worlds_folder):
    """Measured between the walls' faces, across, at places without doors and furniture."""
    world = load_world(str(worlds_folder / "hallway.world"), ())
    walls = [o for o in floor_plan.outlines(world) if o.name.startswith("hallway_")]
    for x, middle in ((1.0, 0.0), (9.8, 0.0), (14.5, 1.0), (31.0, 0.0), (41.0, 0.0)):
        to_left = min(distance_to_polygon((x, middle), o.outline_xy) for o in walls if "left" in o.name)
        to_right = min(distance_to_polygon((x, middle), o.outline_xy) for o in walls if "right" in o.name)
        assert math.isclose(to_left + to_right, 3.0, abs_tol=0.03), x


def test_every_passage_of_the_hallway_is_wide_enough(worlds_folder):
    """A body of 0.5 m radius (r_LB) gets from start to goal: flood fill on a 10 cm grid."""
    world = load_world(str(worlds_folder / "hallway.world"), ())
    shapes = [o.outline_xy for o in floor_plan.outlines(world) if o.blocks(FLIGHT_HEIGHT_M)]
    xs, ys = np.arange(0.0, 40.05, 0.1), np.arange(-3.0, 4.0, 0.1)
    free = np.ones((len(xs), len(ys)), dtype=bool)
    for shape in shapes:
        low, high = shape.min(axis=0) - 0.6, shape.max(axis=0) + 0.6
        for i in np.flatnonzero((xs >= low[0]) & (xs <= high[0])):
            for j in np.flatnonzero((ys >= low[1]) & (ys <= high[1])):
                free[i, j] &= distance_to_polygon(np.array((xs[i], ys[j])), shape) > 0.5
    reached = np.zeros_like(free)
    reached[0, 30] = True
    while True:
        grown = reached.copy()
        grown[1:] |= reached[:-1]
        grown[:-1] |= reached[1:]
        grown[:, 1:] |= reached[:, :-1]
        grown[:, :-1] |= reached[:, 1:]
        grown &= free
        if (grown == reached).all():
            break
        reached = grown
    assert reached[400, 30]
