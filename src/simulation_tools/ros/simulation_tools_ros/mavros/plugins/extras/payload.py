"""MAVROS's plugins for cameras and gimbals: camera, cam_imu_sync, mount_control."""

from __future__ import annotations

import math

import rospy
from geometry_msgs.msg import Quaternion
from mavros_msgs import srv
from mavros_msgs.msg import CameraImageCaptured, CamIMUStamp, MountControl
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.mavlink import decode_text
from simulation_tools.mavros.told import mount_control
from simulation_tools_ros.mavros.uas import Uas, stamp_from_ms, stamp_from_us

_FAILED = common.MAV_RESULT_FAILED


class CameraPlugin:
    """Publishes camera/image_captured. Each component of the UAV may have sent the message."""

    def __init__(self, uas: Uas) -> None:
        self._geoid_height_m = uas.geoid_height_m
        self._captured = uas.advertise("camera/image_captured", CameraImageCaptured)
        uas.client.on("CAMERA_IMAGE_CAPTURED", self._on_captured, any_component=True)

    def _on_captured(self, message: common.MAVLink_message) -> None:
        self._captured.publish(lambda: captured_message(message, self._geoid_height_m))


class CamImuSyncPlugin:
    """Publishes cam_imu_sync/cam_imu_stamp: when the flight controller triggered a camera."""

    def __init__(self, uas: Uas) -> None:
        self._stamp = uas.advertise("cam_imu_sync/cam_imu_stamp", CamIMUStamp)
        uas.client.on("CAMERA_TRIGGER", self._on_trigger, any_component=True)

    def _on_trigger(self, message: common.MAVLink_message) -> None:
        self._stamp.publish(lambda: CamIMUStamp(stamp_from_us(message.time_usec), message.seq))


class MountControlPlugin:
    """Takes mount_control/command; publishes mount_control/orientation; serves mount_control/configure.

    As in MAVROS, a command does not wait for an answer. Where MAVROS ends a refused call of `configure` with
    an error, this one answers success false, and the flight controller's MAV_RESULT.
    Parameters: ~mount_control/negate_measured_{roll,pitch,yaw}.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._signs = [
            -1.0 if rospy.get_param(f"~mount_control/negate_measured_{axis}", False) else 1.0
            for axis in ("roll", "pitch", "yaw")
        ]
        self._orientation = uas.advertise("mount_control/orientation", Quaternion)
        uas.subscribe("mount_control/command", MountControl, self._on_command, queue_size=10)
        uas.serve("mount_control/configure", srv.MountConfigure, self._on_configure)
        uas.client.on("MOUNT_ORIENTATION", self._on_orientation, any_component=True)

    def _on_orientation(self, message: common.MAVLink_message) -> None:
        """The angles are degrees. MAVROS turns them to no other frame."""
        angles = [
            math.radians(sign * angle)
            for sign, angle in zip(self._signs, (message.roll, message.pitch, message.yaw))
        ]
        self._orientation.publish(lambda: Quaternion(*quaternion_from_rpy(*angles)))

    def _on_command(self, m: MountControl) -> None:
        angles_deg, place = (m.pitch, m.roll, m.yaw), (m.altitude, m.latitude, m.longitude)
        self._uas.send_built(
            "A command on mount_control/command",
            lambda: mount_control(self._uas.client.target, m.mode, angles_deg, place),
        )

    def _on_configure(self, request: srv.MountConfigureRequest) -> srv.MountConfigureResponse:
        result = self._uas.client.command(
            common.MAV_CMD_DO_MOUNT_CONFIGURE,
            request.mode,
            request.stabilize_roll,
            request.stabilize_pitch,
            request.stabilize_yaw,
            request.roll_input,
            request.pitch_input,
            request.yaw_input,
        )
        if result is None:
            rospy.logwarn("mount_control/configure: the flight controller did not answer.")
            result = _FAILED
        return srv.MountConfigureResponse(success=result == common.MAV_RESULT_ACCEPTED, result=result)


def captured_message(captured: common.MAVLink_message, geoid_height_m: float) -> CameraImageCaptured:
    """CAMERA_IMAGE_CAPTURED to CameraImageCaptured; altitudes in m, above the ellipsoid and above home."""
    w, x, y, z = captured.q
    message = CameraImageCaptured(
        header=Header(stamp=stamp_from_ms(captured.time_boot_ms)),
        orientation=Quaternion(x, y, z, w),
        relative_alt=1e-3 * captured.relative_alt,
        image_index=captured.image_index,
        capture_result=captured.capture_result,
        file_url=decode_text(captured.file_url),
    )
    message.geo.latitude = 1e-7 * captured.lat
    message.geo.longitude = 1e-7 * captured.lon
    message.geo.altitude = 1e-3 * captured.alt + geoid_height_m
    return message
