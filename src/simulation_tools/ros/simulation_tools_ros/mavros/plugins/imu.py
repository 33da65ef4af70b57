"""MAVROS's plugin `imu`."""

from __future__ import annotations

import math

import rospy
from genpy import Time
from geometry_msgs.msg import Quaternion, Vector3
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, Temperature
from std_msgs.msg import Header

from simulation_tools.ned_frames import flu_to_frd
from simulation_tools_ros.mavros.uas import (
    UNKNOWN,
    Heard,
    Uas,
    diagonal,
    number,
    stamp_from_ms,
    stamp_from_us,
)

_TESLA_PER_GAUSS = 1e-4
# The groups of HIGHRES_IMU's fields_updated
_MOTION, _MAGNETIC, _PRESSURE, _DIFFERENTIAL, _TEMPERATURE = 0o77, 0o700, 1 << 9, 1 << 10, 1 << 12


class ImuPlugin:
    """Publishes imu/{data,data_raw,mag,static_pressure,diff_pressure,temperature_imu}.

    Parameters: ~imu/frame_id, ~imu/{linear_acceleration,angular_velocity,orientation,magnetic}_stdev.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._frame_id = rospy.get_param("~imu/frame_id", "base_link")
        self._acceleration_covariance = _covariance("linear_acceleration_stdev", 0.0003)
        self._rate_covariance = _covariance("angular_velocity_stdev", math.radians(0.02))
        self._orientation_covariance = _covariance("orientation_stdev", 1.0)
        self._magnetic_covariance = _covariance("magnetic_stdev", 0.0)
        self._heard: Heard | None = None
        self._acceleration: tuple[float, float, float] | None = None
        self._data = uas.advertise("imu/data", Imu)
        self._raw = uas.advertise("imu/data_raw", Imu)
        self._magnetic = uas.advertise("imu/mag", MagneticField)
        self._pressure = uas.advertise("imu/static_pressure", FluidPressure)
        self._differential = uas.advertise("imu/diff_pressure", FluidPressure)
        self._temperature = uas.advertise("imu/temperature_imu", Temperature)
        uas.client.on("ATTITUDE_QUATERNION", self._on_attitude)
        uas.client.on("HIGHRES_IMU", self._on_highres_imu)

    def _on_attitude(self, message: common.MAVLink_message) -> None:
        self._data.publish(lambda: self._data_message(message))

    def _data_message(self, attitude: common.MAVLink_message) -> Imu:
        """ATTITUDE_QUATERNION and the newest HIGHRES_IMU's acceleration (None: unknown) to Imu."""
        message = Imu(header=self._header(stamp_from_ms(attitude.time_boot_ms)))
        heard = self._uas.heard
        message.orientation = Quaternion(*heard.attitude_or_level)
        message.orientation_covariance = self._orientation_covariance
        message.angular_velocity = Vector3(*heard.rates)
        message.angular_velocity_covariance = self._rate_covariance
        message.linear_acceleration_covariance = self._acceleration_covariance
        if self._acceleration is None or self._heard is not heard:
            message.linear_acceleration_covariance = [-1.0, *self._acceleration_covariance[1:]]
        else:
            message.linear_acceleration = Vector3(*self._acceleration)
        return message

    def _on_highres_imu(self, message: common.MAVLink_message) -> None:
        self._uas.note_time(message.time_usec // 1000)
        fields = message.fields_updated
        header = self._header(stamp_from_us(message.time_usec))
        if fields & _MOTION:
            self._heard = self._uas.heard
            self._acceleration = flu_to_frd((message.xacc, message.yacc, message.zacc))
            self._raw.publish(lambda: self._raw_message(header, message))
        if fields & _MAGNETIC:
            self._magnetic.publish(lambda: self._magnetic_message(header, message))
        if fields & _PRESSURE:  # in Pa, as PX4 sends it
            self._pressure.publish(lambda: FluidPressure(header, message.abs_pressure, 0.0))
        if fields & _DIFFERENTIAL:
            self._differential.publish(lambda: FluidPressure(header, message.diff_pressure, 0.0))
        if fields & _TEMPERATURE:
            self._temperature.publish(lambda: Temperature(header, message.temperature, 0.0))

    def _raw_message(self, header: Header, imu: common.MAVLink_message) -> Imu:
        message = Imu(header=header, orientation_covariance=UNKNOWN)
        message.angular_velocity = Vector3(*flu_to_frd((imu.xgyro, imu.ygyro, imu.zgyro)))
        message.angular_velocity_covariance = self._rate_covariance
        message.linear_acceleration = Vector3(*flu_to_frd((imu.xacc, imu.yacc, imu.zacc)))
        message.linear_acceleration_covariance = self._acceleration_covariance
        return message

    def _magnetic_message(self, header: Header, imu: common.MAVLink_message) -> MagneticField:
        field = (_TESLA_PER_GAUSS * gauss for gauss in flu_to_frd((imu.xmag, imu.ymag, imu.zmag)))
        return MagneticField(header, Vector3(*field), self._magnetic_covariance)

    def _header(self, stamp: Time) -> Header:
        return Header(stamp=stamp, frame_id=self._frame_id)


def _covariance(parameter: str, default: float) -> list[float]:
    """Return the covariance matrix of a standard deviation; 0: unknown."""
    deviation = number(f"~imu/{parameter}", default)
    return diagonal(*[deviation * deviation] * 3) if deviation else UNKNOWN
