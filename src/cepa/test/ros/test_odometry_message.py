"""The frame in which odometry tells its velocity."""

import math

import numpy as np
import pytest

conversions = pytest.importorskip("cepa_ros.conversions", reason="the workspace is not built, or not sourced")

from nav_msgs.msg import Odometry  # noqa: E402

from cepa import MountError  # noqa: E402
from cepa.steering.mount import Mount  # noqa: E402

MOUNTS = {
    "base_link_frd": Mount.of_pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
    "camera": Mount.of_pose((0.2, 0.0, 0.0), (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))),
}


def mount_of(frame):
    if frame not in MOUNTS:
        raise MountError(f'TF knows no transform from "base_frame" to "{frame}".')
    return MOUNTS[frame]


def state_of(child, parent="odom"):
    message = Odometry(child_frame_id=child)
    message.header.frame_id = parent
    twist = message.twist.twist.linear
    twist.x, twist.y, twist.z = 1.0, 2.0, 3.0
    return conversions.own_state_of(message, "base_frame", mount_of)


@pytest.mark.parametrize(
    ("child", "velocity", "is_told_in_odometry"),
    [
        ("base_frame", (1.0, 2.0, 3.0), False),
        ("/base_frame", (1.0, 2.0, 3.0), False),
        ("", (1.0, 2.0, 3.0), False),
        ("odom", (1.0, 2.0, 3.0), True),
        ("base_link_frd", (1.0, -2.0, -3.0), False),  # half a turn about x
        ("camera", (-2.0, 1.0, 3.0), False),  # its x axis is the body's y axis
    ],
)
def test_the_velocity_is_along_the_axes_of_child_frame_id(child, velocity, is_told_in_odometry):
    state, complaint = state_of(child)
    np.testing.assert_allclose(state.velocity_m_s, velocity, atol=1e-12)
    assert state.is_told_in_odometry is is_told_in_odometry
    assert not complaint


def test_a_frame_that_tf_does_not_know_is_told_and_counts_as_the_bodys():
    state, complaint = state_of("base_link")
    assert state.velocity_m_s == (1.0, 2.0, 3.0)
    assert '"base_link"' in complaint
    assert "child_frame_id" in complaint
