"""The frame tree of a model, and a payload on a carrier."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.frames import attach, model_frames
from simulation_tools.sdf.parser import SdfError, parse_model

ARM = parse_model(
    '<sdf version="1.6"><model name="arm"><link name="hand"><pose>2 0 0 0 0 0</pose>'
    '<sensor name="imu" type="imu"><pose>0 0 .1 0 0 0</pose></sensor></link>'
    '<link name="base"/><link name="upper"><pose>1 0 0 0 0 0</pose></link><link name="loose"/>'
    '<joint name="wrist" type="fixed"><parent>upper</parent><child>hand</child></joint>'
    '<joint name="elbow" type="revolute"><pose>-.5 0 0 0 0 0</pose><parent>base</parent><child>upper</child>'
    "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>",
    "arm.sdf",
    [],
)
LAMP = parse_model(
    '<sdf version="1.6"><model name="lamp"><pose>9 9 9 0 0 0</pose><link name="foot">'
    "<inertial><mass>.5</mass></inertial></link>"
    '<link name="bulb"><pose>0 0 .3 0 0 0</pose></link>'
    '<joint name="stem" type="fixed"><parent>foot</parent><child>bulb</child></joint></model></sdf>',
    "lamp.sdf",
    [],
)


def test_every_link_sensor_and_joint_is_a_frame_with_one_parent():
    frames = model_frames(ARM)
    parents = {frame.child: frame.parent for frame in frames}
    assert parents == {
        "upper": "base",
        "hand": "upper",
        "loose": "base",
        "hand/imu": "hand",
        "wrist": "hand",
        "elbow": "upper",
    }
    assert len(parents) == len(frames)


def test_parents_come_before_their_children():
    known = {"base"}
    for frame in model_frames(ARM):
        assert frame.parent in known
        known.add(frame.child)


def test_poses_along_the_tree_add_up_to_the_pose_in_the_model():
    place = {"base": Pose()}
    for frame in model_frames(ARM):
        place[frame.child] = place[frame.parent] @ frame.pose
    np.testing.assert_allclose(place["hand"].position_m, (2, 0, 0), atol=1e-12)
    np.testing.assert_allclose(place["hand/imu"].position_m, (2, 0, 0.1), atol=1e-12)
    np.testing.assert_allclose(place["elbow"].position_m, (0.5, 0, 0), atol=1e-12)


def test_a_revolute_joint_turns_its_child_about_the_joint_not_the_link():
    frame = next(frame for frame in model_frames(ARM) if frame.child == "upper")
    # The elbow sits half a metre behind the upper arm: a quarter turn moves the arm to its left.
    turned = frame.at_angle(math.pi / 2)
    np.testing.assert_allclose(turned.position_m, (0.5, 0.5, 0), atol=1e-12)
    assert turned.yaw_rad == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(frame.at_angle(0.0).position_m, frame.pose.position_m, atol=1e-12)


def test_a_payload_sits_where_it_is_put_whatever_its_own_pose():
    carried = attach(ARM, LAMP, "hand", Pose.from_xyz_rpy(0, 0, 1, 0, 0, math.pi))
    np.testing.assert_allclose(carried.link("foot").pose.position_m, (2, 0, 1), atol=1e-12)
    np.testing.assert_allclose(carried.link("bulb").pose.position_m, (2, 0, 1.3), atol=1e-12)
    joint = carried.joint("foot_joint")
    assert (joint.kind, joint.parent, joint.child) == ("fixed", "hand", "foot")
    assert sum(link.inertial.mass_kg for link in carried.links) == pytest.approx(4 * 1.0 + 0.5 + 1.0)


def test_a_payload_needs_a_link_that_exists_and_names_of_its_own():
    with pytest.raises(SdfError, match='has no link "roof"'):
        attach(ARM, LAMP, "roof")
    with pytest.raises(SdfError, match='"foot" exists already'):
        attach(attach(ARM, LAMP, "hand"), LAMP, "base")
