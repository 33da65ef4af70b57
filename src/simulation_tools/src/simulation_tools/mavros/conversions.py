"""MAVROS's conversions from ROS (ENU, FLU) to MAVLink (NED, FRD): setpoints become messages here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools.geometry import Quaternion, Vector3, yaw_from_quaternion
from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned, flu_to_frd, yaw_to_ned

BODY_FRAMES = frozenset((common.MAV_FRAME_BODY_NED, common.MAV_FRAME_BODY_OFFSET_NED))
LOCAL_FRAMES = frozenset((common.MAV_FRAME_LOCAL_NED, common.MAV_FRAME_LOCAL_OFFSET_NED))

IGNORE_POSITION = 0b111
IGNORE_VELOCITY = 0b111 << 3
IGNORE_ACCELERATION = 0b111 << 6
FORCE = 1 << 9
IGNORE_YAW = 1 << 10
IGNORE_YAW_RATE = 1 << 11

ATTITUDE_IGNORE_RATES = 0b111
ATTITUDE_IGNORE_ATTITUDE = 1 << 7

_ZERO: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Target:
    """The flight controller that messages are for."""

    system_id: int = 1
    component_id: int = 1


DEFAULT_TARGET = Target()


def position_target(
    target: Target,
    time_boot_ms: int,
    frame: int,
    type_mask: int,
    position: Sequence[float] = _ZERO,
    velocity: Sequence[float] = _ZERO,
    acceleration: Sequence[float] = _ZERO,
    yaw: float = 0.0,
    yaw_rate: float = 0.0,
) -> common.MAVLink_message:
    """Build SET_POSITION_TARGET_LOCAL_NED from ENU values, or FLU ones for the body frames.

    Raises ValueError, one sentence, for an unknown frame and for values that are not finite as float32. A
    masked value is sent as zero.
    """
    if frame not in BODY_FRAMES | LOCAL_FRAMES:
        raise ValueError(f"the coordinate frame {frame} is none of 1, 7, 8 and 9")
    position = position if type_mask & IGNORE_POSITION != IGNORE_POSITION else _ZERO
    velocity = velocity if type_mask & IGNORE_VELOCITY != IGNORE_VELOCITY else _ZERO
    acceleration = acceleration if type_mask & IGNORE_ACCELERATION != IGNORE_ACCELERATION else _ZERO
    yaw = 0.0 if type_mask & IGNORE_YAW else yaw
    yaw_rate = 0.0 if type_mask & IGNORE_YAW_RATE else yaw_rate
    require_finite((*position, *velocity, *acceleration, yaw, yaw_rate))
    turn = flu_to_frd if frame in BODY_FRAMES else enu_to_ned
    return common.MAVLink_set_position_target_local_ned_message(
        time_boot_ms % 2**32,
        target.system_id,
        target.component_id,
        frame,
        type_mask,
        *turn(position),
        *turn(velocity),
        *turn(acceleration),
        -yaw if frame in BODY_FRAMES else yaw_to_ned(yaw),
        -yaw_rate,
    )


def pose_target(
    target: Target,
    time_boot_ms: int,
    position: Sequence[float],
    orientation_xyzw: Quaternion,
    frame: int = common.MAV_FRAME_LOCAL_NED,
) -> common.MAVLink_message:
    """Build the setpoint of a pose in ENU (FLU for the body frames): position and heading.

    A quaternion of zeros, the default of a message, means east: MAVROS reads it as no rotation.
    """
    require_finite((*position, *orientation_xyzw))
    mask = IGNORE_VELOCITY | IGNORE_ACCELERATION | IGNORE_YAW_RATE
    yaw = yaw_from_quaternion(orientation_xyzw)
    return position_target(target, time_boot_ms, frame, mask, position=position, yaw=yaw)


def global_target(
    target: Target,
    time_boot_ms: int,
    frame: int,
    type_mask: int,
    place: Sequence[float],
    velocity: Sequence[float] = _ZERO,
    acceleration: Sequence[float] = _ZERO,
    yaw: float = 0.0,
    yaw_rate: float = 0.0,
) -> common.MAVLink_message:
    """Build SET_POSITION_TARGET_GLOBAL_INT; velocity, acceleration, yaw and its rate: ENU.

    place: latitude and longitude, degrees, and altitude, m, over what the frame says. Raises ValueError, one
    sentence, for a place that is not on earth and for values that are not finite as float32.
    """
    latitude, longitude, altitude = place if type_mask & IGNORE_POSITION != IGNORE_POSITION else _ZERO
    velocity = velocity if type_mask & IGNORE_VELOCITY != IGNORE_VELOCITY else _ZERO
    acceleration = acceleration if type_mask & IGNORE_ACCELERATION != IGNORE_ACCELERATION else _ZERO
    yaw = 0.0 if type_mask & IGNORE_YAW else yaw
    yaw_rate = 0.0 if type_mask & IGNORE_YAW_RATE else yaw_rate
    require_finite((altitude, *velocity, *acceleration, yaw, yaw_rate))
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):  # false for NaN, too
        raise ValueError(f"latitude {latitude}, longitude {longitude} is not a place on earth")
    return common.MAVLink_set_position_target_global_int_message(
        time_boot_ms % 2**32,
        target.system_id,
        target.component_id,
        frame,
        type_mask,
        round(1e7 * latitude),
        round(1e7 * longitude),
        altitude,
        *enu_to_ned(velocity),
        *enu_to_ned(acceleration),
        yaw_to_ned(yaw),
        -yaw_rate,
    )


def global_pose_target(
    target: Target, time_boot_ms: int, place: Sequence[float], orientation_xyzw: Sequence[float]
) -> common.MAVLink_message:
    """Build the setpoint of a pose on earth, altitude above mean sea level: place and heading.

    Here MAVROS reads a quaternion of zeros as north.
    """
    require_finite(orientation_xyzw)
    w, x, y, z = attitude_to_ned(orientation_xyzw)
    yaw_ned = math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    mask = IGNORE_VELOCITY | IGNORE_ACCELERATION
    frame = common.MAV_FRAME_GLOBAL_INT
    return global_target(target, time_boot_ms, frame, mask, place, yaw=yaw_to_ned(yaw_ned))


def acceleration_target(
    target: Target, time_boot_ms: int, acceleration_enu: Sequence[float], is_force: bool = False
) -> common.MAVLink_message:
    """Build the setpoint of an acceleration, or of a force, in ENU."""
    mask = IGNORE_POSITION | IGNORE_VELOCITY | IGNORE_YAW | IGNORE_YAW_RATE | (FORCE if is_force else 0)
    frame = common.MAV_FRAME_LOCAL_NED
    return position_target(target, time_boot_ms, frame, mask, acceleration=acceleration_enu)


def velocity_target(
    target: Target, time_boot_ms: int, frame: int, linear: Sequence[float], yaw_rate: float
) -> common.MAVLink_message:
    """Build the setpoint of a velocity (ENU or FLU, by frame) and a yaw rate."""
    mask = IGNORE_POSITION | IGNORE_ACCELERATION | IGNORE_YAW
    return position_target(target, time_boot_ms, frame, mask, velocity=linear, yaw_rate=yaw_rate)


def attitude_target(
    target: Target,
    time_boot_ms: int,
    type_mask: int,
    orientation_xyzw: Quaternion,
    body_rate_flu: Vector3,
    thrust: float,
    lowest_thrust: float = 0.0,
) -> common.MAVLink_message:
    """Build SET_ATTITUDE_TARGET from the attitude of FLU in ENU and rates in FLU; raises ValueError.

    The thrust is cut to lowest_thrust..1.
    """
    if type_mask & ATTITUDE_IGNORE_ATTITUDE:
        orientation_xyzw = (0.0, 0.0, 0.0, 1.0)
    if type_mask & ATTITUDE_IGNORE_RATES == ATTITUDE_IGNORE_RATES:
        body_rate_flu = _ZERO
    require_finite((*orientation_xyzw, *body_rate_flu, thrust))
    return common.MAVLink_set_attitude_target_message(
        time_boot_ms % 2**32,
        target.system_id,
        target.component_id,
        type_mask,
        attitude_to_ned(orientation_xyzw),
        *flu_to_frd(body_rate_flu),
        min(max(thrust, lowest_thrust), 1.0),
    )


def require_finite(values: Sequence[float]) -> None:
    """Raise ValueError if a value is NaN, infinite, or too large for MAVLink."""
    if not fit_float32(values):
        raise ValueError("it holds NaN, infinity or a number beyond 3.4e38")
