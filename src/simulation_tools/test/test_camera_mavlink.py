"""A ground station sees the inspection camera, takes photographs with it, and tilts its gimbal."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common

from simulation_tools.camera.mavlink_camera import COMPONENT, CameraData, MavlinkCamera

GCS = (255, 190)
CAMERA = CameraData(5184, 3888, (-0.5, 1.5))
REQUEST, START = common.MAV_CMD_REQUEST_MESSAGE, common.MAV_CMD_IMAGE_START_CAPTURE
ACCEPTED, DENIED = common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_DENIED


def sent(message):
    """The message as it arrives on the other side."""
    return common.MAVLink(None).parse_buffer(message.pack(common.MAVLink(None, *GCS)))[0]


def told(camera, number, *params, system=1, component=COMPONENT):
    """The camera's answer to a command of a ground station, and the names of its messages."""
    seven = (*params, *[0.0] * 7)[:7]
    command = sent(common.MAVLink_command_long_message(system, component, number, 0, *seven))
    answer = camera.handle(command, 1000)
    for message in answer.messages:
        sent(message)  # it can be packed
    return answer, [message.get_type() for message in answer.messages]


@pytest.mark.table(
    ("number", "name"),
    [
        (259, "CAMERA_INFORMATION"),
        (260, "CAMERA_SETTINGS"),
        (261, "STORAGE_INFORMATION"),
        (262, "CAMERA_CAPTURE_STATUS"),
        (280, "GIMBAL_MANAGER_INFORMATION"),
        (281, "GIMBAL_MANAGER_STATUS"),
        (285, "GIMBAL_DEVICE_ATTITUDE_STATUS"),
    ],
)
def test_what_a_ground_station_asks_for_is_told(number, name):
    answer, names = told(MavlinkCamera(CAMERA, 1), REQUEST, float(number))
    assert names == ["COMMAND_ACK", name]
    ack = answer.messages[0]
    assert (ack.result, ack.target_system, ack.target_component) == (ACCEPTED, *GCS)


def test_the_older_request_and_the_cameras_numbers():
    answer, names = told(MavlinkCamera(CAMERA, 1), common.MAV_CMD_REQUEST_CAMERA_INFORMATION, 1.0)
    assert names == ["COMMAND_ACK", "CAMERA_INFORMATION"]
    assert (answer.messages[1].resolution_h, answer.messages[1].resolution_v) == (5184, 3888)


def test_a_photograph_is_taken_one_at_a_time_and_counted():
    camera = MavlinkCamera(CAMERA, 1)
    assert told(camera, START, 0.0, 0.0, 1.0)[0].shoots
    busy, _ = told(camera, START, 0.0, 0.0, 1.0)
    assert (busy.shoots, busy.messages[0].result) == (False, DENIED)
    done = sent(camera.captured(2000, 1_500_000, ok=True))
    assert (done.image_index, done.capture_result, done.time_utc) == (0, 1, 1_500_000)
    assert told(camera, START, 0.0, 0.0, 1.0)[0].shoots
    assert camera.captured(3000, 0, ok=False).capture_result == 0
    assert camera.taken == 1
    assert not told(camera, START, 0.0, 2.0, 0.0)[0].shoots  # one every 2 s, for ever


@pytest.mark.table(
    ("pitch_deg", "yaw_deg", "tilt_deg"),
    [
        (20.0, 0.0, 20.0),
        (20.0, math.nan, 20.0),
        (-40.0, 0.0, None),
        (20.0, 30.0, None),
        (math.nan, 0.0, None),
    ],
)
def test_the_gimbal_tilts_within_its_limits_and_does_not_turn(pitch_deg, yaw_deg, tilt_deg):
    number = common.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW
    answer, _ = told(MavlinkCamera(CAMERA, 1), number, pitch_deg, yaw_deg)
    if tilt_deg is None:
        assert (answer.tilt_rad, answer.messages[0].result) == (None, DENIED)
    else:
        assert math.degrees(answer.tilt_rad) == pytest.approx(tilt_deg)


def test_what_is_meant_for_others_or_unknown():
    camera = MavlinkCamera(CAMERA, 1)
    assert told(camera, REQUEST, 259.0, component=1)[1] == []
    assert told(camera, REQUEST, 259.0, system=2)[1] == []
    unknown = told(camera, common.MAV_CMD_NAV_LAND)[0].messages[0]
    assert unknown.result == common.MAV_RESULT_UNSUPPORTED
    assert told(camera, REQUEST, 30.0)[0].messages[0].result == DENIED
    assert camera.handle(sent(MavlinkCamera.heartbeat()), 0).messages == ()
