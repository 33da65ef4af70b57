"""Telemetry of the flight controller's own state: mode, arming, battery, home, versions."""

from __future__ import annotations

from pymavlink.dialects.v20 import common

from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.safety.battery import ChargeLevel
from simulation_tools.px4.status import Px4Status

_UNKNOWN_U16 = 65535
_UNKNOWN_I16 = 32767
_CHARGE_STATES = {
    ChargeLevel.NONE: common.MAV_BATTERY_CHARGE_STATE_OK,
    ChargeLevel.LOW: common.MAV_BATTERY_CHARGE_STATE_LOW,
    ChargeLevel.CRITICAL: common.MAV_BATTERY_CHARGE_STATE_CRITICAL,
    ChargeLevel.EMERGENCY: common.MAV_BATTERY_CHARGE_STATE_EMERGENCY,
}
_UTC_AT_START_US = 1_625_097_600_000_000  # 2021-07-01: the simulated world's date, the same in each flight

_SENSORS = 0x0020000B  # gyro, accelerometer, pressure, AHRS
_MAGNETOMETER, _GPS, _VISION = 0x04, 0x20, 0x80
_ARMING_CHECKS = 0x10000000  # MAV_SYS_STATUS_PREARM_CHECK: MAVSDK takes it for "is armable"


def _heartbeat(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_heartbeat_message(
        type=int(px4.parameters["MAV_TYPE"]),
        autopilot=common.MAV_AUTOPILOT_PX4,
        base_mode=status.base_mode,
        custom_mode=status.mode.custom_mode,
        system_status=status.system_status,
        mavlink_version=3,
    )


def _servo_output(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    pulses = [round(1000.0 + 1000.0 * u) if status.armed else 900 for u in px4.commands.tolist()]
    return common.MAVLink_servo_output_raw_message(status.time_us % 2**32, 0, *pulses, 0, 0, 0, 0)


def _sys_status(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    may_arm = _ARMING_CHECKS if status.position_valid else 0
    sensors = _SENSORS | (_GPS if px4.has_gnss else _VISION)
    if px4.parameters["SYS_HAS_MAG"] == 1:
        sensors |= _MAGNETOMETER
    return common.MAVLink_sys_status_message(
        sensors | _ARMING_CHECKS,
        sensors | _ARMING_CHECKS,
        sensors | may_arm,
        100,
        round(1e3 * status.battery.voltage_v),
        round(1e2 * status.battery.current_a),
        round(1e2 * status.battery.remaining),
        0,
        0,
        0,
        0,
        0,
        0,
    )


def _battery_status(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    battery = status.battery
    left_s, warmth_c = battery.time_remaining_s, battery.temperature_c
    cells = [round(1e3 * battery.voltage_v / battery.cells)] * battery.cells
    return common.MAVLink_battery_status_message(
        id=0,
        battery_function=common.MAV_BATTERY_FUNCTION_ALL,
        type=common.MAV_BATTERY_TYPE_LIPO,
        temperature=_UNKNOWN_I16 if warmth_c is None else round(1e2 * warmth_c),
        voltages=cells + [_UNKNOWN_U16] * (10 - battery.cells),
        current_battery=round(1e2 * battery.current_a),
        current_consumed=round(battery.consumed_mah),
        energy_consumed=-1,
        battery_remaining=round(1e2 * battery.remaining),
        time_remaining=0 if left_s is None else max(1, round(left_s)),
        charge_state=_CHARGE_STATES[status.battery_level],
    )


def _extended_sys_state(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_extended_sys_state_message(
        common.MAV_VTOL_STATE_UNDEFINED, int(status.landed_state)
    )


def _system_time(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    return common.MAVLink_system_time_message(_UTC_AT_START_US + status.time_us, status.time_us // 1000)


def _home_position(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if px4.home is None or not px4.has_gnss:
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
        | common.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
        | common.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | common.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | common.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | common.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
        | common.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    )
    version = 1 << 24 | 12 << 16  # 1.12.0 development: the master of July 2021
    return common.MAVLink_autopilot_version_message(
        capabilities, version, version, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0
    )


def _gps_global_origin(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if not (status.position_valid and px4.has_gnss):
        return None
    origin = px4.origin
    return common.MAVLink_gps_global_origin_message(
        round(1e7 * origin.latitude_deg),
        round(1e7 * origin.longitude_deg),
        round(1e3 * origin.altitude_m),
        status.time_us,
    )


def _flight_information(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    since_us = px4.armed_since_us or 0
    return common.MAVLink_flight_information_message(status.time_us // 1000, since_us, since_us, 0)


BUILDERS = {
    "HEARTBEAT": _heartbeat,
    "TIMESYNC": _timesync,
    "SERVO_OUTPUT_RAW": _servo_output,
    "SYS_STATUS": _sys_status,
    "EXTENDED_SYS_STATE": _extended_sys_state,
    "SYSTEM_TIME": _system_time,
    "HOME_POSITION": _home_position,
    "BATTERY_STATUS": _battery_status,
    "AUTOPILOT_VERSION": _autopilot_version,
    "FLIGHT_INFORMATION": _flight_information,
    "GPS_GLOBAL_ORIGIN": _gps_global_origin,
}
