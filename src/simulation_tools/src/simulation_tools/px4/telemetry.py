"""The MAVLink messages that PX4 streams: NED and FRD, simulation time."""

from __future__ import annotations

import math
from typing import Callable

from pymavlink.dialects.v20 import common

from simulation_tools.px4.modes import ARMED_FLAG
from simulation_tools.px4.px4 import Px4, Px4Status

# Default rates, Hz, as measured on PX4's offboard link.
OFFBOARD_RATES_HZ = {
    "ATTITUDE": 100.0,
    "ATTITUDE_QUATERNION": 50.0,
    "HIGHRES_IMU": 50.0,
    "GLOBAL_POSITION_INT": 50.0,
    "LOCAL_POSITION_NED": 30.0,
    "ODOMETRY": 30.0,
    "GPS_RAW_INT": 19.0,
    "ATTITUDE_TARGET": 10.0,
    "POSITION_TARGET_LOCAL_NED": 10.0,
    "TIMESYNC": 10.0,
    "ALTITUDE": 10.0,
    "VFR_HUD": 10.0,
    "SERVO_OUTPUT_RAW": 10.0,
    "SYS_STATUS": 5.0,
    "EXTENDED_SYS_STATE": 5.0,
    "HEARTBEAT": 1.0,
    "SYSTEM_TIME": 1.0,
    "ESTIMATOR_STATUS": 1.0,
    "HOME_POSITION": 0.5,
    "BATTERY_STATUS": 0.5,
}

# A ground station's link is slower; nothing on it steers.
GROUND_RATES_HZ = {name: min(rate, 10.0) for name, rate in OFFBOARD_RATES_HZ.items() if name != "TIMESYNC"}

_NAN = math.nan
_UNKNOWN_U16 = 65535
_CELLS, _CELL_FULL_V, _CELL_EMPTY_V = 4, 4.05, 3.7  # PX4's simulated battery

Builder = Callable[[Px4, Px4Status], "common.MAVLink_message | None"]


