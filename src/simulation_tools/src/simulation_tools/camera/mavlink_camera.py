"""The camera and its gimbal as MAVLink components: what a ground station asks, and what it is answered.

https://mavlink.io/en/services/camera.html and gimbal_v2.html. Both are component 100. The gimbal only tilts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from pymavlink.dialects.v20 import common

COMPONENT = common.MAV_COMP_ID_CAMERA
_ACCEPTED, _DENIED = common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_DENIED
_LEVEL_DEG = 0.5
"""A yaw within this is none."""
_REQUESTS = {
    common.MAV_CMD_REQUEST_CAMERA_INFORMATION: common.MAVLINK_MSG_ID_CAMERA_INFORMATION,
    common.MAV_CMD_REQUEST_CAMERA_SETTINGS: common.MAVLINK_MSG_ID_CAMERA_SETTINGS,
    common.MAV_CMD_REQUEST_STORAGE_INFORMATION: common.MAVLINK_MSG_ID_STORAGE_INFORMATION,
    common.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS: common.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS,
}
"""Older commands that ask for one message."""


@dataclass(frozen=True)
class CameraData:
    """What a ground station is told. width, height: px. tilts_rad: of the axis over the horizon."""

    width: int
    height: int
    tilts_rad: tuple[float, float] = (-math.pi / 2.0, math.pi / 2.0)


class Answer(NamedTuple):
    """messages: to send. shoots: a photograph is to be taken. tilt_rad: where the gimbal is to point."""

    messages: tuple[common.MAVLink_message, ...] = ()
    shoots: bool = False
    tilt_rad: float | None = None


class MavlinkCamera:
    """Answers one ground station. time_ms: of the boot.

    Attributes:
        tilt_rad: where the gimbal points. taken: photographs so far.
    """

    def __init__(self, data: CameraData, system: int) -> None:
        self._data, self._system = data, system
        self.tilt_rad, self.taken = 0.0, 0
        self._is_busy = False

    @staticmethod
    def heartbeat() -> common.MAVLink_message:
        """Build the heartbeat of a camera; once a second."""
        return common.MAVLink_heartbeat_message(
            common.MAV_TYPE_CAMERA, common.MAV_AUTOPILOT_INVALID, 0, 0, common.MAV_STATE_ACTIVE, 3
        )

    def handle(self, message: common.MAVLink_message, time_ms: int) -> Answer:
        """Answer a message; one that is for another component gets no answer."""
        if message.get_type() != "COMMAND_LONG" or not self._is_meant(message):
            return Answer()
        command = message.command
        if command == common.MAV_CMD_REQUEST_MESSAGE or command in _REQUESTS:
            asked = _REQUESTS.get(command, int(message.param1) if math.isfinite(message.param1) else -1)
            told = self._message(asked, time_ms)
            return Answer(
                (self._ack(message, _DENIED if told is None else _ACCEPTED), *((told,) if told else ()))
            )
        if command == common.MAV_CMD_IMAGE_START_CAPTURE:
            may = message.param3 == 1.0 and not self._is_busy
            self._is_busy = self._is_busy or may
            return Answer((self._ack(message, _ACCEPTED if may else _DENIED),), shoots=may)
        if command in (common.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, common.MAV_CMD_DO_MOUNT_CONTROL):
            return self._point(message)
        return Answer((self._ack(message, common.MAV_RESULT_UNSUPPORTED),))

    def captured(self, time_ms: int, stamp_us: int, ok: bool) -> common.MAVLink_message:
        """Build CAMERA_IMAGE_CAPTURED for the photograph that was asked for last."""
        self._is_busy = False
        index, self.taken = self.taken, self.taken + ok
        return common.MAVLink_camera_image_captured_message(
            time_ms, stamp_us, 0, 0, 0, 0, 0, (1.0, 0.0, 0.0, 0.0), index, int(ok), b""
        )

    def _is_meant(self, message: common.MAVLink_message) -> bool:
        return message.target_system in (0, self._system) and message.target_component in (0, COMPONENT)

    def _ack(self, message: common.MAVLink_message, result: int) -> common.MAVLink_message:
        return common.MAVLink_command_ack_message(
            message.command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()
        )

    def _point(self, message: common.MAVLink_message) -> Answer:
        """Tilt the gimbal. It has no other axis, and its limits are told in GIMBAL_MANAGER_INFORMATION."""
        is_mount = message.command == common.MAV_CMD_DO_MOUNT_CONTROL
        tilt_rad, yaw_deg = math.radians(message.param1), message.param3 if is_mount else message.param2
        low, high = self._data.tilts_rad
        turns = math.isfinite(yaw_deg) and abs(yaw_deg) > _LEVEL_DEG
        if turns or not low - 1e-6 <= tilt_rad <= high + 1e-6:
            return Answer((self._ack(message, _DENIED),))
        self.tilt_rad = tilt_rad
        return Answer((self._ack(message, _ACCEPTED),), tilt_rad=tilt_rad)

    def _message(self, number: int, time_ms: int) -> common.MAVLink_message | None:
        """Return a message that may be asked for; None: there is none of this number."""
        data = self._data
        if number == common.MAVLINK_MSG_ID_CAMERA_INFORMATION:
            return common.MAVLink_camera_information_message(
                time_ms,
                tuple(b"simulation_tools".ljust(32, b"\0")),
                tuple(b"inspection_camera".ljust(32, b"\0")),
                0,
                math.nan,
                math.nan,
                math.nan,
                data.width,
                data.height,
                0,
                common.CAMERA_CAP_FLAGS_CAPTURE_IMAGE,
                0,
                b"",
            )
        if number == common.MAVLINK_MSG_ID_CAMERA_SETTINGS:
            return common.MAVLink_camera_settings_message(time_ms, common.CAMERA_MODE_IMAGE)
        if number == common.MAVLINK_MSG_ID_STORAGE_INFORMATION:
            return common.MAVLink_storage_information_message(
                time_ms, 1, 1, common.STORAGE_STATUS_READY, math.nan, math.nan, math.nan, math.nan, math.nan
            )
        if number == common.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS:
            return common.MAVLink_camera_capture_status_message(
                time_ms, int(self._is_busy), 0, 0.0, 0, math.nan, self.taken
            )
        if number == common.MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION:
            return common.MAVLink_gimbal_manager_information_message(
                time_ms,
                common.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS,
                COMPONENT,
                0.0,
                0.0,
                *data.tilts_rad,
                0.0,
                0.0,
            )
        if number == common.MAVLINK_MSG_ID_GIMBAL_MANAGER_STATUS:
            return common.MAVLink_gimbal_manager_status_message(time_ms, 0, COMPONENT, 0, 0, 0, 0)
        if number == common.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS:
            half = 0.5 * self.tilt_rad
            return common.MAVLink_gimbal_device_attitude_status_message(
                0, 0, time_ms, 0, (math.cos(half), 0.0, math.sin(half), 0.0), 0.0, 0.0, 0.0, 0
            )
        return None
