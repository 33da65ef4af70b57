"""MAVROS's plugins: what setpoints and commands become on their way to the flight controller.

Expected values are MAVROS 1.21's: its source says frames, units and covariances.
"""

from __future__ import annotations

import math

import pytest
from fake_uas import HALF_ROOT, global_position, local_position, make_uas, request, xyz, xyzw
from geographic_msgs.msg import GeoPoseStamped
from geometry_msgs.msg import PoseStamped, TwistStamped, Vector3Stamped
from mavros_msgs.msg import AttitudeTarget, GlobalPositionTarget, Thrust
from pymavlink.dialects.v20 import common

from simulation_tools_ros.mavros.plugins.command import CommandPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_accel import SetpointAccelPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_attitude import SetpointAttitudePlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_position import SetpointPositionPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_raw import SetpointRawPlugin

pytestmark = pytest.mark.ros


def thrust(value):
    return Thrust(thrust=value)


def test_rates_and_thrust_make_one_setpoint_each(uas):
    """MAVROS turns the rates as a vector of ENU: x becomes PX4's pitch rate, y its roll rate."""
    SetpointAttitudePlugin(uas)
    message = TwistStamped()
    message.header.stamp.secs = 3
    message.twist.angular.x, message.twist.angular.y, message.twist.angular.z = 0.1, 0.2, 0.3
    uas.callbacks["setpoint_attitude/thrust"](thrust(0.5))
    assert not uas.client.sent
    uas.callbacks["setpoint_attitude/cmd_vel"](message)
    (sent,) = uas.client.sent
    assert (sent.body_roll_rate, sent.body_pitch_rate, sent.body_yaw_rate) == (0.2, 0.1, -0.3)
    assert (sent.type_mask, sent.thrust, sent.time_boot_ms) == (128, 0.5, 3000)
    uas.callbacks["setpoint_attitude/cmd_vel"](message)
    assert len(uas.client.sent) == 1  # a thrust is used once
    assert "setpoint_attitude/attitude" not in uas.callbacks


def test_an_attitude_by_quaternion(monkeypatch):
    uas = make_uas(monkeypatch, {"~setpoint_attitude/use_quaternion": True})
    SetpointAttitudePlugin(uas)
    pose = PoseStamped()
    pose.pose.orientation.w = 1.0  # east
    uas.callbacks["setpoint_attitude/attitude"](pose)
    uas.callbacks["setpoint_attitude/thrust"](thrust(0.6))
    (sent,) = uas.client.sent
    assert sent.q == pytest.approx((HALF_ROOT, 0, 0, HALF_ROOT))
    assert (sent.type_mask, sent.thrust, sent.time_boot_ms) == (7, pytest.approx(0.6), 77000)  # stamped now
    pose.pose.orientation.w = 0.0  # zeros: no rotation
    uas.callbacks["setpoint_attitude/attitude"](pose)
    uas.callbacks["setpoint_attitude/thrust"](thrust(0.6))
    assert uas.client.sent[-1].q == pytest.approx(sent.q)


@pytest.mark.parametrize("bad", [1.01, -0.01, math.nan, math.inf])
def test_a_thrust_that_is_none_is_refused(uas, bad):
    SetpointAttitudePlugin(uas)
    uas.callbacks["setpoint_attitude/cmd_vel"](TwistStamped())
    uas.callbacks["setpoint_attitude/thrust"](thrust(bad))
    assert not uas.client.sent


def test_reversed_thrust(monkeypatch):
    uas = make_uas(monkeypatch, {"~setpoint_attitude/reverse_thrust": True})
    SetpointAttitudePlugin(uas)
    uas.callbacks["setpoint_attitude/cmd_vel"](TwistStamped())
    uas.callbacks["setpoint_attitude/thrust"](thrust(-0.5))
    assert uas.client.sent[-1].thrust == -0.5


def test_a_raw_thrust_is_scaled_and_cut(monkeypatch):
    uas = make_uas(monkeypatch, {"~setpoint_raw/thrust_scaling": 0.5})
    SetpointRawPlugin(uas)
    message = AttitudeTarget(thrust=0.8)
    message.orientation.w = 1.0
    uas.callbacks["setpoint_raw/attitude"](message)
    assert uas.client.sent[-1].thrust == pytest.approx(0.4)
    message.thrust = 9.0
    uas.callbacks["setpoint_raw/attitude"](message)
    assert uas.client.sent[-1].thrust == 1.0
    message.orientation.w = math.nan
    uas.callbacks["setpoint_raw/attitude"](message)
    assert len(uas.client.sent) == 2


def test_accelerations_and_global_setpoints_go_out(uas):
    SetpointAccelPlugin(uas)
    SetpointRawPlugin(uas)
    SetpointPositionPlugin(uas)
    message = Vector3Stamped()
    message.vector.x = 1.5
    uas.callbacks["setpoint_accel/accel"](message)
    assert (uas.client.sent[-1].afy, uas.client.sent[-1].type_mask) == (1.5, 0b1100_0011_1111)
    target = GlobalPositionTarget(coordinate_frame=6, latitude=47.5, longitude=8.5, altitude=3.0)
    uas.callbacks["setpoint_raw/global"](target)
    sent = uas.client.sent[-1]
    assert (sent.lat_int, sent.lon_int, sent.alt, sent.coordinate_frame) == (475000000, 85000000, 3.0, 6)
    pose = GeoPoseStamped()
    pose.pose.position.latitude, pose.pose.position.altitude, pose.pose.orientation.w = 47.5, 500.0, 1.0
    uas.callbacks["setpoint_position/global"](pose)
    sent = uas.client.sent[-1]
    assert (sent.lat_int, sent.alt, sent.coordinate_frame) == (475000000, 500.0, 5)
    assert sent.yaw == pytest.approx(math.pi / 2)
    pose.pose.position.latitude = 99.0
    uas.callbacks["setpoint_position/global"](pose)
    assert len(uas.client.sent) == 3


