"""What slam_gridslam says of the pose: the state's colours, and the pose with its covariance."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from gridslam_ros.publishing.state_publisher import COLOURS, LEVELS, marker_of, pose_of
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
