"""MAVROS's plugin `global_position`."""

from __future__ import annotations

import math
from typing import Any

import rospy
from genpy import Time
from geographic_msgs.msg import GeoPointStamped
from geometry_msgs.msg import Point, Quaternion, TwistStamped, Vector3
from nav_msgs.msg import Odometry
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import NavSatFix, NavSatStatus
from std_msgs.msg import Float64, Header, UInt32

from simulation_tools.mavros.earth import GeodeticPoint
from simulation_tools_ros.mavros.uas import (
    UNKNOWN,
    Heard,
    Uas,
    diagonal,
    number,
    stamp_from_ms,
    stamp_from_us,
)

_UNKNOWN_U16 = 65535
_FIX_2D = 2
_INT32_MAX = 2**31 - 1


class GlobalPositionPlugin:
    """Publishes global_position/{global,local,rel_alt,compass_hdg,raw/fix,raw/gps_vel,raw/satellites}.

    Publishes gp_origin (latched) when the flight controller sends it. Takes set_gp_origin. Altitudes are
    above the ellipsoid: ~geoid_height more than those of the flight controller. Parameters:
    ~global_position/{frame_id, child_frame_id,rot_covariance,gps_uere,use_relative_alt,tf/global_frame_id}.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._frame_id = _parameter("frame_id", "map")
        self._child_frame_id = _parameter("child_frame_id", "base_link")
        self._earth_frame_id = _parameter("tf/global_frame_id", "earth")
        self._rotation_covariance = number("~global_position/rot_covariance", 99999.0)
        self._range_error_m = number("~global_position/gps_uere", 1.0)
        self._uses_relative_altitude = bool(_parameter("use_relative_alt", True))
        self._heard: Heard | None = None  # belongs to the next two fields
        self._raw: NavSatFix | None = None
        self._origin: GeodeticPoint | None = None  # of the odometry's frame: home, or the first fix
        self._advertise()
        uas.subscribe("global_position/set_gp_origin", GeoPointStamped, self._on_set_origin)
        uas.client.on("GPS_RAW_INT", self._on_raw)
        uas.client.on("GLOBAL_POSITION_INT", self._on_position)
        uas.client.on("GPS_GLOBAL_ORIGIN", self._on_origin)
        uas.client.on("HOME_POSITION", self._on_home)

    def _advertise(self) -> None:
        advertise = self._uas.advertise
        self._fix = advertise("global_position/global", NavSatFix)
        self._odometry = advertise("global_position/local", Odometry)
        self._relative_altitude = advertise("global_position/rel_alt", Float64)
        self._compass = advertise("global_position/compass_hdg", Float64)
        self._raw_fix = advertise("global_position/raw/fix", NavSatFix)
        self._raw_velocity = advertise("global_position/raw/gps_vel", TwistStamped)
        self._satellites = advertise("global_position/raw/satellites", UInt32)
        self._gp_origin = advertise("global_position/gp_origin", GeoPointStamped, latch=True)

    # The receiver

    def _on_raw(self, gps: common.MAVLink_message) -> None:
        self._forget_if_reset()
        self._raw = self._raw_fix_message(gps)
        self._raw_fix.publish(lambda: self._raw)
        if _UNKNOWN_U16 not in (gps.vel, gps.cog):
            self._raw_velocity.publish(lambda: self._raw_velocity_message(gps))
        self._satellites.publish(lambda: UInt32(gps.satellites_visible))

    def _raw_fix_message(self, gps: common.MAVLink_message) -> NavSatFix:
        fix = self._fix_of(gps, stamp_from_us(gps.time_usec))
        fix.status.service = NavSatStatus.SERVICE_GPS
        has_fix = gps.fix_type > _FIX_2D
        fix.status.status = NavSatStatus.STATUS_FIX if has_fix else NavSatStatus.STATUS_NO_FIX
        if gps.h_acc > 0 and gps.v_acc > 0:
            horizontal_m, vertical_m = 1e-3 * gps.h_acc, 1e-3 * gps.v_acc
            fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
        elif _UNKNOWN_U16 not in (gps.eph, gps.epv):
            horizontal_m, vertical_m = (0.01 * dop * self._range_error_m for dop in (gps.eph, gps.epv))
            fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_APPROXIMATED
        else:
            fix.position_covariance = UNKNOWN
            fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_UNKNOWN
            return fix
        fix.position_covariance = diagonal(horizontal_m**2, horizontal_m**2, vertical_m**2)
        return fix

    def _raw_velocity_message(self, gps: common.MAVLink_message) -> TwistStamped:
        """ENU; the receiver sends no vertical speed."""
        speed_m_s, course_rad = 0.01 * gps.vel, math.radians(0.01 * gps.cog)
        twist = TwistStamped(header=Header(stamp=stamp_from_us(gps.time_usec), frame_id=self._frame_id))
        twist.twist.linear.x = speed_m_s * math.sin(course_rad)
        twist.twist.linear.y = speed_m_s * math.cos(course_rad)
        return twist

    # The estimate

    def _on_position(self, position: common.MAVLink_message) -> None:
        self._forget_if_reset()
        if self._fix.wanted or self._odometry.wanted or self._origin is None:
            fix = self._fix_message(position)
            self._fix.publish(lambda: fix)
            place = GeodeticPoint(fix.latitude, fix.longitude, fix.altitude)
            if self._origin is None and fix.status.status >= NavSatStatus.STATUS_FIX:
                self._origin = place
            if self._origin is not None:
                self._odometry.publish(lambda: self._odometry_message(position, fix, place))
        self._relative_altitude.publish(lambda: Float64(1e-3 * position.relative_alt))
        heading = math.nan if position.hdg == _UNKNOWN_U16 else 0.01 * position.hdg
        self._compass.publish(lambda: Float64(heading))

    def _fix_message(self, position: common.MAVLink_message) -> NavSatFix:
        """GLOBAL_POSITION_INT to NavSatFix; status and covariance are the receiver's."""
        fix = self._fix_of(position, stamp_from_ms(position.time_boot_ms))
        if self._raw is None:
            fix.status = NavSatStatus(NavSatStatus.STATUS_NO_FIX, NavSatStatus.SERVICE_GPS)
            fix.position_covariance = UNKNOWN
            fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_UNKNOWN
        else:
            fix.status = self._raw.status
            fix.position_covariance = self._raw.position_covariance
            fix.position_covariance_type = self._raw.position_covariance_type
        return fix

    def _odometry_message(
        self, position: common.MAVLink_message, fix: NavSatFix, place: GeodeticPoint
    ) -> Odometry:
        """From home, ENU; but MAVROS leaves the vertical speed as PX4 sends it, positive downwards."""
        heard = self._uas.heard
        odometry = Odometry(header=Header(stamp=fix.header.stamp, frame_id=self._frame_id))
        odometry.child_frame_id = self._child_frame_id
        east, north, up = (self._origin or place).enu_to(place)
        if self._uses_relative_altitude:
            up = 1e-3 * position.relative_alt
        odometry.pose.pose.position = Point(east, north, up)
        odometry.pose.pose.orientation = Quaternion(*heard.attitude_or_level)
        for row in range(3):
            covariance = fix.position_covariance[3 * row : 3 * row + 3]
            odometry.pose.covariance[6 * row : 6 * row + 3] = covariance
            odometry.pose.covariance[7 * (row + 3)] = self._rotation_covariance
        odometry.twist.twist.linear = Vector3(0.01 * position.vy, 0.01 * position.vx, 0.01 * position.vz)
        odometry.twist.covariance[0] = -1.0
        return odometry

    def _fix_of(self, message: common.MAVLink_message, stamp: Time) -> NavSatFix:
        """Place and altitude of GPS_RAW_INT or GLOBAL_POSITION_INT."""
        return NavSatFix(
            header=Header(stamp=stamp, frame_id=self._child_frame_id),
            latitude=1e-7 * message.lat,
            longitude=1e-7 * message.lon,
            altitude=1e-3 * message.alt + self._uas.geoid_height_m,
        )

    # Origins

    def _on_home(self, home: common.MAVLink_message) -> None:
        self._forget_if_reset()
        height_m = 1e-3 * home.altitude + self._uas.geoid_height_m
        self._origin = GeodeticPoint(1e-7 * home.latitude, 1e-7 * home.longitude, height_m)

    def _on_origin(self, origin: common.MAVLink_message) -> None:
        message = GeoPointStamped(header=Header(stamp=self._uas.now, frame_id=self._earth_frame_id))
        message.position.latitude = 1e-7 * origin.latitude
        message.position.longitude = 1e-7 * origin.longitude
        message.position.altitude = 1e-3 * origin.altitude + self._uas.geoid_height_m
        self._gp_origin.publish(lambda: message)

    def _on_set_origin(self, message: GeoPointStamped) -> None:
        place = message.position
        altitude_mm = 1e3 * (place.altitude - self._uas.geoid_height_m)
        is_place = abs(place.latitude) <= 90.0 and abs(place.longitude) <= 180.0
        if not (is_place and abs(altitude_mm) <= _INT32_MAX):
            rospy.logwarn_throttle(
                1.0, "global_position/set_gp_origin is refused: it is not a place on earth."
            )
            return
        self._uas.client.send(
            common.MAVLink_set_gps_global_origin_message(
                self._uas.client.target.system_id,
                round(1e7 * place.latitude),
                round(1e7 * place.longitude),
                round(altitude_mm),
            )
        )

    def _forget_if_reset(self) -> None:
        if self._heard is not self._uas.heard:
            self._heard = self._uas.heard
            self._raw = self._origin = None


def _parameter(name: str, default: Any) -> Any:
    return rospy.get_param(f"~global_position/{name}", default)