def test_a_global_setpoint_becomes_a_local_one(uas):
    """1e-4 degrees north of the UAV, which is at (2, 1, 3) in ENU: 11.119 m by the radius of curvature."""
    SetpointPositionPlugin(uas)
    goal = GeoPoseStamped()
    goal.header.stamp.secs = 9
    goal.pose.position.latitude, goal.pose.position.longitude = 47.397842, 8.545594
    goal.pose.position.altitude = 491.5
    uas.callbacks["setpoint_position/global_to_local"](goal)
    assert not uas.client.sent  # where it is itself is not known
    uas.client.hear(local_position())
    uas.client.hear(global_position())
    goal.header.stamp.secs = 10
    uas.callbacks["setpoint_position/global_to_local"](goal)
    sent = uas.client.sent[-1]
    assert (sent.x, sent.y, sent.z) == pytest.approx((1.0 + 11.119, 2.0, -4.0), abs=2e-3)
    assert sent.get_type() == "SET_POSITION_TARGET_LOCAL_NED"
    uas.callbacks["setpoint_position/global_to_local"](goal)
    assert len(uas.client.sent) == 1  # its stamp has not risen


def test_px4s_targets_are_turned_to_enu(uas):
    SetpointRawPlugin(uas)
    motion = (4.0, 5.0, -6.0, 7.0, 8.0, -9.0, 0.0, 0.5)
    uas.client.hear(
        common.MAVLink_position_target_local_ned_message(5000, 1, 0b111, math.nan, 2.0, -3.0, *motion)
    )
    local = uas.topics["setpoint_raw/target_local"].last
    assert (local.position.x, local.position.z) == (2.0, 3.0)
    assert math.isnan(local.position.y)
    assert (xyz(local.velocity), xyz(local.acceleration_or_force)) == ((5.0, 4.0, 6.0), (8.0, 7.0, 9.0))
    assert (local.yaw, local.yaw_rate, local.type_mask) == (pytest.approx(math.pi / 2), -0.5, 0b111)
    uas.client.hear(
        common.MAVLink_position_target_global_int_message(5000, 5, 0, 475000000, 85000000, 490.0, *motion)
    )
    place = uas.topics["setpoint_raw/target_global"].last
    assert (place.latitude, place.longitude, place.altitude) == pytest.approx((47.5, 8.5, 490.0))
    assert xyz(place.velocity) == (5.0, 4.0, 6.0)
    uas.client.hear(
        common.MAVLink_attitude_target_message(5000, 0, [HALF_ROOT, 0, 0, HALF_ROOT], 0.1, 0.2, 0.3, 0.6)
    )
    target = uas.topics["setpoint_raw/target_attitude"].last
    assert xyzw(target.orientation) == pytest.approx((0, 0, 0, 1.0), abs=1e-6)
    assert (xyz(target.body_rate), target.thrust) == ((0.1, -0.2, -0.3), pytest.approx(0.6))


# Commands


def test_commands_carry_mavros_parameters(uas):
    CommandPlugin(uas)
    place = {"yaw": 0.5, "latitude": 47.5, "longitude": 8.5, "altitude": 490.0}
    uas.services["cmd/set_home"](request(current_gps=False, **place))
    uas.services["cmd/takeoff"](request(min_pitch=0.25, **place))
    uas.services["cmd/land"](request(min_pitch=0.25, **place))
    assert uas.client.commands == [
        (179, 0.0, 0.0, 0.0, 0.5, 47.5, 8.5, 490.0),
        (22, 0.25, 0.0, 0.0, 0.5, 47.5, 8.5, 490.0),
        (21, 0.0, 0.0, 0.0, 0.5, 47.5, 8.5, 490.0),
    ]


def test_nobody_waits_for_the_answer_to_command_int_and_to_broadcasts(uas):
    CommandPlugin(uas)
    params = {f"param{i}": float(i) for i in range(1, 8)}
    answer = uas.services["cmd/command"](request(broadcast=True, command=520, **params))
    assert (answer.success, answer.result) == (True, 0)
    assert (uas.client.sent[-1].target_system, uas.client.sent[-1].param7) == (0, 7.0)
    fields = {"frame": 5, "current": 0, "autocontinue": 0, "x": 475000000, "y": 85000000, "z": 3.0}
    ask = request(broadcast=False, command=192, **fields, **params)
    assert uas.services["cmd/command_int"](ask).success
    sent = uas.client.sent[-1]
    assert (sent.get_type(), sent.frame, sent.x, sent.y, sent.z) == ("COMMAND_INT", 5, 475000000, 85000000, 3)
    assert not uas.client.commands
    ask.param1 = 1e300
    assert not uas.services["cmd/command_int"](ask).success
