"""MAVROS's ROS messages out of MAVLink ones (ENU, FLU). Imports message classes only: no node, no rospy."""

from __future__ import annotations

import math
from typing import Sequence

from genpy import Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion, TwistStamped, Vector3
from mavros_msgs.msg import ExtendedState, HomePosition, ParamValue, State, StatusText
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Imu, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from simulation_tools.geometry import Quaternion as QuaternionTuple
from simulation_tools.geometry import rotate_inverse
from simulation_tools.mavlink import decode_text
from simulation_tools.mavros.client import mode_name
from simulation_tools.px4.frames import attitude_to_enu, enu_to_ned, flu_to_frd

_ARMED, _GUIDED, _MANUAL = 128, 8, 64
_UNKNOWN_CELL = 65535


def stamp_from_ms(time_boot_ms: int) -> Time:
    """Return the ROS time of a flight controller whose clock is ROS's."""
    seconds, milliseconds = divmod(int(time_boot_ms), 1000)
    return Time(seconds, 1_000_000 * milliseconds)


def state_message(heartbeat, stamp: Time, connected: bool) -> State:
    """HEARTBEAT (None: never heard) to State."""
    message = State(header=Header(stamp=stamp), connected=connected)
    if heartbeat is not None:
        message.armed = bool(heartbeat.base_mode & _ARMED)
        message.guided = bool(heartbeat.base_mode & _GUIDED)
        message.manual_input = bool(heartbeat.base_mode & _MANUAL)
        message.mode = mode_name(heartbeat.custom_mode)
        message.system_status = heartbeat.system_status
    return message


def extended_state_message(extended, stamp: Time) -> ExtendedState:
    """EXTENDED_SYS_STATE to ExtendedState."""
    return ExtendedState(Header(stamp=stamp), extended.vtol_state, extended.landed_state)


def attitude_of(quaternion) -> QuaternionTuple:
    """ATTITUDE_QUATERNION to the attitude of FLU in ENU, x y z w."""
    return attitude_to_enu((quaternion.q1, quaternion.q2, quaternion.q3, quaternion.q4))


def rates_of(quaternion) -> tuple[float, float, float]:
    """ATTITUDE_QUATERNION to angular velocity, FLU."""
    return flu_to_frd((quaternion.rollspeed, quaternion.pitchspeed, quaternion.yawspeed))


def imu_message(quaternion, highres, frame_id: str) -> Imu:
    """ATTITUDE_QUATERNION and the newest HIGHRES_IMU (None: accelerations unknown) to Imu."""
    message = Imu(header=Header(stamp=stamp_from_ms(quaternion.time_boot_ms), frame_id=frame_id))
    message.orientation = Quaternion(*attitude_of(quaternion))
    message.orientation_covariance = _diagonal(1.0)
    message.angular_velocity = Vector3(*rates_of(quaternion))
    message.angular_velocity_covariance = _diagonal(0.0003**2 * 4.0)
    if highres is None:
        message.linear_acceleration_covariance[0] = -1.0
    else:
        message.linear_acceleration = Vector3(*flu_to_frd((highres.xacc, highres.yacc, highres.zacc)))
        message.linear_acceleration_covariance = _diagonal(0.0003**2)
    return message


def local_position_messages(
    local, attitude: QuaternionTuple, rates: Sequence[float], frame_id: str, child_frame_id: str
) -> tuple[PoseStamped, TwistStamped, TwistStamped, Odometry]:
    """LOCAL_POSITION_NED and the newest attitude to pose, velocity_local, velocity_body and odom."""
    stamp = stamp_from_ms(local.time_boot_ms)
    header = Header(stamp=stamp, frame_id=frame_id)
    pose = PoseStamped(header=header)
    pose.pose.position = Point(*enu_to_ned((local.x, local.y, local.z)))
    pose.pose.orientation = Quaternion(*attitude)

    velocity = enu_to_ned((local.vx, local.vy, local.vz))
    in_local = TwistStamped(header=header)
    in_local.twist.linear = Vector3(*velocity)
    in_local.twist.angular = Vector3(*rates)
    in_body = TwistStamped(header=Header(stamp=stamp, frame_id=child_frame_id))
    in_body.twist.linear = Vector3(*rotate_inverse(attitude, velocity))
    in_body.twist.angular = in_local.twist.angular

    odometry = Odometry(header=header, child_frame_id=child_frame_id)
    odometry.pose.pose = pose.pose
    odometry.twist.twist = in_body.twist
    return pose, in_local, in_body, odometry


def fix_message(position, frame_id: str) -> NavSatFix:
    """GLOBAL_POSITION_INT to NavSatFix.

    The altitude is above mean sea level; MAVROS's own is above the ellipsoid, for which it needs a geoid.
    """
    message = NavSatFix(header=Header(stamp=stamp_from_ms(position.time_boot_ms), frame_id=frame_id))
    message.status.status = NavSatStatus.STATUS_FIX
    message.status.service = NavSatStatus.SERVICE_GPS
    message.latitude, message.longitude = 1e-7 * position.lat, 1e-7 * position.lon
    message.altitude = 1e-3 * position.alt
    return message


def battery_message(status, battery, stamp: Time) -> BatteryState:
    """SYS_STATUS and, for the cells, the newest BATTERY_STATUS (None: unknown) to BatteryState."""
    message = BatteryState(header=Header(stamp=stamp))
    message.voltage = 1e-3 * status.voltage_battery
    message.current = -1e-2 * status.current_battery if status.current_battery >= 0 else math.nan
    message.charge = message.capacity = message.design_capacity = math.nan
    message.percentage = 1e-2 * status.battery_remaining if status.battery_remaining >= 0 else math.nan
    message.power_supply_status = BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
    message.power_supply_technology = BatteryState.POWER_SUPPLY_TECHNOLOGY_LIPO
    message.present = True
    if battery is not None:
        message.cell_voltage = [1e-3 * cell for cell in battery.voltages if cell != _UNKNOWN_CELL]
    return message


def home_message(home) -> HomePosition:
    """HOME_POSITION to HomePosition; its orientation and approach as they are, in ENU."""
    message = HomePosition(header=Header(stamp=stamp_from_ms(home.time_usec // 1000)))
    message.geo.latitude = 1e-7 * home.latitude
    message.geo.longitude = 1e-7 * home.longitude
    message.geo.altitude = 1e-3 * home.altitude
    message.position = Point(*enu_to_ned((home.x, home.y, home.z)))
    message.orientation = Quaternion(*attitude_to_enu(home.q))
    message.approach = Vector3(*enu_to_ned((home.approach_x, home.approach_y, home.approach_z)))
    return message


def status_text_message(text, stamp: Time) -> StatusText:
    """STATUSTEXT to StatusText."""
    return StatusText(Header(stamp=stamp), text.severity, decode_text(text.text))


def param_value_message(value: float) -> ParamValue:
    """Return a parameter's value: an int goes to the integer field, a float to the real one."""
    return ParamValue(integer=value) if isinstance(value, int) else ParamValue(real=value)


def param_value_of(message: ParamValue) -> float:
    """Return the value that a ParamValue stands for, as MAVROS reads it: the integer unless it is zero."""
    if message.integer != 0:
        return int(message.integer)
    return float(message.real) if message.real != 0.0 else 0


def _diagonal(variance: float) -> list[float]:
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
