"""URDF as a model: the same places, masses and joints as URDF's own rules give by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.sdf.elements import Box, Cylinder, RaySensor, Sphere
from simulation_tools.sdf.parser import SdfError, load_model, load_world, parse_model
from simulation_tools.sdf.urdf import urdf_of

ARM = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base">
    <inertial><origin xyz="0 0 0.1"/><mass value="2"/>
      <inertia ixx="1" iyy="2" izz="2.5" ixy="0.1" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.5"/><geometry><box size="1 2 3"/></geometry></collision>
    <visual><geometry><sphere radius="0.3"/></geometry>
      <material name="m"><color rgba="1 0 0 1"/></material></visual>
  </link>
  <link name="upper"><collision><geometry><cylinder radius="0.1" length="2"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><axis xyz="0 2 0"/>
    <limit lower="-1" upper="0.5" effort="9" velocity="9"/><dynamics damping="0.2" friction="0.1"/></joint>
  <joint name="end" type="fixed"><parent link="upper"/><child link="tip"/><origin xyz="1 0 0"/></joint>
  <gazebo reference="tip"><material>Gazebo/Red</material><sensor name="s" type="ray"><ray><scan><horizontal>
    <samples>3</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
    <range><min>0.1</min><max>5</max></range></ray></sensor></gazebo>
  <gazebo><static>true</static></gazebo>
</robot>"""


MOVING = ARM.replace("<gazebo><static>true</static></gazebo>", "")


@pytest.fixture
def arm():
    return parse_model(MOVING, "spawn", [])


def test_links_are_where_their_joints_put_them(arm):
    assert arm.name == "arm"
    assert arm.link("base").pose.position_m == (0.0, 0.0, 0.0)
    np.testing.assert_allclose(arm.link("upper").pose.position_m, (1, 0, 0), atol=1e-12)
    # The elbow turns to the left, so the tip is a metre to the left of it
    np.testing.assert_allclose(arm.link("tip").pose.position_m, (1, 1, 0), atol=1e-12)
    assert arm.link("tip").pose.rpy_rad[2] == pytest.approx(math.pi / 2)


def test_masses_shapes_and_sensors(arm):
    base = arm.link("base")
    assert base.inertial.mass_kg == 2.0
    assert base.inertial.pose.position_m == (0.0, 0.0, 0.1)
    assert base.inertial.moments_kg_m2 == (1.0, 2.0, 2.5, 0.1, 0.0, 0.0)
    assert base.collisions[0].geometry == Box((1.0, 2.0, 3.0))
    assert base.collisions[0].pose.position_m == (0.0, 0.0, 0.5)
    assert (base.visuals[0].geometry, base.visuals[0].rgba) == (Sphere(0.3), (1.0, 0.0, 0.0, 1.0))
    assert arm.link("upper").collisions[0].geometry == Cylinder(0.1, 2.0)
    assert arm.link("tip").inertial.mass_kg < 1e-4  # without <inertial> it weighs next to nothing
    assert [link.name for link, _ in arm.sensors(RaySensor)] == ["tip"]


def test_joints(arm):
    elbow = arm.joint("elbow")
    assert (elbow.kind, elbow.parent, elbow.child, elbow.axis) == (
        "revolute",
        "base",
        "upper",
        (0.0, 1.0, 0.0),
    )
    assert (elbow.lower_rad, elbow.upper_rad, elbow.damping, elbow.friction) == (-1.0, 0.5, 0.2, 0.1)
    assert arm.joint("end").kind == "fixed"
    assert arm.warnings == ()


def test_the_extensions_of_the_model_count():
    assert parse_model(ARM, "spawn", []).static


def test_what_the_writer_writes_is_read_back():
    iris = load_model("model://iris")
    back = parse_model(urdf_of(iris), "spawn", [])
    for link in iris.links:
        np.testing.assert_allclose(back.link(link.name).pose.position_m, link.pose.position_m, atol=1e-9)
        assert back.link(link.name).inertial.mass_kg == pytest.approx(link.inertial.mass_kg)


@pytest.mark.table(
    ("change", "saying"),
    [
        (('xyz="1 0 0" rpy', 'xyz="1 0" rpy'), "<origin> must hold three numbers"),
        (('<parent link="base"/>', '<parent link="tip"/>'), "form a ring"),
        (('<parent link="base"/>', '<parent link="none"/>'), 'names the link "none", which does not exist'),
        (('<mass value="2"/>', '<mass value="heavy"/>'), "<mass> must hold a finite number"),
    ],
)
def test_what_is_wrong_is_one_sentence(change, saying):
    with pytest.raises(SdfError, match=saying):
        parse_model(MOVING.replace(*change), "spawn", [])


def test_sdf_is_no_urdf():
    plugin = '<plugin name="p" filename="x"><robot/></plugin>'
    assert parse_model(
        f'<sdf version="1.6"><model name="m">{plugin}<link name="l"/></model></sdf>', "s"
    ).links


