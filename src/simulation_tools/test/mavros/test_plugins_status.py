"""MAVROS's plugins: altitude, battery, clocks, remote control, and what flies.

Expected values are MAVROS 1.21's: its source says frames, units and covariances.
"""

from __future__ import annotations

import math

import pytest
from fake_uas import request
from genpy import Time
from mavros_msgs.msg import OverrideRCIn
from pymavlink.dialects.v20 import common

from simulation_tools_ros.mavros.plugins.altitude import AltitudePlugin
from simulation_tools_ros.mavros.plugins.rc_io import RcIoPlugin
from simulation_tools_ros.mavros.plugins.sys_status import SysStatusPlugin
from simulation_tools_ros.mavros.plugins.sys_time import SysTimePlugin
from simulation_tools_ros.mavros.plugins.vehicle_info import VehicleInfoPlugin
from simulation_tools_ros.mavros.plugins.vfr_hud import VfrHudPlugin

pytestmark = pytest.mark.ros


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
