"""The room and the hold have the thesis's measures, and their missions lead through free space."""

import numpy as np
import pytest

from flights.mapping.mapping_flight import SCENARIOS
from flights.worlds import experiments_3_4, floor_plan, true_walls
from simulation_tools.sdf.elements import Box
from simulation_tools.sdf.parser import load_world

FLIGHT_HEIGHT_M = 2.0


@pytest.fixture(params=experiments_3_4.MAKERS)
def name(request):
    return request.param


@pytest.fixture
def world(name, worlds_folder):
    return load_world(str(worlds_folder / f"{name}.world"), ())


def faces_of(world, inside_xy):
    return true_walls.seen_faces(floor_plan.outlines(world), FLIGHT_HEIGHT_M, inside_xy)


def distance_to(faces, point):
    starts, along = faces[:, 0], faces[:, 1] - faces[:, 0]
    share = np.clip(((point - starts) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return np.linalg.norm(starts + share[:, None] * along - point, axis=1).min()


def test_the_simulator_knows_everything_in_it(world):
    assert world.warnings == ()


def test_a_leaning_lidar_sees_the_same_plan_at_every_height(world):
    for outline in floor_plan.outlines(world):
        assert outline.bottom_m == pytest.approx(0.0)
        assert outline.top_m >= FLIGHT_HEIGHT_M + 1.0


def test_the_hold_is_the_thesis_s(worlds_folder):
    """20 x 30 m; beams 1 m wide and 0.5 m deep, every 3 m, on all four sides (figure 8.13)."""
    world = load_world(str(worlds_folder / "hold.world"), ())
    faces = faces_of(world, (0.0, 0.0))
    points = faces.reshape(-1, 2)
    assert np.allclose(points.max(axis=0) - points.min(axis=0), (30.0, 20.0))
    beams = [model for model in world.models if model.name.startswith("beam")]
    assert all(
        isinstance(beam.links[0].collisions[0].geometry, Box)
        and beam.links[0].collisions[0].geometry.size_m[:2] == (0.5, 1.0)
        for beam in beams
    )
    for side, axis, count in (("left", 0, 10), ("right", 0, 10), ("ahead", 1, 7), ("behind", 1, 7)):
        places = np.sort([b.pose.position_m[axis] for b in beams if side in b.name])
        assert len(places) == count
        assert np.allclose(np.diff(places), 3.0)
    # the plating's 100 m, and two sides of 0.5 m of each of the 34 beams
    assert np.linalg.norm(faces[:, 1] - faces[:, 0], axis=1).sum() == pytest.approx(100.0 + 34 * 2 * 0.5)


def test_the_room_has_what_figure_8_8_shows(worlds_folder):
    world = load_world(str(worlds_folder / "room.world"), ())
    kinds = [model.name.rsplit("_", 1)[0] for model in world.models]
    assert (kinds.count("column"), kinds.count("box"), kinds.count("wall")) == (5, 6, 4)
    shelf = next(model for model in world.models if model.name == "bookshelf")
    assert len(shelf.links[0].collisions) == 3  # a back and two sides: [
    faces = faces_of(world, (-5.5, -0.5))
    inner = shelf.pose.position_m[:2]
    assert distance_to(faces, np.array(inner)) > 0.2  # open: its inside is seen, and empty


@pytest.mark.parametrize("name", SCENARIOS)
def test_missions_keep_clear_of_everything(name):
    scenario = SCENARIOS[name]
    start = np.array(scenario.start_xyz_yaw[:2])
    faces = faces_of(load_world(str(scenario.world_path), ()), start)
    places = np.array([start, *(w.position_m[:2] for w in scenario.waypoints)])
    for a, b in zip(places, places[1:]):
        for share in np.linspace(0.0, 1.0, 20):
            assert distance_to(faces, a + share * (b - a)) > 0.85, (a, b)  # r_LB is 0.5 m


def test_the_round_trip_is_3_m_from_the_plating_and_ends_where_it_began():
    scenario = SCENARIOS["hold"]
    places = np.array([w.position_m[:2] for w in scenario.waypoints])
    to_side = np.minimum(15.0 - np.abs(places[:, 0]), 10.0 - np.abs(places[:, 1]))
    assert np.allclose(to_side, 3.0)
    assert np.allclose(places[-1], scenario.start_xyz_yaw[:2])
