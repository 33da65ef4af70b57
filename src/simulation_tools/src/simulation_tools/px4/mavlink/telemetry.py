"""The MAVLink messages that PX4 streams: NED and FRD, simulation time."""

from __future__ import annotations

from typing import Callable, Mapping

from pymavlink.dialects.v20 import common

from simulation_tools.px4.mavlink import telemetry_estimator, telemetry_motion, telemetry_state
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.status import Px4Status

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
    "POSITION_TARGET_GLOBAL_INT": 10.0,
    "TIMESYNC": 10.0,
    "ALTITUDE": 10.0,
    "DISTANCE_SENSOR": 10.0,
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

# A ground station's link is slower, because it does not control the flight.
GROUND_RATES_HZ = {name: min(rate, 10.0) for name, rate in OFFBOARD_RATES_HZ.items() if name != "TIMESYNC"}

# PX4 takes an interval for them, and has nothing to send without a remote control, camera, gimbal or radio.
SILENT = frozenset(
    (
        "ADSB_VEHICLE",
        "ATT_POS_MOCAP",
        "CAMERA_IMAGE_CAPTURED",
        "CAMERA_TRIGGER",
        "COLLISION",
        "COMMAND_LONG",
        "DEBUG",
        "DEBUG_FLOAT_ARRAY",
        "DEBUG_VECT",
        "GIMBAL_DEVICE_ATTITUDE_STATUS",
        "GIMBAL_DEVICE_SET_ATTITUDE",
        "GIMBAL_MANAGER_INFORMATION",
        "GIMBAL_MANAGER_STATUS",
        "GPS2_RAW",
        "GPS_STATUS",
        "MANUAL_CONTROL",
        "MOUNT_ORIENTATION",
        "NAMED_VALUE_FLOAT",
        "NAV_CONTROLLER_OUTPUT",
        "OBSTACLE_DISTANCE",
        "OPTICAL_FLOW_RAD",
        "ORBIT_EXECUTION_STATUS",
        "RAW_RPM",
        "RC_CHANNELS",
        "SMART_BATTERY_INFO",
        "STATUSTEXT",
        "TRAJECTORY_REPRESENTATION_WAYPOINTS",
        "WIND_COV",
    )
)

Builder = Callable[[Px4, Px4Status], "common.MAVLink_message | None"]

_BUILDERS: Mapping[str, Builder] = {
    **telemetry_estimator.BUILDERS,
    **telemetry_motion.BUILDERS,
    **telemetry_state.BUILDERS,
}


def build(name: str, px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """Return a message by its MAVLink name; None if it is not possible yet (no position, no home)."""
    return _BUILDERS[name](px4, status)


def can_build(name: str) -> bool:
    """Whether a message of this name is known here."""
    return name in _BUILDERS
