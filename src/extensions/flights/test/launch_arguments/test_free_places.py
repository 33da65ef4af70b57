"""Places that are not free are refused before a flight; drawn here: one column, radius 0.3 m, at (5, 0)."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from flights.errors import ScenarioError
from flights.launch_arguments.free_places import check_course
from flights.worlds.scenario import Scenario

ROOT = Path(__file__).resolve().parents[5]
WORLD = """<sdf version="1.6"><world name="one_column">
<model name="ground_plane"><static>true</static><link name="link"><collision name="c"><geometry><plane>
<normal>0 0 1</normal><size>50 50</size></plane></geometry></collision></link></model>
<model name="column"><static>true</static><pose>5 0 2 0 0 0</pose><link name="link"><collision name="c">
<geometry><cylinder><radius>0.3</radius><length>4</length></cylinder></geometry></collision></link></model>
</world></sdf>"""
R_LB_M = 0.5


@pytest.fixture(autouse=True)
def models(monkeypatch):
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(ROOT / "src/simulation_tools/models"))


@pytest.fixture
def world(tmp_path):
    path = tmp_path / "one_column.world"
    path.write_text(WORLD)
    return path


def checked(world, start=(0.0, 0.0, 0.0, 0.0), goal=(20.0, 0.0, 2.0), keep_m=R_LB_M):
    check_course(Scenario("one_column", world, start, goal), "iris", "ust", [goal], keep_m)


def test_places_that_are_free_are_taken(world):
    checked(world)
    checked(world, goal=(5.0, 0.3 + R_LB_M + 0.01, 2.0))
    checked(world, goal=(5.0, 0.0, 4.0 + R_LB_M + 0.01))  # above the column
    checked(world, start=(5.0, 0.9, 0.0, 0.0))


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        (
            (5.0, 0.1, 2.0),
            "(5, 0.1, 2), where the UAV is to fly, lies inside of column; choose another place.",
        ),
        (
            (5.0, 0.7, 2.0),
            "(5, 0.7, 2), where the UAV is to fly, is 0.40 m from column, and CEPA keeps 0.5 m (r_lb) away; "
            "choose a place farther from it.",
        ),
    ],
)
def test_a_goal_in_or_near_an_obstacle_is_refused(world, goal, sentence):
    with pytest.raises(ScenarioError) as error:
        checked(world, goal=goal)
    assert str(error.value) == sentence


def test_an_avoidance_of_ones_own_may_fly_nearer_but_not_into_it(world):
    checked(world, goal=(5.0, 0.7, 2.0), keep_m=0.0)
    with pytest.raises(ScenarioError, match="lies inside of column"):
        checked(world, goal=(5.0, 0.1, 2.0), keep_m=0.0)


def test_a_start_inside_of_an_obstacle_is_refused(world):
    with pytest.raises(ScenarioError, match=r"At \(5, 0\.2, 0\) the UAV would start inside of column"):
        checked(world, start=(5.0, 0.2, 0.0, 0.0))


def test_a_world_without_a_floor_is_refused(tmp_path):
    path = tmp_path / "no_floor.world"
    path.write_text(re.sub(r'<model name="ground_plane">.*?</model>', "", WORLD, flags=re.DOTALL))
    sentence = r"At \(0, 0, 0\) nothing is below the UAV, so it would fall; .*model://ground_plane"
    with pytest.raises(ScenarioError, match=sentence):
        checked(path)


def mesh_world(folder, *parts):
    """A world that is one mesh, and has no ground plane."""
    stl = folder / f"{len(parts)}.stl"  # read once for each path
    trimesh.util.concatenate(list(parts)).export(stl)
    path = folder / "mesh.world"
    path.write_text(
        '<sdf version="1.6"><world name="mesh"><model name="ship"><static>true</static><link name="link">'
        f'<collision name="c"><geometry><mesh><uri>{stl.as_uri()}</uri></mesh></geometry>'
        "</collision></link></model></world></sdf>"
    )
    return path


def box(low, high, inward=False):
    body = trimesh.creation.box(bounds=(low, high))
    if inward:
        body.invert()
    return body


HULL = box((-11.0, -9.0, -1.0), (11.0, 9.0, 11.0))
HOLD = box((-10.0, -8.0, 0.0), (10.0, 8.0, 10.0), inward=True)
WING_TANK = box((-9.9, 3.0, 0.1), (9.9, 7.9, 5.0))


def test_a_start_inside_of_a_solid_of_a_mesh_is_refused(tmp_path):
    path = mesh_world(tmp_path, HULL, HOLD, WING_TANK)
    with pytest.raises(ScenarioError, match=r"At \(0, 5, 0\.2\) the UAV would start inside of ship"):
        checked(path, start=(0.0, 5.0, 0.2, 0.0), goal=(5.0, 0.0, 2.0))
    checked(path, goal=(5.0, 0.0, 2.0))  # beside it, in the cavity of the hull
    checked(path, start=(0.0, 5.0, 5.0, 0.0), goal=(5.0, 0.0, 2.0))  # on its top


def test_a_hall_whose_faces_are_drawn_the_wrong_way_round_is_no_solid(tmp_path):
    hall, crate = box((-10.0, -8.0, 0.0), (10.0, 8.0, 10.0)), box((2.0, 2.0, 0.0), (3.0, 3.0, 1.0))
    checked(mesh_world(tmp_path, hall, crate), goal=(5.0, 0.0, 2.0))


def test_a_start_in_the_air_is_refused_and_one_on_a_grating_is_not(tmp_path):
    hatch = box((-4.0, -4.0, 11.0), (4.0, 4.0, 11.2))
    with pytest.raises(
        ScenarioError, match=r"At \(0, 0, 26\.2\) the UAV would start 15\.0 m above .* 11\.20"
    ):
        checked(mesh_world(tmp_path, HULL, HOLD, hatch), start=(0.0, 0.0, 26.2, 0.0), goal=(5.0, 0.0, 30.0))
    bars = [box((x - 0.005, -3.0, 4.97), (x + 0.005, 3.0, 5.0)) for x in np.arange(-3.015, 3.0, 0.03)]
    checked(mesh_world(tmp_path, HULL, HOLD, *bars), start=(0.0, 0.0, 5.0, 0.0), goal=(5.0, 0.0, 8.0))


BEAM = """<model name="beam"><static>true</static><pose>0 0 {} 0 0 0</pose><link name="link">
<collision name="c"><geometry><box><size>0.2 6 0.2</size></box></geometry></collision></link></model>
</world>"""


@pytest.fixture
def under_beam(tmp_path):
    def path_of(bottom_m):
        path = tmp_path / "beam.world"
        path.write_text(WORLD.replace("</world>", BEAM.format(bottom_m + 0.1)))
        return path

    return path_of


@pytest.mark.parametrize("bottom_m", [1.0, 2.0])
def test_a_start_below_what_the_take_off_meets_is_refused(under_beam, bottom_m):
    sentence = (
        f"Over (0, 0, 0) the UAV would climb into beam, {bottom_m - 0.1:.1f} m high. It takes off to 2 m;"
    )
    with pytest.raises(ScenarioError, match=re.escape(sentence)):
        checked(under_beam(bottom_m))
    checked(under_beam(bottom_m), start=(0.6, 0.0, 0.0, 0.0))


def test_a_start_below_what_hangs_higher_is_taken(under_beam):
    checked(under_beam(2.4))


def test_a_uav_may_start_on_terrain():
    hills = ROOT / "src/simulation_tools/worlds/hills.world"
    check_course(Scenario("hills", hills, goal_xyz_m=(20.0, 0.0, 9.0)), "iris", "ust", [], R_LB_M)


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        ((3.0, 20.0, -2.0), "(3, 20, -2), where the UAV is to fly, lies below the ground; choose a height"),
        (
            (3.0, 20.0, 0.05),
            "(3, 20, 0.05), where the UAV is to fly, is 0.05 m above the ground. The UAV stands",
        ),
    ],
)
@pytest.mark.parametrize("keep_m", [R_LB_M, 0.0])
def test_a_goal_below_or_on_the_ground_is_refused(world, goal, sentence, keep_m):
    with pytest.raises(ScenarioError, match=re.escape(sentence)):
        checked(world, goal=goal, keep_m=keep_m)


def test_a_goal_inside_of_a_hill_is_refused():
    """The ground is at 0 m at the start, and at 2.2 m at the goal."""
    hills = ROOT / "src/simulation_tools/worlds/hills.world"
    goal = (20.0, 0.0, 1.0)
    with pytest.raises(ScenarioError, match=r"\(20, 0, 1\), where the UAV is to fly, lies below the ground"):
        check_course(Scenario("hills", hills, goal_xyz_m=goal), "iris", "ust", [goal], R_LB_M)


def test_a_start_below_the_ground_is_refused(world):
    with pytest.raises(ScenarioError, match=r"At \(0, 0, -3\) the UAV would start below the ground"):
        checked(world, start=(0.0, 0.0, -3.0, 0.0))


PAD = """<model name="pad"><static>true</static><pose>0 0 -0.5 0 0 0</pose><link name="link">
<collision name="c"><geometry><box><size>4 4 1</size></box></geometry></collision></link></model>"""


def test_beyond_the_edge_of_all_ground_there_is_no_below(tmp_path):
    path = tmp_path / "pad.world"
    path.write_text(re.sub(r'<model name="ground_plane">.*?</model>', PAD, WORLD, flags=re.DOTALL))
    checked(path, goal=(20.0, 0.0, -2.0))


def test_a_model_may_be_called_place(world):
    world.write_text(WORLD.replace('name="column"', 'name="place"'))
    checked(world)
    with pytest.raises(ScenarioError, match="inside of place"):
        checked(world, goal=(5.0, 0.0, 2.0))


LOW = """<sdf version="1.6"><world name="low">
<model name="floor"><static>true</static><pose>0 0 -0.1 0 0 0</pose><link name="link"><collision name="c">
<geometry><box><size>8 8 0.2</size></box></geometry></collision></link></model>
<model name="deck"><static>true</static><pose>0 0 {middle} 0 0 0</pose><link name="link"><collision name="c">
<geometry><box><size>8 8 0.2</size></box></geometry></collision></link></model></world></sdf>"""


def hover_m(tmp_path, ceiling_m, model="iris", keep_m=R_LB_M, given_m=None):
    path = tmp_path / "low.world"
    path.write_text(LOW.format(middle=ceiling_m + 0.1))
    flown = Scenario("low", path, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), comes_home=True)
    return check_course(flown, model, "puck", [], keep_m, given_m)


@pytest.mark.table(
    ("ceiling_m", "uav", "height_m"),
    [
        (4.0, ("iris", 0.5), 2.0),
        (2.0, ("iris", 0.5), 1.3),  # 1.5 m keep 0.5 m from the deck, and 0.2 m are spare
        (1.2, ("small_quad", 0.22), 0.78),
        (0.9, ("small_quad", 0.22), 0.49),
    ],
)
def test_the_room_above_the_start_says_how_high_to_take_off(tmp_path, ceiling_m, uav, height_m):
    assert hover_m(tmp_path, ceiling_m, *uav) == pytest.approx(height_m, abs=0.05)


def test_a_uav_that_does_not_fit_stays_on_the_ground_with_a_sentence(tmp_path):
    with pytest.raises(ScenarioError, match=r"there is room for 0\.\d\d m only. CEPA keeps 0\.5 m"):
        hover_m(tmp_path, 0.9)
    with pytest.raises(ScenarioError, match=r"would climb into deck, 1\.\d m high. It takes off to 1\.9 m"):
        hover_m(tmp_path, 2.0, given_m=1.9)
