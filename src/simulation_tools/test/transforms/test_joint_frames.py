"""The frames of an SDF model, standing and turning."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import parse_model
from simulation_tools.transforms.joint_frames import JointFrames

ARM = """
<sdf version="1.6"><model name="arm">
  <link name="base"><pose>0 0 0.5 0 0 0</pose></link>
  <link name="finger"><pose>1 0 0.5 0 0 1.5707963267948966</pose>
    <sensor name="eye" type="imu"><pose>0.2 0 0 0 0 0</pose></sensor>
  </link>
  <joint name="hinge" type="revolute">
    <parent>base</parent><child>finger</child><axis><xyz>0 0 1</xyz></axis>
  </joint>
</model></sdf>
"""

MODEL = parse_model(ARM, "arm", ())


def test_static_edges_form_a_tree_that_ends_where_the_model_says():
    edges = JointFrames(MODEL, "base_frame", "uav1/").static_edges()
    parents = {edge.child: edge for edge in edges}
    assert len(parents) == len(edges), "a frame has two parents"
    pose, frame = Pose.identity(), "uav1/finger/eye"
    while frame != "base_frame":
        pose, frame = parents[frame].pose @ pose, parents[frame].parent
    # The finger stands at (1, 0, 0.5), turned by 90 degrees: its eye, 0.2 m ahead, is to the left.
    np.testing.assert_allclose(pose.position_m, (1.0, 0.2, 0.5), atol=1e-12)
    assert pose.yaw_rad == pytest.approx(math.pi / 2)


def pose_of(edges, frame):
    """Pose of a frame in base_frame."""
    parents = {edge.child: edge for edge in edges}
    pose = Pose.identity()
    while frame != "base_frame":
        pose, frame = parents[frame].pose @ pose, parents[frame].parent
    return pose


@pytest.mark.table("name", ["hinge", "arm::hinge"])
def test_a_turning_joint_is_no_static_frame_and_carries_its_children(name):
    frames = JointFrames(MODEL, "base_frame")
    assert "finger" in {edge.child for edge in frames.static_edges()}
    (edge,) = frames.on_joint_states(5, {name: math.pi / 2, "other::hinge": 1.0})
    assert (edge.stamp_ns, edge.parent, edge.child) == (5, "base", "finger")
    static = frames.static_edges()
    assert "finger" not in {edge.child for edge in static}
    # Turned by another 90 degrees about its own place, the finger points backwards: its eye is at x = 0.8.
    eye = pose_of([*static, edge], "finger/eye")
    np.testing.assert_allclose(eye.position_m, (0.8, 0.0, 0.5), atol=1e-12)
    assert abs(eye.yaw_rad) == pytest.approx(math.pi)


def test_a_joint_whose_states_are_sure_to_come_never_stands():
    frames = JointFrames(MODEL, "base_frame", moving=("hinge", "no_such_joint"))
    assert frames.moving == {"hinge"}
    assert "finger" not in {edge.child for edge in frames.static_edges()}


def test_a_stamp_is_answered_once_and_a_clock_that_jumps_back_is_followed():
    frames = JointFrames(MODEL, "base_frame", prefix="a/", name="left_arm")
    assert frames.on_joint_states(5, {"arm::hinge": 1.0}) == []  # of another one
    (edge,) = frames.on_joint_states(5, {"left_arm::hinge": 1.0})
    assert (edge.parent, edge.child) == ("a/base", "a/finger")
    assert frames.on_joint_states(5, {"left_arm::hinge": 2.0}) == []
    assert len(frames.on_joint_states(1, {"left_arm::hinge": 2.0})) == 1
