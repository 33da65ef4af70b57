"""MAVROS's plugins: what external estimates and ranges become on their way, and what comes back.

Expected values are MAVROS 1.21's: its source says frames, units and covariances.
"""

from __future__ import annotations

import math

import pytest
from fake_uas import HALF_ROOT, make_uas, xyz, xyzw
from geometry_msgs.msg import (
    PoseStamped,
    PoseWithCovarianceStamped,
    TwistStamped,
    TwistWithCovarianceStamped,
    Vector3Stamped,
)
from nav_msgs.msg import Odometry
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import Range

from simulation_tools_ros.mavros.plugins.distance_sensor import DistanceSensorPlugin
from simulation_tools_ros.mavros.plugins.vision.odometry import OdometryPlugin
from simulation_tools_ros.mavros.plugins.vision.vision_pose import VisionPosePlugin
from simulation_tools_ros.mavros.plugins.vision.vision_speed import VisionSpeedPlugin

pytestmark = pytest.mark.ros

DIAGONAL = [float(1 + i // 7) if i % 7 == 0 else 0.0 for i in range(36)]  # 1 to 6
DIAGONAL_OF_TRIANGLE = (0, 6, 11, 15, 18, 20)


def fill(pose, position=(1.0, 2.0, 3.0), orientation=(0.0, 0.0, HALF_ROOT, HALF_ROOT)):
    """Facing north by default."""
    pose.position.x, pose.position.y, pose.position.z = position
    q = pose.orientation
    q.x, q.y, q.z, q.w = orientation


def pose_cov(second=5, **pose):
    message = PoseWithCovarianceStamped()
    message.header.stamp.secs = second
    fill(message.pose.pose, **pose)
    message.pose.covariance = DIAGONAL
    return message


@pytest.fixture
def refusals(monkeypatch):
    said = []
    monkeypatch.setattr("rospy.logwarn", said.append)
    return said


def test_a_pose_goes_out_in_ned_with_its_covariance(uas):
    VisionPosePlugin(uas)
    uas.callbacks["vision_pose/pose_cov"](pose_cov())
    (sent,) = uas.client.sent
    assert (sent.usec, sent.x, sent.y, sent.z) == (5_000_000, 2.0, 1.0, -3.0)
    assert (sent.roll, sent.pitch, sent.yaw) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    diagonal = [sent.covariance[i] for i in DIAGONAL_OF_TRIANGLE]
    assert diagonal == [2.0, 1.0, 3.0, 5.0, 4.0, 6.0]
    assert sent.reset_counter == 0


def test_a_second_pose_of_one_stamp_is_dropped(uas):
    VisionPosePlugin(uas)
    pose = PoseStamped()
    pose.header.stamp.secs = 5
    fill(pose.pose, orientation=(0.0, 0.0, 0.0, 0.0))  # a message's default: MAVROS takes it for east
    uas.callbacks["vision_pose/pose"](pose)
    uas.callbacks["vision_pose/pose_cov"](pose_cov())
    (sent,) = uas.client.sent
    assert sent.yaw == pytest.approx(math.pi / 2)
    assert list(sent.covariance) == [0.0] * 21


def test_nan_goes_to_the_flight_controller_and_too_great_a_number_does_not(uas, refusals):
    VisionPosePlugin(uas)
    uas.callbacks["vision_pose/pose_cov"](pose_cov(position=(math.nan, 2.0, 3.0)))
    (sent,) = uas.client.sent
    assert math.isnan(sent.y)
    for second in range(6, 20):
        uas.callbacks["vision_pose/pose_cov"](pose_cov(second, position=(1e300, 2.0, 3.0)))
    assert len(uas.client.sent) == 1
    assert refusals == ["An estimate on vision_pose/pose_cov is refused: it holds a number beyond 3.4e38."]


@pytest.mark.table(
    ("parameters", "topic", "message"),
    [
        ({}, "speed_twist_cov", TwistWithCovarianceStamped()),
        ({"~vision_speed/twist_cov": False}, "speed_twist", TwistStamped()),
        ({"~vision_speed/listen_twist": False}, "speed_vector", Vector3Stamped()),
    ],
)
def test_one_topic_takes_speeds_by_the_parameters(monkeypatch, parameters, topic, message):
    uas = make_uas(monkeypatch, parameters)
    VisionSpeedPlugin(uas)
    assert list(uas.callbacks) == [f"vision_speed/{topic}"]
    vector = message.vector if topic == "speed_vector" else message.twist
    if topic == "speed_twist_cov":
        vector.covariance = DIAGONAL
        vector = vector.twist
    vector = getattr(vector, "linear", vector)
    vector.x, vector.y, vector.z = 1.0, 2.0, 3.0
    message.header.stamp.secs = 7
    uas.callbacks[f"vision_speed/{topic}"](message)
    (sent,) = uas.client.sent
    assert (sent.usec, sent.x, sent.y, sent.z) == (7_000_000, 2.0, 1.0, -3.0)
    expected = [2.0, 1.0, 3.0] if topic == "speed_twist_cov" else [0.0] * 3
    assert list(sent.covariance[0:9:4]) == expected


def odometry(frame="odom", child="base_link"):
    message = Odometry(child_frame_id=child)
    message.header.frame_id, message.header.stamp.secs = frame, 8
    fill(message.pose.pose)
    message.pose.covariance = message.twist.covariance = DIAGONAL
    twist = message.twist.twist
    twist.linear.x, twist.linear.y, twist.linear.z = 1.0, 2.0, 3.0
    twist.angular.x, twist.angular.y, twist.angular.z = 0.1, 0.2, 0.3
    return message


def test_odometry_goes_out_in_local_and_body_frd_and_comes_back_as_it_was(uas):
    OdometryPlugin(uas)
    uas.callbacks["odometry/out"](odometry())
    (sent,) = uas.client.sent
    assert (sent.time_usec, sent.frame_id, sent.child_frame_id) == (8_000_000, 20, 12)
    assert sent.estimator_type == common.MAV_ESTIMATOR_TYPE_VISION
    assert (sent.x, sent.y, sent.z, sent.vx, sent.vy, sent.vz) == (2.0, 1.0, -3.0, 1.0, -2.0, -3.0)
    assert sent.q == pytest.approx((1.0, 0.0, 0.0, 0.0))
    assert (sent.rollspeed, sent.pitchspeed, sent.yawspeed) == (0.1, -0.2, -0.3)
    assert [sent.pose_covariance[i] for i in DIAGONAL_OF_TRIANGLE] == [2.0, 1.0, 3.0, 5.0, 4.0, 6.0]
    assert [sent.velocity_covariance[i] for i in DIAGONAL_OF_TRIANGLE] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    uas.client.hear(sent)
    back = uas.topics["odometry/in"].last
    assert (back.header.frame_id, back.child_frame_id, back.header.stamp.secs) == ("map", "base_link", 8)
    assert xyzw(back.pose.pose.orientation) == pytest.approx((0.0, 0.0, HALF_ROOT, HALF_ROOT))
    assert xyz(back.pose.pose.position) == xyz(back.twist.twist.linear) == (1.0, 2.0, 3.0)
    assert back.pose.covariance == back.twist.covariance == DIAGONAL


def test_odometry_of_other_frames_is_refused_unless_the_parameters_say_so(monkeypatch, uas, refusals):
    OdometryPlugin(uas)
    uas.callbacks["odometry/out"](odometry(child="base_frame"))
    assert not uas.client.sent
    assert "'base_frame' in 'odom'" in refusals[0]
    assert "odom_child_id_des" in refusals[0]
    uas = make_uas(monkeypatch, {"~odometry/fcu/odom_child_id_des": "base_frame"})
    OdometryPlugin(uas)
    uas.callbacks["odometry/out"](odometry(child="base_frame"))
    assert uas.client.sent


def distance(sensor_id=0, orientation=25, kind=0):
    return common.MAVLink_distance_sensor_message(9000, 10, 1000, 234, kind, sensor_id, orientation, 1)


def test_ranges_of_the_flight_controller_have_mavross_topic_of_their_id(uas, monkeypatch):
    errors = []
    monkeypatch.setattr("rospy.logerr_once", errors.append)
    DistanceSensorPlugin(uas)
    uas.client.hear(distance())
    message = uas.topics["distance_sensor/hrlv_ez4_pub"].last
    assert (message.header.frame_id, message.header.stamp.secs) == ("hrlv_ez4_sonar", 9)
    assert (message.min_range, message.max_range, message.range) == pytest.approx((0.1, 10.0, 2.34))
    assert message.radiation_type == Range.INFRARED
    uas.client.hear(distance(sensor_id=7))
    uas.client.hear(distance(orientation=0))
    uas.client.hear(distance(kind=200))
    assert len(uas.topics["distance_sensor/hrlv_ez4_pub"].messages) == 1
    assert ["id 7" in errors[0], "another way" in errors[1]] == [True, True]


def test_ranges_to_the_flight_controller_are_in_cm_with_a_variance(uas, refusals):
    DistanceSensorPlugin(uas)
    take = uas.callbacks["distance_sensor/laser_1_sub"]
    for metres in (2.0, 4.0, math.inf, math.nan):
        message = Range(radiation_type=Range.INFRARED, min_range=0.1, max_range=40.0, range=metres)
        message.header.stamp.secs = 9
        take(message)
    first, second, far = uas.client.sent
    assert (first.time_boot_ms, first.id, first.orientation, first.type) == (9000, 3, 25, 0)
    assert (first.min_distance, first.max_distance, first.current_distance) == (10, 4000, 200)
    assert (first.covariance, second.covariance) == (0, 100)  # 1 m2
    assert far.current_distance == 65535
    assert refusals == ["A range on distance_sensor/laser_1_sub is refused: its range is NaN."]


def test_a_sensor_without_its_parameters_is_left_out_with_a_sentence(monkeypatch):
    errors = []
    monkeypatch.setattr("rospy.logerr", errors.append)
    sensors = {
        "base_frame_id": "base_link",
        "no_id": {"frame_id": "x", "field_of_view": 0.1},
        "bent": {"id": 1, "subscriber": True, "orientation": "DOWN"},
        "down": {"id": 2, "frame_id": "down_link", "field_of_view": 0.1, "orientation": "PITCH_270"},
    }
    uas = make_uas(monkeypatch, {"~distance_sensor": sensors})
    DistanceSensorPlugin(uas)
    assert list(uas.topics) == ["distance_sensor/down"]
    assert ["no_id has no id" in errors[0], "'DOWN' is not an orientation" in errors[1]] == [True, True]
