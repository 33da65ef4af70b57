"""Telemetry of the vehicle's motion and its setpoints: NED and FRD, simulation time."""

from __future__ import annotations

import math

from pymavlink.dialects.v20 import common

from simulation_tools.geometry import rpy_from_quaternion
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.status import Px4Status

_NAN = math.nan
_UNKNOWN_U16 = 65535
# The accuracy of PX4 SITL's receiver: horizontal mm, vertical mm, mm/s, 1e-5 degrees
_GPS_ACCURACIES = (299, 399, 250, 2864788)
_ALL_BUT_AIRSPEED = 7167  # HIGHRES_IMU's fields that are new


def _attitude(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    w, x, y, z = estimate["attitude"].tolist()
    roll, pitch, yaw = rpy_from_quaternion((x, y, z, w))
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
    pressure_pa = 101325.0 * (1.0 - 2.25577e-5 * altitude) ** 5.25588  # international standard atmosphere
    return common.MAVLink_highres_imu_message(
        status.time_us,
        *estimate["specific_force"].tolist(),
        *estimate["rates"].tolist(),
        *_magnetic_field(estimate["attitude"].tolist()),
        pressure_pa,  # MAVLink's unit is hPa, but PX4 sends Pa, and MAVROS passes it on
        0.0,
        altitude,
        20.0,
        _ALL_BUT_AIRSPEED,
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


def _global_position(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if not status.position_valid or px4.home is None or not px4.has_gnss:
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


def _gps_raw(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    if not px4.has_gnss:
        return None
    estimate = px4.estimate[0]
    north, east, down = estimate["position"].tolist()
    vx, vy, _ = estimate["velocity"].tolist()
    latitude, longitude = px4.origin.to_global(north, east)
    altitude_mm = round(1e3 * (px4.origin.altitude_m - down))
    return common.MAVLink_gps_raw_int_message(
        status.time_us,
        common.GPS_FIX_TYPE_3D_FIX,
        round(1e7 * latitude),
        round(1e7 * longitude),
        altitude_mm,
        0,
        0,
        min(round(100.0 * math.hypot(vx, vy)), _UNKNOWN_U16),
        int(100.0 * (math.degrees(math.atan2(vy, vx)) % 360.0)) % 36000,
        10,
        altitude_mm,
        *_GPS_ACCURACIES,
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


def _position_target_global(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """Return an automatic mode's target. PX4 sends it only in those modes."""
    if not (status.mode.is_auto and status.armed and status.position_valid and px4.has_gnss):
        return None
    north, east, down = px4.active_setpoint["position"][0].tolist()
    if math.isnan(north + east + down):
        return None
    latitude, longitude = px4.origin.to_global(north, east)
    return common.MAVLink_position_target_global_int_message(
        status.time_us // 1000,
        common.MAV_FRAME_GLOBAL_INT,
        0,
        round(1e7 * latitude),
        round(1e7 * longitude),
        px4.origin.altitude_m - down,
        *_followed_motion(px4),
    )


def _position_target(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """Return the position controller's setpoint. What it does not follow is NaN and masked."""
    if not px4.follows_position:
        return None
    motion = _followed_motion(px4)
    # A position setpoint gives a velocity setpoint. On the ground PX4 follows none.
    asked = px4.active_setpoint["position"][0].tolist()
    position = [_NAN if math.isnan(speed) else where for where, speed in zip(asked, motion)]
    mask = sum(1 << bit for bit, value in enumerate((*position, *motion[:6])) if math.isnan(value))
    return common.MAVLink_position_target_local_ned_message(
        status.time_us // 1000, common.MAV_FRAME_LOCAL_NED, mask, *position, *motion
    )


def _followed_motion(px4: Px4) -> list[float]:
    """The position controller's setpoints of velocity and acceleration (NED), yaw and yaw rate."""
    target = px4.attitude_setpoint[0]
    return [
        *target["velocity"].tolist(),
        *target["acceleration"].tolist(),
        float(target["yaw"]),
        float(target["yaw_rate"]),
    ]


def _vfr_hud(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    estimate = px4.estimate[0]
    vx, vy, vz = estimate["velocity"].tolist()
    speed = math.hypot(vx, vy)
    heading = int(math.degrees(float(estimate["yaw"])) % 360.0)
    throttle = round(100.0 * float(px4.attitude_setpoint["thrust"][0])) if status.armed else 0
    altitude = px4.origin.altitude_m - float(estimate["position"][2])
    airspeed = 0.0  # without a sensor for it
    return common.MAVLink_vfr_hud_message(airspeed, speed, heading, throttle, altitude, -vz)


def _int16(value: float) -> int:
    return max(-32768, min(32767, round(value)))


BUILDERS = {
    "ATTITUDE": _attitude,
    "ATTITUDE_QUATERNION": _attitude_quaternion,
    "HIGHRES_IMU": _highres_imu,
    "GLOBAL_POSITION_INT": _global_position,
    "LOCAL_POSITION_NED": _local_position,
    "GPS_RAW_INT": _gps_raw,
    "ATTITUDE_TARGET": _attitude_target,
    "POSITION_TARGET_LOCAL_NED": _position_target,
    "POSITION_TARGET_GLOBAL_INT": _position_target_global,
    "VFR_HUD": _vfr_hud,
}