@pytest.mark.table(
    "text",
    [
        "<!-- made by xacro, not <sdf -->" + ARM.split("\n", 1)[1],
        ARM.split("\n", 1)[1].encode("utf-16"),
        b"\xef\xbb\xbf" + ARM.encode(),
        "\n" + ARM,  # TinyXML takes it
    ],
)
def test_a_urdf_is_known_by_its_root(text):
    assert parse_model(text, "spawn", []).name == "arm"


HANGING = """<robot name="r"><link name="world"/>
  <joint name="foot" type="fixed"><parent link="world"/><child link="base"/><origin xyz="1 2 3"/></joint>
  <link name="base"/></robot>"""


def test_the_link_called_world_is_the_world():
    model = parse_model(HANGING, "spawn", [])
    assert [link.name for link in model.links] == ["base"]
    assert model.links[0].pose.position_m == (1.0, 2.0, 3.0)
    assert [(joint.parent, joint.child) for joint in model.joints] == [("world", "base")]


def extended(inside, reference="upper"):
    """Return the arm with more in a <gazebo>."""
    more = f'<gazebo reference="{reference}">{inside}</gazebo></robot>'
    return parse_model(MOVING.replace("</robot>", more), "spawn", [])


def test_what_gazebo_adds_to_a_link_counts():
    assert not extended("<turnGravityOff>true</turnGravityOff>").link("upper").gravity
    assert extended("<turnGravityOff>0</turnGravityOff>").link("upper").gravity
    (touched,) = extended("<mu1>0.25</mu1><mu2>0.25</mu2>").link("upper").collisions
    assert touched.surface.friction == 0.25
    (seen,) = extended("<material>Gazebo/Green</material>", "base").link("base").visuals
    assert seen.rgba == (0.0, 1.0, 0.0, 1.0)


@pytest.mark.table(
    ("inside", "reference", "saying"),
    [
        ("<kp>1e6</kp><kd>1</kd><maxVel>0.1</maxVel>", "upper", ""),
        ("<preserveFixedJoint>true</preserveFixedJoint><stopErp>0.2</stopErp>", "end", ""),
        ("<mu1>0.2</mu1>", "nothing", 'reference="nothing"> is left out'),
        ("<springStiffness>3</springStiffness>", "elbow", "springStiffness"),
        ("<selfCollide>true</selfCollide>", "upper", "self_collide"),
    ],
)
def test_what_gazebo_adds_and_has_no_effect_is_named(inside, reference, saying):
    said = " ".join(extended(inside, reference).warnings)
    assert (saying in said) if saying else not said


def test_a_material_may_have_its_colour_elsewhere():
    green = '<material name="green"><color rgba="0 1 0 1"/></material>'
    text = MOVING.replace('<robot name="arm">', f'<robot name="arm">{green}')
    model = parse_model(
        text.replace('<material name="m"><color rgba="1 0 0 1"/></material>', '<material name="green"/>'),
        "s",
        [],
    )
    assert model.link("base").visuals[0].rgba == (0.0, 1.0, 0.0, 1.0)


def test_a_bound_that_is_not_there_is_zero_and_not_infinite():
    elbow = parse_model(MOVING.replace('lower="-1" ', ""), "spawn", []).joint("elbow")
    assert (elbow.lower_rad, elbow.upper_rad) == (0.0, 0.5)


def test_a_joint_that_follows_another_one_is_said_to_be_free():
    (said,) = parse_model(
        MOVING.replace("<dynamics damping", '<mimic joint="end"/><dynamics damping'), "spawn", []
    ).warnings
    assert said.startswith('spawn:12: The joint "elbow" turns freely')


@pytest.mark.table("namespace", [' xmlns:xacro="http://www.ros.org/wiki/xacro"', ""])
def test_xacro_is_no_urdf_yet(namespace):
    text = MOVING.replace(
        '<robot name="arm">', f'<robot name="arm"{namespace}>\n<xacro:include filename="x"/>'
    )
    with pytest.raises(SdfError, match=r"^spawn:[123]: The file is xacro, not URDF. Convert it first"):
        parse_model(text, "spawn", [])


def test_a_line_is_that_of_the_urdf():
    with pytest.raises(SdfError, match=r"^spawn:4: <mass> must be positive"):
        parse_model(MOVING.replace('<mass value="2"/>', '<mass value="-2"/>'), "spawn", [])


@pytest.mark.table("uri", ["model://robot", "model://robot/arm.urdf"])
def test_a_world_includes_a_urdf_as_gazebo_does(tmp_path, uri):
    home = tmp_path / "robot"
    home.mkdir()
    (home / "arm.urdf").write_text(MOVING)
    (home / "model.config").write_text("<model><name>robot</name><sdf>arm.urdf</sdf></model>")
    place = "<pose>5 0 0 0 0 0</pose>"
    world = tmp_path / "w.world"
    world.write_text(
        f'<sdf version="1.6"><world name="w"><include><uri>{uri}</uri>{place}</include></world></sdf>'
    )
    (model,) = load_world(world, [tmp_path]).models
    assert (model.name, model.pose.position_m) == ("arm", (5.0, 0.0, 0.0))
    assert load_model(home / "arm.urdf").name == "arm"
