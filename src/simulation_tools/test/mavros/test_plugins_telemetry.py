"""MAVROS's plugins: what each message of the flight controller becomes.

Expected values are MAVROS 1.21's: its source says frames, units and covariances.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

sys.path.insert(0, str(Path(__file__).resolve().parent))
from fake_uas import make_uas, request, xyz, xyzw

pytestmark = pytest.mark.ros
for module in ("mavros_msgs.msg", "simulation_tools_ros.mavros.uas"):
    pytest.importorskip(module, reason="needs ROS's message packages")

from genpy import Time  # noqa: E402
from mavros_msgs.msg import (  # noqa: E402
    HomePosition,
    OverrideRCIn,
)

from simulation_tools_ros.mavros.plugins.altitude import AltitudePlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.global_position import GlobalPositionPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.home_position import HomePositionPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.imu import ImuPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.local_position import LocalPositionPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.rc_io import RcIoPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.sys_status import SysStatusPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.sys_time import SysTimePlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.vehicle_info import VehicleInfoPlugin  # noqa: E402
from simulation_tools_ros.mavros.plugins.vfr_hud import VfrHudPlugin  # noqa: E402

HALF_ROOT = math.sqrt(0.5)


@pytest.fixture
def uas(monkeypatch):
    return make_uas(monkeypatch)


def attitude(q=(1.0, 0.0, 0.0, 0.0), rates=(0.1, 0.2, 0.3), ms=5000):
    """Level, facing north by default."""
    return common.MAVLink_attitude_quaternion_message(ms, *q, *rates)


def highres_imu(fields=7167, us=5_000_000):
    return common.MAVLink_highres_imu_message(
        us, 1.0, 2.0, -9.8, 0.1, 0.2, 0.3, 0.2, 0.1, 0.4, 95000.0, 12.0, 500.0, 20.0, fields
    )


# imu


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


# local_position


def local_position(us=5_040_000):
    return common.MAVLink_local_position_ned_message(us // 1000, 1.0, 2.0, -3.0, 0.4, 0.5, -0.6)


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


# global_position


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


def global_position(lat=473977420, lon=85455940, relative=2500):
    return common.MAVLink_global_position_int_message(5000, lat, lon, 490500, relative, 10, 20, -30, 4500)


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


def test_the_global_position_is_metres_from_home_and_keeps_mavros_sign_of_vz(uas):
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


# altitude, vfr_hud, sys_status, sys_time, rc_io


def test_altitude_and_hud(uas):
    AltitudePlugin(uas)
    VfrHudPlugin(uas)
    uas.client.hear(common.MAVLink_altitude_message(5_000_000, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    message = uas.topics["altitude"].last
    assert (message.header.frame_id, message.header.stamp.to_sec()) == ("map", 5.0)
    assert (message.monotonic, message.amsl, message.local) == (1.0, 2.0, 3.0)
    assert (message.relative, message.terrain, message.bottom_clearance) == (4.0, 5.0, 6.0)
    uas.client.hear(common.MAVLink_vfr_hud_message(1.0, 2.0, 90, 55, 488.0, 0.5))
    hud = uas.topics["vfr_hud"].last
    assert (hud.airspeed, hud.groundspeed, hud.heading, hud.altitude, hud.climb) == (1.0, 2.0, 90, 488.0, 0.5)
    assert hud.throttle == pytest.approx(0.55)


def test_the_battery_is_sys_statuss_until_battery_status_comes(uas, monkeypatch):
    monkeypatch.setattr("rospy.Publisher", lambda *a, **k: None)
    SysStatusPlugin(uas)
    system = common.MAVLink_sys_status_message(7, 3, 1, 100, 15700, 250, 80, 1, 2, 3, 4, 5, 6)
    uas.client.hear(system)
    status, battery = uas.topics["sys_status"].last, uas.topics["battery"].last
    assert (status.sensors_present, status.sensors_enabled, status.sensors_health) == (7, 3, 1)
    assert (status.voltage_battery, status.current_battery, status.battery_remaining) == (15700, 250, 80)
    assert (status.load, status.drop_rate_comm, status.errors_count4) == (100, 1, 6)
    assert (battery.voltage, battery.current, battery.percentage) == pytest.approx((15.7, -2.5, 0.8))
    cells = [3900, 3910, 3920, 3930] + [65535] * 6
    uas.client.hear(common.MAVLink_battery_status_message(0, 1, 1, 32767, cells, 150, 0, -1, 79))
    uas.client.hear(system)
    assert len(uas.topics["battery"].messages) == 2  # of SYS_STATUS no more
    battery = uas.topics["battery"].last
    assert battery.cell_voltage == pytest.approx([3.90, 3.91, 3.92, 3.93])
    assert (battery.voltage, battery.current, battery.percentage) == pytest.approx((15.66, -1.5, 0.79))
    assert (battery.location, battery.power_supply_technology) == ("id0", 3)  # LIPO


def test_message_intervals(uas, monkeypatch):
    monkeypatch.setattr("rospy.Publisher", lambda *a, **k: None)
    SysStatusPlugin(uas)
    serve = uas.services["set_message_interval"]
    for rate_hz, interval_us in ((50.0, 20000.0), (0.0, 0.0), (-3.0, -1.0)):
        assert serve(request(message_id=141, message_rate=rate_hz)).success
        assert uas.client.commands[-1] == (511, 141.0, interval_us)
    assert not serve(request(message_id=141, message_rate=math.nan)).success
    uas.client.result = 4
    assert not serve(request(message_id=0, message_rate=1.0)).success


def test_the_clocks(uas):
    SysTimePlugin(uas)
    uas.client.hear(common.MAVLink_system_time_message(1_600_000_000_500_000, 5000))
    reference = uas.topics["time_reference"].last
    assert (reference.time_ref.to_sec(), reference.source) == (1_600_000_000.5, "fcu")
    uas.client.hear(common.MAVLink_system_time_message(0, 6000))
    assert len(uas.topics["time_reference"].messages) == 1  # a clock that nobody has set
    uas.client.hear(common.MAVLink_timesync_message(0, 123))
    assert (uas.client.sent[-1].tc1, uas.client.sent[-1].ts1) == (77 * 10**9, 123)  # answered
    uas.client.hear(common.MAVLink_timesync_message(70 * 10**9, 77 * 10**9 - 4_000_000))
    status = uas.topics["timesync_status"].last
    assert (status.remote_timestamp_ns, status.round_trip_time_ms) == (70 * 10**9, 4.0)
    assert status.observed_offset_ns == status.estimated_offset_ns == 7 * 10**9 - 2_000_000


def test_a_question_at_time_zero_is_answered_by_no_question(uas, monkeypatch):
    """In TIMESYNC zero is a question: two peers whose clocks stand at zero would ask each other for ever."""
    SysTimePlugin(uas)
    monkeypatch.setattr("rospy.get_rostime", Time)
    uas.client.hear(common.MAVLink_timesync_message(0, 123))
    assert uas.client.sent[-1].tc1 > 0


def test_remote_control(uas):
    RcIoPlugin(uas)
    channels = [1000 + i for i in range(18)]
    uas.client.hear(common.MAVLink_rc_channels_message(5000, 8, *channels, 200))
    assert (uas.topics["rc/in"].last.channels, uas.topics["rc/in"].last.rssi) == (channels[:8], 200)
    uas.client.hear(common.MAVLink_servo_output_raw_message(5_000_000, 0, *range(900, 908)))
    assert uas.topics["rc/out"].last.channels == [*range(900, 908), *[0] * 8]
    uas.callbacks["rc/override"](OverrideRCIn(channels=channels))
    sent = uas.client.sent[-1]
    assert (sent.get_type(), sent.chan1_raw, sent.chan18_raw) == ("RC_CHANNELS_OVERRIDE", 1000, 1017)


def test_vehicle_info(uas):
    VehicleInfoPlugin(uas)
    serve = uas.services["vehicle_info_get"]
    assert not serve(request(sysid=0, compid=0, get_all=False)).success
    uas.client.hear(common.MAVLink_heartbeat_message(2, 12, 157, 0x03040000, 4, 3))
    uas.client.hear(
        common.MAVLink_autopilot_version_message(
            58607, 1, 2, 3, 4, [0, 0, 0, 201, 182, 11, 22, 52], [0] * 8, [0] * 8, 5, 6, 7
        )
    )
    for ids in ((0, 0), (1, 1)):
        answer = serve(request(sysid=ids[0], compid=ids[1], get_all=False))
        assert answer.success
        info = answer.vehicles[0]
    assert (info.available_info, info.autopilot, info.type, info.mode) == (3, 12, 2, "AUTO.LOITER")
    assert (info.mode_id, info.capabilities, info.flight_custom_version) == (
        0x03040000,
        58607,
        "34160bb6c9000000",
    )
    assert not serve(request(sysid=9, compid=1, get_all=False)).success
    assert len(serve(request(sysid=9, compid=9, get_all=True)).vehicles) == 1
