"""Spawning, deleting, states, contacts and clearances."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose, quaternion_normalised
from simulation_tools.sdf.elements import World
from simulation_tools.sdf.frames import attach
from simulation_tools.sdf.parser import load_model, parse_model
from simulation_tools.world.shapes.terrain import MeshError
from simulation_tools.world.world import BodyState, PhysicsWorld, WorldError

from .conftest import box, mass, model, shape, solid_box, still_box

AHEAD = np.array(((1.0, 0.0, 0.0),))
ROTORS = frozenset(f"rotor_{number}_joint" for number in range(4))

VECTOR = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
QUATERNION = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: sum(c * c for c in q) > 0.1)
    .map(quaternion_normalised)
)
STATE = st.builds(BodyState, st.builds(Pose, VECTOR, QUATERNION), VECTOR, VECTOR)


def sees(world, origin=(0.0, 0.0, 0.0), ignore=None):
    return float(world.rays.cast(np.array(origin), AHEAD, 100.0, ignore)[0])


# -- coming and going ----------------------------------------------------------------------------------------
def test_models_come_and_go_for_eyes_and_for_hands(build):
    world = build(still_box(1, 1, 1, "far").placed(pose=Pose.from_xyz_rpy(5, 0, 0)))
    assert sees(world) == pytest.approx(4.5)
    world.spawn(still_box(1, 1, 1), "near", Pose.from_xyz_rpy(2, 0, 0))
    assert world.model_names() == ["far", "near"]
    assert sees(world) == pytest.approx(1.5)
    world.delete("near")
    assert world.model_names() == ["far"]
    assert sees(world) == pytest.approx(4.5)
    # And a body now flies through where it was
    world.spawn(solid_box(0.2, 0.2, 0.2, 1), "ball", Pose())
    world.set_state("ball", BodyState(Pose(), (10.0, 0.0, 10 * 0.0)))
    for _ in range(50):
        world.step()
    assert world.get_state("ball").pose.position_m[0] == pytest.approx(2.0, abs=1e-6)


def test_a_thousand_models_may_come_and_go_in_silence(build, capfd):
    world = build(ground=True)
    for k in range(1000):
        world.spawn(
            solid_box(0.2, 0.2, 0.2, 1) if k % 2 else still_box(1, 1, 1), "m", Pose.from_xyz_rpy(3, 0, 1)
        )
        if k % 100 < 2:
            world.step()
            assert sees(world, (0, 0, 1)) == pytest.approx(2.9 if k % 2 else 2.5, abs=1e-4)
        world.delete("m")
    assert sees(world, (0, 0, 1)) == math.inf
    world.close()
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("action", ["get_state", "delete", "model", "mass_kg", "contacts"])
def test_what_is_not_there_is_said(build, action):
    with pytest.raises(WorldError, match='There is no model called "ghost"'):
        getattr(build(), action)("ghost")


def test_a_name_is_taken_once(build):
    world = build(still_box(1, 1, 1, "wall"))
    with pytest.raises(WorldError, match='already a model called "wall"'):
        world.spawn(still_box(1, 1, 1), "wall", Pose())


def test_a_model_that_cannot_be_built_leaves_the_world_as_it_was(build, tmp_path):
    world = build(still_box(1, 1, 1, "wall").placed(pose=Pose.from_xyz_rpy(3, 0, 0)))
    world.spawn(solid_box(1, 1, 1, 1), "b", Pose.from_xyz_rpy(0, 9, 0))
    (tmp_path / "m.stl").write_bytes(b"nothing")
    mesh = shape(f"<mesh><uri>file://{tmp_path}/m.stl</uri></mesh>")
    broken_mesh = parse_model(
        f'<sdf version="1.6"><model name="m"><link name="l">{mesh}</link></model></sdf>', "t", [tmp_path]
    )
    falling_plane = model(f'<link name="l">{shape("<plane/>")}</link>')
    hinged = model('<link name="l"/>')
    for bad, rigid, error in (
        (broken_mesh, frozenset(), MeshError),
        (falling_plane, frozenset(), WorldError),
        (hinged, frozenset({"no_such_joint"}), WorldError),
    ):
        with pytest.raises(error):
            world.spawn(bad, "bad", Pose(), rigid)
        assert world.model_names() == ["wall", "b"]
        assert sees(world) == pytest.approx(2.5)
        world.step()
        assert world.contacts("b") == []


def test_two_worlds_in_one_process_do_not_meet(build):
    here, there = build(), build(gravity=(0.0, 0.0, -1.6))
    for world in (here, there):
        world.spawn(solid_box(1, 1, 1, 1), "b", Pose())
        world.step()
    assert here.get_state("b").linear_velocity_m_s[2] == pytest.approx(-9.8 * 0.004)
    assert there.get_state("b").linear_velocity_m_s[2] == pytest.approx(-1.6 * 0.004)


def test_the_time_step_can_change_between_steps(build):
    world = build(solid_box(1, 1, 1, 1))
    world.step()
    world.settings.time_step_s = 0.001
    world.step()
    assert world.get_state("thing").linear_velocity_m_s[2] == pytest.approx(-9.8 * 0.005)


def test_closing_twice_is_harmless():
    world = PhysicsWorld(World("w", ()))
    world.close()
    world.close()


# -- states --------------------------------------------------------------------------------------------------
@given(STATE)
def test_a_state_comes_back_as_it_was_set_wherever_the_centre_of_mass_is(state):
    world = PhysicsWorld(World("w", ()))
    world.spawn(
        model(f'<link name="l">{mass(2, 0.1, 0.2, 0.25, "0.3 -0.1 0.2 0.1 0.2 0.3")}</link>'), "b", Pose()
    )
    world.set_state("b", state)
    got = world.get_state("b")
    world.close()
    np.testing.assert_allclose(got.pose.position_m, state.pose.position_m, atol=1e-9)
    assert abs(np.dot(got.pose.orientation_xyzw, state.pose.orientation_xyzw)) == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(got.linear_velocity_m_s, state.linear_velocity_m_s, atol=1e-9)
    np.testing.assert_allclose(got.angular_velocity_rad_s, state.angular_velocity_rad_s, atol=1e-9)


def test_a_static_model_can_be_put_elsewhere(build):
    world = build(still_box(1, 1, 1, "wall").placed(pose=Pose.from_xyz_rpy(3, 0, 0)))
    world.set_state("wall", BodyState(Pose.from_xyz_rpy(6, 0, 0, 0, 0, math.pi / 4)))
    assert world.get_state("wall").pose.position_m == (6.0, 0.0, 0.0)
    assert sees(world) == pytest.approx(6 - math.sqrt(0.5), abs=1e-5)
    world.spawn(solid_box(1, 1, 1, 1), "b", Pose.from_xyz_rpy(0, 0, 0))
    assert world.clearance("b", None, 20.0) == pytest.approx(5.5 - math.sqrt(0.5), abs=1e-3)


def test_a_moving_model_is_seen_where_it_is(build):
    world = build(gravity=(0.0, 0.0, 0.0))
    world.spawn(solid_box(1, 1, 1, 1), "b", Pose.from_xyz_rpy(3, 0, 0))
    assert sees(world) == pytest.approx(2.5)
    world.set_state("b", BodyState(Pose.from_xyz_rpy(3, 0, 0), (1.0, 0.0, 0.0)))
    for _ in range(250):
        world.step()
    assert sees(world) == pytest.approx(3.5, abs=1e-5)
    assert math.isinf(sees(world, ignore="b"))


def test_the_links_of_a_moving_model_are_seen_where_their_joints_put_them(build):
    world = build(gravity=(0.0, 0.0, 0.0))
    arm = model(
        f'<link name="hub">{mass(100, 10, 10, 10)}</link>'
        f'<link name="arm"><pose>2 0 0 0 0 0</pose>{mass(1, 1, 1, 1)}{shape(box(1, 0.2, 0.2))}</link>'
        '<joint name="j" type="revolute"><pose>-2 0 0 0 0 0</pose><parent>hub</parent><child>arm</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint>"
    )
    world.spawn(arm, "m", Pose.from_xyz_rpy(1, 0, 0))
    assert sees(world) == pytest.approx(2.5)
    assert world.clearance("m", None, 5.0) == math.inf
    world.set_state("m", BodyState(Pose.from_xyz_rpy(1, -2, 0, 0, 0, math.pi / 2)))
    assert sees(world) == pytest.approx(0.9, abs=1e-5)


def test_a_state_or_a_wrench_that_is_not_finite_is_refused(build):
    world = build(solid_box(1, 1, 1, 1))
    with pytest.raises(WorldError, match="not finite"):
        world.set_state("thing", BodyState(Pose((math.nan, 0.0, 0.0))))
    with pytest.raises(WorldError, match="not finite"):
        world.apply_wrench("thing", (math.inf, 0, 0), (0, 0, 0))


def test_a_reset_puts_everything_back_and_keeps_what_was_spawned(build):
    world = build(still_box(1, 1, 1, "wall").placed(pose=Pose.from_xyz_rpy(3, 0, 0)))
    world.spawn(solid_box(1, 1, 1, 1), "b", Pose.from_xyz_rpy(0, 9, 0))
    world.set_state("wall", BodyState(Pose.from_xyz_rpy(8, 0, 0)))
    for _ in range(10):
        world.step()
    world.reset()
    assert world.model_names() == ["wall", "b"]
    assert world.get_state("b") == BodyState(Pose.from_xyz_rpy(0, 9, 0))
    assert sees(world) == pytest.approx(2.5)


# -- contacts ------------------------------------------------------------------------------------------------
def test_a_contact_names_both_shapes_and_carries_the_weight(build):
    world = build(ground=True)
    table = model(
        '<link name="top">' + mass(2, 1, 1, 1) + shape(box(1, 1, 0.1), name="plate") + "</link>"
        '<link name="leg"><pose>0 0 -.3 0 0 0</pose>'
        + mass(1, 1, 1, 1)
        + shape("<cylinder><radius>.2</radius><length>.5</length></cylinder>", name="post")
        + '</link><joint name="j" type="fixed"><parent>top</parent><child>leg</child></joint>'
    )
    world.spawn(table, "table", Pose.from_xyz_rpy(0, 0, 0.55))
    world.spawn(solid_box(0.1, 0.1, 0.1, 0.5), "cup", Pose.from_xyz_rpy(0, 0, 0.65))
    for _ in range(500):
        world.step()
    pairs = {(contact.collision_1, contact.collision_2) for contact in world.contacts("table")}
    assert pairs == {
        ("table::leg::post", "ground_plane::link::collision"),
        ("table::top::plate", "cup::l::c"),
    }
    below = [contact for contact in world.contacts("table") if contact.normal[2] > 0]
    assert sum(contact.force_n for contact in below) == pytest.approx(3.5 * 9.8, rel=0.02)
    assert all(abs(contact.position_m[2]) < 1e-3 for contact in below)


def test_a_static_wall_names_the_shape_that_was_hit(build):
    wall = model(
        '<static>true</static><link name="l">'
        + shape(box(1, 1, 1), "3 0 0 0 0 0", "front")
        + shape(box(1, 1, 1), "-3 0 0 0 0 0", "back")
        + "</link>",
        "wall",
    )
    world = build(wall, gravity=(0.0, 0.0, 0.0))
    world.spawn(solid_box(0.2, 0.2, 0.2, 1), "b", Pose.from_xyz_rpy(2, 0, 0))
    world.set_state("b", BodyState(Pose.from_xyz_rpy(2, 0, 0), (2.0, 0.0, 0.0)))
    touched = []
    for _ in range(200):
        world.step()
        touched += world.contacts("b")
    assert {contact.collision_2 for contact in touched} == {"wall::l::front"}
    assert all(contact.normal[0] == pytest.approx(-1.0, abs=1e-3) for contact in touched)


# -- clearances ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("pose", [None, Pose.from_xyz_rpy(1, 0, 0)])
def test_the_clearance_of_a_ball_to_boxes_and_trunks_is_that_of_closed_form(build, pose):
    world = build(gravity=(0.0, 0.0, 0.0), ground=True)
    ball = model(f'<link name="l">{shape("<sphere><radius>.5</radius></sphere>")}</link>')
    trunk = model(
        '<static>true</static><link name="l">'
        + shape("<cylinder><radius>.25</radius><length>6</length></cylinder>")
        + "</link>"
    )
    world.spawn(ball, "ball", pose or Pose.from_xyz_rpy(0, 0, 0.4))
    world.spawn(trunk, "trunk", Pose.from_xyz_rpy(3, 4, 0))
    world.spawn(still_box(2, 2, 2), "crate", Pose.from_xyz_rpy(-9, 0, 0))
    x = 0.0 if pose is None else 1.0
    expected = math.hypot(3 - x, 4) - 0.25 - 0.5
    assert world.clearance("ball", pose, 10.0) == pytest.approx(expected, abs=1e-6)
    assert world.clearance("ball", pose, expected - 0.1) == math.inf
    # The ground counts unless it is ignored, which it is by default; the ball is in it by 10 or by 50 cm.
    depth = -0.1 if pose is None else -0.5
    assert world.clearance("ball", pose, 10.0, ignore=()) == pytest.approx(depth, abs=1e-6)
    without = world.clearance("ball", pose, 10.0, ignore=("ground_plane", "trunk"))
    assert without == pytest.approx(x + 8 - 0.5, abs=1e-6)


@given(st.floats(0.6, 4.0), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_the_clearance_of_the_iris_to_a_trunk(distance, bearing, yaw):
    # Against its outline from above: the corners of the rotor discs and legs, the body's box.
    world = PhysicsWorld(World("w", ()))
    iris = load_model("model://iris")
    trunk = model(
        '<static>true</static><link name="l">'
        + shape("<cylinder><radius>.2</radius><length>6</length></cylinder>")
        + "</link>"
    )
    world.spawn(iris, "iris", Pose.from_xyz_rpy(0, 0, 1), ROTORS)
    x, y = distance * math.cos(bearing), distance * math.sin(bearing)
    world.spawn(trunk, "trunk", Pose.from_xyz_rpy(x, y, 1))
    measured = world.clearance("iris", Pose.from_xyz_rpy(0, 0, 1, 0, 0, yaw), 10.0)
    world.close()
    bx, by, _ = Pose.from_xyz_rpy(0, 0, 0, 0, 0, -yaw).transform(np.array((x, y, 0.0)))
    to_rotors = min(
        math.hypot(bx - rx, by - ry) - 0.128
        for rx, ry in ((0.13, -0.22), (-0.13, 0.20), (0.13, 0.22), (-0.13, -0.20))
    )
    to_body = math.hypot(max(abs(bx) - 0.14, 0.0), max(abs(by) - 0.07, 0.0))
    to_legs = min(math.hypot(bx - 0.11 * i, by - 0.13 * j) - 0.01 for i in (-1, 1) for j in (-1, 1))
    assert measured == pytest.approx(min(to_rotors, to_body, to_legs) - 0.2, abs=1e-3)


def test_a_mesh_counts_by_its_surface_whether_it_stands_or_moves(build, tmp_path):
    # A U of three slabs, open upwards: a ball inside does not touch it.
    slabs = [trimesh.creation.box((3, 3, 0.2))] + [trimesh.creation.box((0.2, 3, 3)) for _ in range(2)]
    slabs[1].apply_translation((-1.4, 0, 1.4))
    slabs[2].apply_translation((1.4, 0, 1.4))
    trimesh.util.concatenate(slabs).export(tmp_path / "u.stl")
    link = f'<link name="l">{shape(f"<mesh><uri>file://{tmp_path}/u.stl</uri></mesh>")}</link>'
    world = build(gravity=(0.0, 0.0, 0.0))
    ball = model(f'<link name="l">{shape("<sphere><radius>.5</radius></sphere>")}</link>')
    world.spawn(ball, "ball", Pose.from_xyz_rpy(0, 0, 1.5))

    def parsed(static):
        text = f'<sdf version="1.6"><model name="u"><static>{static}</static>{link}</model></sdf>'
        return parse_model(text, "t", [tmp_path])

    world.spawn(parsed("true"), "u", Pose())
    assert world.clearance("ball", None, 5.0) == pytest.approx(1.3 - 0.5, abs=2e-3)
    assert sees(world, (0, 0, 1.5), "ball") == pytest.approx(1.3, abs=1e-5)
    world.delete("u")
    world.spawn(parsed("false"), "u", Pose())
    assert world.clearance("ball", None, 5.0) == pytest.approx(1.3 - 0.5, abs=2e-3)
    assert sees(world, (0, 0, 1.5), "ball") == pytest.approx(1.3, abs=1e-5)


def test_nothing_near_nothing_in_the_way(build):
    world = build(solid_box(1, 1, 1, 1))
    assert world.clearance("thing", None, 100.0) == math.inf
    assert world.contacts("thing") == []


def test_the_lidar_of_the_iris_is_part_of_what_must_not_touch(build):
    iris = attach(load_model("model://iris"), load_model("model://lidar_m8"), "lidar_mount")
    world = build(gravity=(0.0, 0.0, 0.0))
    world.spawn(iris, "iris", Pose(), ROTORS)
    world.spawn(still_box(4, 4, 0.2), "ceiling", Pose.from_xyz_rpy(0, 0, 0.5))
    assert world.clearance("iris", None, 1.0) == pytest.approx(0.4 - (0.062 + 0.087), abs=1e-4)
    assert world.mass_kg("iris") == pytest.approx(2.3)