def build(name: str, px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """Return a message by its MAVLink name; None when there is nothing to say yet (no position, no home)."""
    return _BUILDERS[name](px4, status)


def can_build(name: str) -> bool:
    """Whether a message of that name is known here."""
    return name in _BUILDERS


def _euler(q: list[float]) -> tuple[float, float, float]:
    w, x, y, z = q
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(1.0, max(-1.0, 2.0 * (w * y - z * x))))
    return roll, pitch, math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _heartbeat(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_heartbeat_message(
        type=int(px4.parameters["MAV_TYPE"]),
        autopilot=common.MAV_AUTOPILOT_PX4,
        base_mode=status.mode.base_mode | (ARMED_FLAG if status.armed else 0),
        custom_mode=status.mode.custom_mode,
        system_status=status.system_status,
        mavlink_version=3,
    )


def _attitude(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    roll, pitch, yaw = _euler(estimate["attitude"].tolist())
    return common.MAVLink_attitude_message(
        status.time_us // 1000, roll, pitch, yaw, *estimate["rates"].tolist()
    )


def _attitude_quaternion(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    return common.MAVLink_attitude_quaternion_message(
        status.time_us // 1000, *estimate["attitude"].tolist(), *estimate["rates"].tolist()
    )


def _highres_imu(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    altitude = px4.origin.altitude_m - float(estimate["position"][2])
    pressure_hpa = 1013.25 * (1.0 - 2.25577e-5 * altitude) ** 5.25588  # international standard atmosphere
    return common.MAVLink_highres_imu_message(
        status.time_us,
        *estimate["specific_force"].tolist(),
        *estimate["rates"].tolist(),
        *_magnetic_field(estimate["attitude"].tolist()),
        pressure_hpa,
        0.0,
        altitude,
        20.0,
        7167,
    )


def _magnetic_field(q: list[float]) -> tuple[float, float, float]:
    """Zurich's field (gauss, NED) in the body's frame."""
    north, east, down = 0.2144, 0.0105, 0.4269
    w, x, y, z = q
    return (
        (1 - 2 * (y * y + z * z)) * north + 2 * (x * y + w * z) * east + 2 * (x * z - w * y) * down,
        2 * (x * y - w * z) * north + (1 - 2 * (x * x + z * z)) * east + 2 * (y * z + w * x) * down,
        2 * (x * z + w * y) * north + 2 * (y * z - w * x) * east + (1 - 2 * (x * x + y * y)) * down,
    )


def _local_position(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if not status.position_valid:
        return None
    estimate = px4.estimate[0]
    return common.MAVLink_local_position_ned_message(
        status.time_us // 1000, *estimate["position"].tolist(), *estimate["velocity"].tolist()
    )


def _odometry(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if not status.position_valid:
        return None
    estimate = px4.estimate[0]
    attitude = estimate["attitude"].tolist()
    return common.MAVLink_odometry_message(
        status.time_us,
        common.MAV_FRAME_LOCAL_NED,
        common.MAV_FRAME_BODY_FRD,
        *estimate["position"].tolist(),
        attitude,
        *_to_body(attitude, estimate["velocity"].tolist()),
        *estimate["rates"].tolist(),
        [_NAN] * 21,
        [_NAN] * 21,
        estimator_type=common.MAV_ESTIMATOR_TYPE_AUTOPILOT,
    )


def _to_body(q: list[float], v: list[float]) -> tuple[float, float, float]:
    w, x, y, z = q[0], -q[1], -q[2], -q[3]
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


def _global_position(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if not status.position_valid or px4.home is None:
        return None
    estimate = px4.estimate[0]
    north, east, down = estimate["position"].tolist()
    latitude, longitude = px4.origin.to_global(north, east)
    heading = math.degrees(float(estimate["yaw"])) % 360.0
    return common.MAVLink_global_position_int_message(
        status.time_us // 1000,
        round(1e7 * latitude),
        round(1e7 * longitude),
        round(1e3 * (px4.origin.altitude_m - down)),
        round(1e3 * (float(px4.home[2]) - down)),
        *(_int16(100.0 * v) for v in estimate["velocity"].tolist()),
        int(100.0 * heading) % 36000,
    )


def _gps_raw(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    north, east, down = estimate["position"].tolist()
    vx, vy, _ = estimate["velocity"].tolist()
    latitude, longitude = px4.origin.to_global(north, east)
    return common.MAVLink_gps_raw_int_message(
        status.time_us,
        common.GPS_FIX_TYPE_3D_FIX,
        round(1e7 * latitude),
        round(1e7 * longitude),
        round(1e3 * (px4.origin.altitude_m - down)),
        90,
        90,
        min(round(100.0 * math.hypot(vx, vy)), _UNKNOWN_U16),
        int(100.0 * (math.degrees(math.atan2(vy, vx)) % 360.0)) % 36000,
        10,
    )


def _attitude_target(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    target = px4.attitude_setpoint[0]
    return common.MAVLink_attitude_target_message(
        status.time_us // 1000,
        0,
        target["attitude"].tolist(),
        *px4.rates_setpoint.tolist(),
        float(target["thrust"]),
    )


def _position_target(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    asked, target = px4.active_setpoint[0], px4.attitude_setpoint[0]
    return common.MAVLink_position_target_local_ned_message(
        status.time_us // 1000,
        common.MAV_FRAME_LOCAL_NED,
        0,
        *asked["position"].tolist(),
        *target["velocity"].tolist(),
        *target["acceleration"].tolist(),
        float(target["yaw"]),
        float(target["yaw_rate"]),
    )


def _altitude(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    local = -float(px4.estimate["position"][0, 2])
    amsl = px4.origin.altitude_m + local
    relative = local + float(px4.home[2]) if px4.home is not None else _NAN
    return common.MAVLink_altitude_message(status.time_us, amsl, amsl, local, relative, _NAN, relative)


def _vfr_hud(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    vx, vy, vz = estimate["velocity"].tolist()
    speed = math.hypot(vx, vy)
    heading = int(math.degrees(float(estimate["yaw"])) % 360.0)
    throttle = round(100.0 * float(px4.attitude_setpoint["thrust"][0])) if status.armed else 0
    altitude = px4.origin.altitude_m - float(estimate["position"][2])
    return common.MAVLink_vfr_hud_message(speed, speed, heading, throttle, altitude, -vz)


def _servo_output(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    pulses = [round(1000.0 + 1000.0 * u) if status.armed else 900 for u in px4.commands.tolist()]
    return common.MAVLink_servo_output_raw_message(status.time_us % 2**32, 0, *pulses, 0, 0, 0, 0)


def _battery_voltage(status: Px4Status) -> float:
    return _CELL_EMPTY_V + (_CELL_FULL_V - _CELL_EMPTY_V) * status.battery_remaining


def _sys_status(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    sensors = 0x0120002F  # gyro, accelerometer, magnetometer, pressure, GPS; battery, AHRS
    return common.MAVLink_sys_status_message(
        sensors,
        sensors,
        sensors,
        100,
        round(1000.0 * _CELLS * _battery_voltage(status)),
        -1,
        round(100.0 * status.battery_remaining),
        0,
        0,
        0,
        0,
        0,
        0,
    )


def _battery_status(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    cells = [round(1000.0 * _battery_voltage(status))] * _CELLS + [_UNKNOWN_U16] * (10 - _CELLS)
    return common.MAVLink_battery_status_message(
        0,
        common.MAV_BATTERY_FUNCTION_ALL,
        common.MAV_BATTERY_TYPE_LIPO,
        32767,
        cells,
        -1,
        -1,
        -1,
        round(100.0 * status.battery_remaining),
    )


def _extended_sys_state(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_extended_sys_state_message(
        common.MAV_VTOL_STATE_UNDEFINED, int(status.landed_state)
    )


def _system_time(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_system_time_message(0, status.time_us // 1000)


def _estimator_status(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    flags = 831 if status.position_valid else 1  # attitude, velocity and position, absolute and relative
    return common.MAVLink_estimator_status_message(
        status.time_us, flags, 0.01, 0.01, 0.01, 0.01, 0.0, 0.0, 0.3, 0.3
    )


def _home_position(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if px4.home is None:
        return None
    north, east, down = px4.home.tolist()
    latitude, longitude = px4.origin.to_global(north, east)
    return common.MAVLink_home_position_message(
        round(1e7 * latitude),
        round(1e7 * longitude),
        round(1e3 * (px4.origin.altitude_m - down)),
        north,
        east,
        down,
        [1.0, 0.0, 0.0, 0.0],
        0.0,
        0.0,
        0.0,
        status.time_us,
    )


def _timesync(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_timesync_message(0, 1000 * status.time_us)


def _autopilot_version(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    capabilities = (
        common.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
        | common.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | common.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
        | common.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | common.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    )
    version = 1 << 24 | 12 << 16  # 1.12.0 development: the master of July 2021
    return common.MAVLink_autopilot_version_message(
        capabilities, version, version, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0
    )


def _int16(value: float) -> int:
    return max(-32768, min(32767, round(value)))


_BUILDERS: dict[str, Builder] = {
    "HEARTBEAT": _heartbeat,
    "ATTITUDE": _attitude,
    "ATTITUDE_QUATERNION": _attitude_quaternion,
    "HIGHRES_IMU": _highres_imu,
    "GLOBAL_POSITION_INT": _global_position,
    "LOCAL_POSITION_NED": _local_position,
    "ODOMETRY": _odometry,
    "GPS_RAW_INT": _gps_raw,
    "ATTITUDE_TARGET": _attitude_target,
    "POSITION_TARGET_LOCAL_NED": _position_target,
    "TIMESYNC": _timesync,
    "ALTITUDE": _altitude,
    "VFR_HUD": _vfr_hud,
    "SERVO_OUTPUT_RAW": _servo_output,
    "SYS_STATUS": _sys_status,
    "EXTENDED_SYS_STATE": _extended_sys_state,
    "SYSTEM_TIME": _system_time,
    "ESTIMATOR_STATUS": _estimator_status,
    "HOME_POSITION": _home_position,
    "BATTERY_STATUS": _battery_status,
    "AUTOPILOT_VERSION": _autopilot_version,
}
