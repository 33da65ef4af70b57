"""URDF made of SDF: the same tree, the same places at any angles, and urdfdom accepts it."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_model, parse_model
from simulation_tools.sdf.urdf import urdf_of
from simulation_tools.transforms.joint_frames import JointFrames
from simulation_tools.vehicle.uav import load_uav

MODELS = Path(__file__).resolve().parents[2] / "models"
BALL = "<geometry><sphere><radius>.1</radius></sphere></geometry>"
DOOR = parse_model(
    '<sdf version="1.6"><model name="door"><link name="post"><pose>0 0 1 0 0 0.2</pose></link>'
    f'<link name="leaf"><pose>.5 0 1 .1 .2 .3</pose><visual name="v">{BALL}</visual>'
    '<sensor name="eye" type="imu"><pose>0 .1 0 0 0 1</pose></sensor></link>'
    '<joint name="hinge" type="revolute"><pose>-.5 .02 0 .3 0 0</pose>'
    "<parent>post</parent><child>leaf</child><axis><xyz>0 1 1</xyz>"
    "<limit><lower>-1</lower><upper>2</upper></limit></axis></joint>"
    '<link name="bell"/><joint name="fixture" type="fixed"><parent>leaf</parent><child>bell</child></joint>'
    "</model></sdf>",
    "door.sdf",
    [],
)


def matrix(origin):
    """The 4 x 4 matrix of an <origin>, by the definition of URDF."""
    x, y, z = map(float, origin.get("xyz", "0 0 0").split()) if origin is not None else (0, 0, 0)
    r, p, w = map(float, origin.get("rpy", "0 0 0").split()) if origin is not None else (0, 0, 0)
    return translation(x, y, z) @ turn((0, 0, 1), w) @ turn((0, 1, 0), p) @ turn((1, 0, 0), r)


def translation(x, y, z):
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def turn(axis, angle):
    """Rodrigues' formula."""
    k = np.cross(np.eye(3), axis)  # k @ v = axis x v
    result = np.eye(4)
    result[:3, :3] += math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    return result


def places(urdf, angles):
    """The 4 x 4 matrix of every link in the root, joints turned by angles (by name)."""
    robot = etree.fromstring(urdf)
    joints = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}

    def place(link):
        if link not in joints:
            return np.eye(4)
        joint = joints[link]
        own = matrix(joint.find("origin"))
        if joint.get("type") != "fixed":
            axis = tuple(map(float, joint.find("axis").get("xyz").split()))
            own = own @ turn(axis, angles.get(joint.get("name"), 0.0))
        return place(joint.find("parent").get("link")) @ own

    return {link.get("name"): place(link.get("name")) for link in robot.iter("link")}


def tf_places(model, angles):
    """The same from the edges that tf_publisher sends."""
    frames = JointFrames(model, "base_frame", moving=angles)
    found = {"base_frame": Pose()}
    edges = [*frames.static_edges(), *frames.on_joint_states(1, angles)]
    while edges:
        for edge in [edge for edge in edges if edge.parent in found]:
            found[edge.child] = found[edge.parent] @ edge.pose
            edges.remove(edge)
    return found


@pytest.mark.table("angle", [0.0, 0.7, -1.0])
@pytest.mark.table("model", [DOOR, load_uav("iris", "ust", [MODELS]).model])
def test_every_link_is_where_tf_says_at_any_angles(model, angle):
    angles = {joint.name: angle for joint in model.joints if joint.kind == "revolute"}
    expected = tf_places(model, angles)
    found = places(urdf_of(model), angles)
    assert {link.name for link in model.links} < set(found)
    for name, place in found.items():
        if name not in ("hinge",):  # between the joint and the link, of URDF's own
            np.testing.assert_allclose(place[:3, 3], expected[name].position_m, atol=1e-9)
            np.testing.assert_allclose(place[:3, :3], expected[name].rotation, atol=1e-9)


def test_a_prefix_goes_before_every_name_but_the_base_frames():
    names = {link.get("name") for link in etree.fromstring(urdf_of(DOOR, "uav1/base", "uav1/")).iter("link")}
    assert names == {"uav1/base", "uav1/post", "uav1/leaf", "uav1/leaf/eye", "uav1/hinge", "uav1/bell"}


def test_shapes_colours_limits_and_masses_come_along():
    model = parse_model(
        '<sdf version="1.6"><model name="m"><link name="a"><inertial><mass>2</mass></inertial>'
        '<visual name="floor"><geometry><plane><normal>1 0 0</normal><size>3 4</size></plane></geometry>'
        "<material><diffuse>.1 .2 .3 1</diffuse></material></visual>"
        '<collision name="can"><geometry><cylinder><radius>.2</radius><length>.6</length></cylinder>'
        '</geometry></collision></link><link name="b"/><joint name="free" type="continuous">'
        "<parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>",
        "m.sdf",
        [],
    )
    robot = etree.fromstring(urdf_of(model))
    assert robot.find("link[@name='a']/inertial/mass").get("value") == "2.0"
    visual = robot.find("link[@name='a']/visual")
    assert visual.find("material/color").get("rgba") == "0.1 0.2 0.3 1.0"
    assert visual.find("geometry/box").get("size") == "3.0 4.0 0.002"
    # Its upper side is the plane, which faces along x: the box lies behind it and is turned over to x.
    place = matrix(visual.find("origin"))
    np.testing.assert_allclose(place[:3, 3], (-0.001, 0, 0), atol=1e-12)
    np.testing.assert_allclose(place[:3, 2], (1, 0, 0), atol=1e-12)
    can = robot.find("link[@name='a']/collision/geometry/cylinder")
    assert (can.get("radius"), can.get("length")) == ("0.2", "0.6")
    assert robot.find("joint[@name='free']").get("type") == "continuous"


@pytest.mark.skipif(shutil.which("check_urdf") is None, reason="liburdfdom-tools is not installed")
@pytest.mark.parametrize("name", ["iris", "reference_quad", "small_quad", "lidar_puck", "ground_plane"])
def test_urdfdom_accepts_it(name, tmp_path):
    file = tmp_path / "model.urdf"
    file.write_text(urdf_of(load_model(f"model://{name}", [MODELS])))
    answer = subprocess.run(
        ["check_urdf", str(file)], capture_output=True, text=True, check=False, timeout=30
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "root Link: base_frame" in answer.stdout
