"""Cameras, gimbals and joysticks: what MAVROS 1.21 makes of their messages, and sends for them."""

from __future__ import annotations

import math
import socket

import pytest
import rospy
from fake_uas import make_uas, xyzw
from mavros_msgs.msg import ManualControl, MountControl
from mavros_msgs.srv import MountConfigureRequest
from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import Codec
from simulation_tools.mavros.client import FcuClient
from simulation_tools_ros.mavros.plugins.extras.payload import (
    CameraPlugin,
    CamImuSyncPlugin,
    MountControlPlugin,
)
from simulation_tools_ros.mavros.plugins.extras.to_fcu import ManualControlPlugin

pytestmark = pytest.mark.ros

HALF_ROOT = math.sqrt(0.5)
CAPTURED = common.MAVLink_camera_image_captured_message(
    5040, 0, 1, 473977420, 85455940, 490500, 2500, (HALF_ROOT, 0.0, HALF_ROOT, 0.0), 7, 1, b"file:///a.jpg"
)


def test_sticks_are_sent_as_they_come(uas):
    ManualControlPlugin(uas)
    uas.callbacks["manual_control/send"](
        ManualControl(x=500.9, y=-1000.0, z=250.0, r=-3.0, buttons=5, aux1=9.0)
    )
    (sent,) = uas.client.sent
    assert (sent.target, sent.x, sent.y, sent.z, sent.r, sent.buttons) == (1, 500, -1000, 250, -3, 5)
    assert (sent.enabled_extensions, sent.aux1) == (0, 0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 32768.0, -32769.0])
def test_sticks_that_mavlink_cannot_hold_are_refused(uas, monkeypatch, bad):
    said = []
    monkeypatch.setattr(rospy, "logwarn", said.append)
    ManualControlPlugin(uas)
    uas.callbacks["manual_control/send"](ManualControl(r=bad))
    assert not uas.client.sent
    assert "manual_control/send is refused" in said[0]


def test_another_pilots_sticks_are_shares(uas):
    ManualControlPlugin(uas)
    uas.client.hear(common.MAVLink_manual_control_message(1, 500, -1000, 250, 0, 3))
    told = uas.topics["manual_control/control"].last
    assert (told.x, told.y, told.z, told.r) == pytest.approx((0.5, -1.0, 0.25, 0.0))
    assert (told.buttons, told.header.stamp.secs) == (3, 77)


def test_a_gimbals_command_is_passed_on(uas):
    MountControlPlugin(uas)
    uas.callbacks["mount_control/command"](
        MountControl(mode=2, pitch=-30.0, roll=1.0, yaw=45.0, altitude=3.0, latitude=4.0, longitude=5.0)
    )
    (sent,) = uas.client.sent
    params = [getattr(sent, f"param{i}") for i in range(1, 8)]
    assert (sent.command, params) == (205, [-30.0, 1.0, 45.0, 3.0, 4.0, 5.0, 2])
    uas.callbacks["mount_control/command"](MountControl(pitch=math.nan))
    assert len(uas.client.sent) == 1


@pytest.mark.parametrize(("result", "told"), [(0, (True, 0)), (3, (False, 3)), (None, (False, 4))])
def test_a_gimbal_is_configured(uas, monkeypatch, result, told):
    monkeypatch.setattr(rospy, "logwarn", lambda text: None)
    MountControlPlugin(uas)
    uas.client.result = result
    answer = uas.services["mount_control/configure"](
        MountConfigureRequest(mode=2, stabilize_pitch=True, roll_input=1, pitch_input=2)
    )
    assert (answer.success, answer.result) == told
    assert uas.client.commands == [(204, 2, False, True, False, 1, 2, 0)]


def test_a_gimbals_attitude_is_a_quaternion(monkeypatch):
    """30 degrees down; by the parameter up."""
    for negated, sign in ((False, -1.0), (True, 1.0)):
        uas = make_uas(monkeypatch, {"~mount_control/negate_measured_pitch": negated})
        MountControlPlugin(uas)
        uas.client.hear(common.MAVLink_mount_orientation_message(5, 0.0, -30.0, 0.0, 0.0))
        half = math.radians(15.0)
        wanted = (0.0, sign * math.sin(half), 0.0, math.cos(half))
        assert xyzw(uas.topics["mount_control/orientation"].last) == pytest.approx(wanted)


def test_a_photograph_is_told_with_its_place(monkeypatch):
    uas = make_uas(monkeypatch, {"~geoid_height": 47.3})
    CameraPlugin(uas)
    uas.client.hear(CAPTURED)
    told = uas.topics["camera/image_captured"].last
    assert (told.geo.latitude, told.geo.longitude) == pytest.approx((47.397742, 8.545594), abs=1e-9)
    assert (told.geo.altitude, told.relative_alt) == pytest.approx((537.8, 2.5))
    assert xyzw(told.orientation) == pytest.approx((0.0, HALF_ROOT, 0.0, HALF_ROOT))
    assert (told.image_index, told.capture_result, told.file_url) == (7, 1, "file:///a.jpg")
    assert told.header.stamp == rospy.Time(5, 40_000_000)


def test_a_trigger_is_told_with_its_number(uas):
    CamImuSyncPlugin(uas)
    uas.client.hear(common.MAVLink_camera_trigger_message(5_040_001, 12))
    told = uas.topics["cam_imu_sync/cam_imu_stamp"].last
    assert (told.frame_stamp, told.frame_seq_id) == (rospy.Time(5, 40_001_000), 12)


def test_a_camera_behind_the_flight_controller_is_heard_and_one_of_another_uav_is_not():
    """PX4 forwards what a camera, component 100, sends. Other messages count from the autopilot alone."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as fcu:
        fcu.bind(("127.0.0.1", 0))
        client = FcuClient(f"udp://127.0.0.1:0@127.0.0.1:{fcu.getsockname()[1]}")
        heard = []
        client.on(
            "CAMERA_IMAGE_CAPTURED", lambda m: heard.append((m.get_srcSystem(), m.get_srcComponent())), True
        )
        client.on("BATTERY_STATUS", lambda m: heard.append("battery"))
        battery = common.MAVLink_battery_status_message(0, 0, 0, 0, [0] * 10, 0, 0, 0, 50)
        end = common.MAVLink_camera_image_captured_message(0, 0, 0, 0, 0, 0, 0, (1, 0, 0, 0), 0, 1, b"")
        for system, component, message in (
            (1, 100, CAPTURED),
            (2, 100, CAPTURED),
            (1, 100, battery),
            (1, 1, end),
        ):
            fcu.sendto(Codec(system, component).pack(message), client.local_address)
        while len(heard) < 2 and client.wait(30.0):
            client.poll()
        client.close()
    assert heard == [(1, 100), (1, 1)]
