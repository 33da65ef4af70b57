"""MAVROS's plugins: what they publish of attitude, accelerations and the local position.

Expected values are MAVROS 1.21's: its source says frames, units and covariances.
"""

from __future__ import annotations

import math

import pytest
from fake_uas import HALF_ROOT, attitude, local_position, make_uas, xyz, xyzw
from pymavlink.dialects.v20 import common

from simulation_tools_ros.mavros.plugins.imu import ImuPlugin
from simulation_tools_ros.mavros.plugins.local_position import LocalPositionPlugin

pytestmark = pytest.mark.ros


def highres_imu(fields=7167, us=5_000_000):
    return common.MAVLink_highres_imu_message(
        us, 1.0, 2.0, -9.8, 0.1, 0.2, 0.3, 0.2, 0.1, 0.4, 95000.0, 12.0, 500.0, 20.0, fields
    )


def test_imu_data_is_flu_in_enu_with_mavros_covariances(uas):
    ImuPlugin(uas)
    uas.client.hear(attitude())
    data = uas.topics["imu/data"].last
    assert data.linear_acceleration_covariance[0] == -1.0  # no HIGHRES_IMU yet
    uas.client.hear(highres_imu())
    uas.client.hear(attitude(ms=5020))
    data = uas.topics["imu/data"].last
    assert (data.header.frame_id, data.header.stamp.to_sec()) == ("base_link", 5.02)
    assert xyzw(data.orientation) == pytest.approx((0.0, 0.0, HALF_ROOT, HALF_ROOT))  # north is left of east
    assert xyz(data.angular_velocity) == (0.1, -0.2, -0.3)
    assert xyz(data.linear_acceleration) == (1.0, -2.0, 9.8)
    assert data.orientation_covariance == [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]
    assert data.angular_velocity_covariance[0:9:4] == pytest.approx([math.radians(0.02) ** 2] * 3)
    assert data.linear_acceleration_covariance[0:9:4] == pytest.approx([0.0003**2] * 3)


def test_what_is_no_number_in_mavross_own_configuration_is_the_default(monkeypatch):
    """Its px4_config.yaml has this text, which a real MAVROS passes over as well."""
    uas = make_uas(monkeypatch, {"~imu/angular_velocity_stdev": "0.0003490659 // 0.02 degrees"})
    warned = []
    monkeypatch.setattr("rospy.logwarn", warned.append)
    ImuPlugin(uas)
    uas.client.hear(attitude())
    covariance = uas.topics["imu/data"].last.angular_velocity_covariance
    assert covariance[0:9:4] == pytest.approx([math.radians(0.02) ** 2] * 3)
    assert ["angular_velocity_stdev" in text for text in warned] == [True]


def test_imu_raw_mag_and_pressure(uas):
    ImuPlugin(uas)
    uas.client.hear(highres_imu())
    raw, mag = uas.topics["imu/data_raw"].last, uas.topics["imu/mag"].last
    assert (xyz(raw.linear_acceleration), xyz(raw.angular_velocity)) == ((1.0, -2.0, 9.8), (0.1, -0.2, -0.3))
    assert raw.orientation_covariance == [-1.0, 0, 0, 0, 0, 0, 0, 0, 0]
    assert xyz(mag.magnetic_field) == pytest.approx((0.2e-4, -0.1e-4, -0.4e-4))  # tesla
    assert mag.magnetic_field_covariance[0] == -1.0
    assert uas.topics["imu/static_pressure"].last.fluid_pressure == 95000.0  # Pa, as PX4 sends it
    assert uas.topics["imu/temperature_imu"].last.temperature == 20.0
    assert not uas.topics["imu/diff_pressure"].messages  # its bit is not set
    for topic in uas.topics.values():
        assert all(message.header.frame_id == "base_link" for message in topic.messages)


def test_only_what_is_new_is_published(uas):
    ImuPlugin(uas)
    uas.client.hear(highres_imu(fields=1 << 10))
    assert [name for name, topic in uas.topics.items() if topic.messages] == ["imu/diff_pressure"]


def test_nobody_who_listens_means_no_message(uas):
    ImuPlugin(uas)
    for topic in uas.topics.values():
        topic.wanted = False
    uas.client.hear(attitude())
    uas.client.hear(highres_imu())
    assert not any(topic.messages for topic in uas.topics.values())


def test_local_positions_frames_are_mavros_own(uas):
    """Facing north: forward is north. velocity_local is ENU, under the body's frame_id."""
    LocalPositionPlugin(uas)
    uas.client.hear(local_position())
    assert not uas.topics["local_position/pose"].messages  # the attitude is not known yet
    uas.client.hear(attitude())
    uas.client.hear(local_position())
    pose = uas.topics["local_position/pose"].last
    assert (pose.header.frame_id, xyz(pose.pose.position)) == ("map", (2.0, 1.0, 3.0))
    local = uas.topics["local_position/velocity_local"].last
    assert (local.header.frame_id, xyz(local.twist.linear)) == ("base_link", (0.5, 0.4, 0.6))
    assert xyz(local.twist.angular) == pytest.approx((0.2, 0.1, -0.3))  # ENU
    body = uas.topics["local_position/velocity_body"].last
    assert (body.header.frame_id, xyz(body.twist.linear)) == ("base_link", pytest.approx((0.4, -0.5, 0.6)))
    assert xyz(body.twist.angular) == (0.1, -0.2, -0.3)  # FLU
    odometry = uas.topics["local_position/odom"].last
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "base_link")
    assert odometry.pose.pose == pose.pose
    assert odometry.twist.twist == body.twist
    assert not uas.topics["local_position/pose_cov"].messages


def test_covariances_come_of_local_position_ned_cov_alone(uas):
    LocalPositionPlugin(uas)
    uas.client.hear(attitude())
    indices = iter(range(45))
    triangle = [[next(indices) for _ in range(row, 9)] for row in range(9)]
    variances = [float(row[0]) for row in triangle]  # the diagonal: x y z vx vy vz ax ay az
    uas.client.hear(
        common.MAVLink_local_position_ned_cov_message(
            6_000_000, 3, 1.0, 2.0, -3.0, 0.4, 0.5, -0.6, 0.7, 0.8, -0.9, list(map(float, range(45)))
        )
    )
    pose, accel = uas.topics["local_position/pose_cov"].last, uas.topics["local_position/accel"].last
    twist = uas.topics["local_position/velocity_body_cov"].last
    assert list(pose.pose.covariance[0:15:7]) == variances[:3]
    assert list(twist.twist.covariance[0:15:7]) == variances[3:6]
    assert list(accel.accel.covariance[0:15:7]) == variances[6:]
    assert (pose.header.frame_id, twist.header.frame_id) == ("map", "base_link")
    assert (accel.header.frame_id, xyz(accel.accel.accel.linear)) == ("map", (0.8, 0.7, 0.9))
    uas.client.hear(local_position(7_000_000))
    stamps = [message.header.stamp.to_sec() for message in uas.topics["local_position/odom"].messages]
    assert stamps == [6.0]  # odom is that with covariances from now on
