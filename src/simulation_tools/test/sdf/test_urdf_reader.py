"""URDF as a model: the same places, masses and joints as URDF's own rules give by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.sdf.elements import Box, Cylinder, RaySensor, Sphere
from simulation_tools.sdf.parser import SdfError, load_model, parse_model
from simulation_tools.sdf.urdf import is_urdf, urdf_of

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


@pytest.mark.parametrize(
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
    assert is_urdf(ARM.encode())
    assert not is_urdf(b'<sdf version="1.6"><model name="m"><plugin name="p"><robot/></plugin></model></sdf>')
