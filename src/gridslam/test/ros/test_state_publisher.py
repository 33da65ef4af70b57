"""What slam_gridslam says of the pose: the state's colours, and the pose with its covariance."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from gridslam_ros.publishing.state_publisher import COLOURS, LEVELS, marker_of, pose_of, status_of
from std_msgs.msg import Header

from gridslam.tracking.monitor import STATES


@pytest.mark.parametrize("state", STATES)
def test_every_state_has_a_colour_of_its_own_and_a_level(state):
    assert marker_of(state, "base_frame").text == state
    assert sum(COLOURS[state] == colour for colour in COLOURS.values()) == 1
    assert state in LEVELS


def test_the_pose_has_the_covariance_of_x_y_and_yaw():
    covariance = np.array([(4.0, 0.5, 0.1), (0.5, 9.0, 0.2), (0.1, 0.2, 0.25)])
    session = SimpleNamespace(
        slam=SimpleNamespace(base_in_map=(1.0, -2.0, math.pi / 2)), covariance=covariance
    )
    message = pose_of(session, Header(frame_id="map"))
    pose = message.pose.pose
    assert (message.header.frame_id, pose.position.x, pose.position.y) == ("map", 1.0, -2.0)
    assert pose.orientation.z == pytest.approx(math.sqrt(0.5))
    told = np.reshape(message.pose.covariance, (6, 6))
    np.testing.assert_array_equal(told[np.ix_((0, 1, 5), (0, 1, 5))], covariance)
    assert not told[2:5].any()


def test_diagnostics_have_the_number_of_parts_that_odometry_alone_joins(monkeypatch):
    monkeypatch.setattr(rospy, "get_name", lambda: "/slam_gridslam")
    last = SimpleNamespace(
        agreement=SimpleNamespace(compared_share=0.9), spread_m=0.1, neff_share=0.5, correction=1.0
    )
    tracking = SimpleNamespace(
        last=last,
        state="tracking",
        reason="",
        share_of=lambda _: 0.9,
        smoothed_share=0.9,
        contradictions=0,
        self_check=SimpleNamespace(spread_m=0.1),
        scans_since_tracking=0,
        travelled_since_tracking_m=0.0,
    )
    session = SimpleNamespace(
        tracking=tracking,
        told_state="tracking",
        search="",
        loose_parts_s=[1.0, 2.0],
        sight=SimpleNamespace(age_s=7.0),
    )
    values = {pair.key: pair.value for pair in status_of(session).values}
    assert values["parts of the map that odometry alone joins (1: it is one)"] == "3"
    assert values["age of the newest scan that saw something (s)"] == "7"
