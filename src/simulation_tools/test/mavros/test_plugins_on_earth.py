"""MAVROS's plugins: what they publish of the place on earth, and of home.

Expected values are MAVROS 1.21's: its source says frames, units and covariances.
"""

from __future__ import annotations

import math

import pytest
from fake_uas import HALF_ROOT, attitude, global_position, make_uas, xyz, xyzw
from mavros_msgs.msg import HomePosition
from pymavlink.dialects.v20 import common

from simulation_tools_ros.mavros.plugins.global_position import GlobalPositionPlugin
from simulation_tools_ros.mavros.plugins.home_position import HomePositionPlugin

pytestmark = pytest.mark.ros


def gps(**changes):
    fields = {"h_acc": 299, "v_acc": 399, "eph": 65535, "epv": 65535, "fix_type": 3, **changes}
    return common.MAVLink_gps_raw_int_message(
        4_000_000,
        fields["fix_type"],
        473977420,
        85455940,
        488000,
        fields["eph"],
        fields["epv"],
        200,
        9000,
        10,
        h_acc=fields["h_acc"],
        v_acc=fields["v_acc"],
    )


def test_the_raw_fix_has_the_receivers_accuracy(uas):
    GlobalPositionPlugin(uas)
    uas.client.hear(gps())
    fix = uas.topics["global_position/raw/fix"].last
    assert (fix.latitude, fix.longitude, fix.altitude) == pytest.approx((47.397742, 8.545594, 488.0))
    assert (fix.header.frame_id, fix.header.stamp.to_sec()) == ("base_link", 4.0)
    assert (fix.status.status, fix.status.service, fix.position_covariance_type) == (0, 1, 2)
    assert fix.position_covariance[0:9:4] == pytest.approx([0.299**2, 0.299**2, 0.399**2])
    velocity = uas.topics["global_position/raw/gps_vel"].last
    assert (velocity.header.frame_id, xyz(velocity.twist.linear)) == ("map", pytest.approx((2.0, 0.0, 0.0)))
    assert uas.topics["global_position/raw/satellites"].last.data == 10
    uas.client.hear(gps(h_acc=0, eph=90, epv=120, fix_type=2))
    fix = uas.topics["global_position/raw/fix"].last
    assert (fix.status.status, fix.position_covariance_type) == (-1, 1)
    assert fix.position_covariance[0:9:4] == pytest.approx([0.81, 0.81, 1.44])
    uas.client.hear(gps(h_acc=0))
    fix = uas.topics["global_position/raw/fix"].last
    assert (fix.position_covariance[0], fix.position_covariance_type) == (-1.0, 0)


def test_the_global_position_is_from_home_with_mavros_sign_of_vz(uas):
    GlobalPositionPlugin(uas)
    uas.client.hear(attitude())
    uas.client.hear(gps())
    home = common.MAVLink_home_position_message(473977420, 85455940, 488000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
    uas.client.hear(home)
    # 1e-4 degrees of latitude and longitude: by the radii of curvature 11.119 m and 7.550 m
    uas.client.hear(global_position(473977420 + 1000, 85455940 + 1000))
    odometry = uas.topics["global_position/local"].last
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "base_link")
    assert xyz(odometry.pose.pose.position) == pytest.approx((7.550, 11.119, 2.5), abs=2e-3)
    assert xyz(odometry.twist.twist.linear) == pytest.approx((0.2, 0.1, -0.3))
    assert xyzw(odometry.pose.pose.orientation) == pytest.approx((0, 0, HALF_ROOT, HALF_ROOT))
    assert odometry.pose.covariance[0:15:7] == pytest.approx([0.299**2, 0.299**2, 0.399**2])
    assert odometry.pose.covariance[21:36:7] == [99999.0] * 3
    assert odometry.twist.covariance[0] == -1.0
    fix = uas.topics["global_position/global"].last
    assert (fix.altitude, fix.position_covariance_type) == (490.5, 2)
    assert uas.topics["global_position/rel_alt"].last.data == 2.5
    assert uas.topics["global_position/compass_hdg"].last.data == 45.0


def test_altitudes_are_over_the_ellipsoid_where_the_geoid_is_known(monkeypatch):
    uas = make_uas(monkeypatch, {"~geoid_height": 47.25})
    GlobalPositionPlugin(uas)
    HomePositionPlugin(uas)
    uas.client.hear(gps())
    uas.client.hear(
        common.MAVLink_home_position_message(473977420, 85455940, 488000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
    )
    assert uas.topics["global_position/raw/fix"].last.altitude == 535.25
    assert uas.topics["home_position/home"].last.geo.altitude == 535.25


def test_home_is_turned_to_enu(uas):
    HomePositionPlugin(uas)
    home = common.MAVLink_home_position_message(
        473977420, 85455940, 488000, 1.0, 2.0, -3.0, [HALF_ROOT, 0, 0, HALF_ROOT], 4.0, 5.0, -6.0
    )
    uas.client.hear(home)
    message = uas.topics["home_position/home"].last
    assert (xyz(message.position), xyz(message.approach)) == ((2.0, 1.0, 3.0), (5.0, 4.0, 6.0))
    # NED to ENU is half a turn about the axis between x and y; then a quarter turn about down
    assert xyzw(message.orientation) == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-6)
    uas.client.result = 0
    assert uas.services["home_position/req_update"](None).success
    assert uas.client.commands == [(410,)]


def test_a_home_that_is_no_place_is_not_sent(uas):
    HomePositionPlugin(uas)
    message = HomePosition()
    message.geo.latitude = math.nan
    uas.callbacks["home_position/set"](message)
    assert not uas.client.sent
    message.geo.latitude, message.position.x = 47.5, 2.0
    uas.callbacks["home_position/set"](message)
    assert (uas.client.sent[-1].latitude, uas.client.sent[-1].y) == (475000000, 2.0)
