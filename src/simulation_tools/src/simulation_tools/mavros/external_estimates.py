"""MAVROS's conversions of external estimates: poses, velocities and odometry from ROS to MAVLink and back.

ROS: ENU and FLU, quaternions (x, y, z, w), covariances row by row. MAVLink: NED and FRD, quaternions (w, x,
y, z), covariances as upper triangles. NaN is passed on: the flight controller decides what it means.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools.geometry import Quaternion, Vector3, rpy_from_quaternion
from simulation_tools.ned_frames import (
    attitude_to_enu,
    attitude_to_ned,
    covariance_to_frd,
    covariance_to_ned,
    enu_to_ned,
    flu_to_frd,
)

UNKNOWN_6X6 = (0.0,) * 36
"""What MAVROS sends for a pose without covariance."""
UNKNOWN_3X3 = (0.0,) * 9
_TRIANGLE = tuple(6 * row + column for row in range(6) for column in range(row, 6))


class Motion(NamedTuple):
    """A nav_msgs/Odometry in plain numbers: pose and its covariance in ENU, velocities in FLU.

    Covariances: 6 x 6, row by row: x, y, z and the turns about them.
    """

    position: Vector3
    orientation_xyzw: Quaternion
    pose_covariance: Sequence[float]
    linear: Vector3
    angular: Vector3
    twist_covariance: Sequence[float]


def pose_estimate(
    time_us: int,
    position: Sequence[float],
    orientation_xyzw: Sequence[float],
    covariance: Sequence[float] = UNKNOWN_6X6,
) -> common.MAVLink_message:
    """Build VISION_POSITION_ESTIMATE from a pose in ENU; covariance: 6 x 6.

    Raises ValueError, one sentence, for a number beyond float32.
    """
    _require_float32((*position, *orientation_xyzw, *covariance))
    w, x, y, z = attitude_to_ned(_unit(orientation_xyzw))
    return common.MAVLink_vision_position_estimate_message(
        time_us,
        *enu_to_ned(position),
        *rpy_from_quaternion((x, y, z, w)),
        _triangle_of(covariance_to_ned(covariance)),
    )


def speed_estimate(
    time_us: int, velocity: Sequence[float], covariance: Sequence[float] = UNKNOWN_3X3
) -> common.MAVLink_message:
    """Build VISION_SPEED_ESTIMATE from a velocity in ENU; covariance: 3 x 3.

    Raises ValueError, one sentence, for a number beyond float32.
    """
    _require_float32((*velocity, *covariance))
    return common.MAVLink_vision_speed_estimate_message(
        time_us, *enu_to_ned(velocity), covariance_to_ned(covariance)
    )


def odometry_estimate(time_us: int, motion: Motion) -> common.MAVLink_message:
    """Build ODOMETRY, as MAVROS does in the frames LOCAL_FRD and BODY_FRD.

    Raises ValueError, one sentence, for a number beyond float32.
    """
    for numbers in motion:
        _require_float32(numbers)
    return common.MAVLink_odometry_message(
        time_us,
        common.MAV_FRAME_LOCAL_FRD,
        common.MAV_FRAME_BODY_FRD,
        *enu_to_ned(motion.position),
        attitude_to_ned(_unit(motion.orientation_xyzw)),
        *flu_to_frd(motion.linear),
        *flu_to_frd(motion.angular),
        _triangle_of(covariance_to_ned(motion.pose_covariance)),
        _triangle_of(covariance_to_frd(motion.twist_covariance)),
        estimator_type=common.MAV_ESTIMATOR_TYPE_VISION,
    )


def motion_of(message: common.MAVLink_message) -> Motion:
    """Read ODOMETRY, whose frames MAVROS takes for NED and FRD."""
    return Motion(
        enu_to_ned((message.x, message.y, message.z)),
        attitude_to_enu(message.q),
        covariance_to_ned(_matrix_of(message.pose_covariance)),
        flu_to_frd((message.vx, message.vy, message.vz)),
        flu_to_frd((message.rollspeed, message.pitchspeed, message.yawspeed)),
        covariance_to_frd(_matrix_of(message.velocity_covariance)),
    )


def _unit(orientation_xyzw: Sequence[float]) -> Sequence[float]:
    """Scale a quaternion to length 1. MAVROS takes zeros, a message's default, for no rotation."""
    length = math.sqrt(sum(component * component for component in orientation_xyzw))
    return [component / length for component in orientation_xyzw] if length else (0.0, 0.0, 0.0, 1.0)


def _triangle_of(matrix: Sequence[float]) -> list[float]:
    return [matrix[index] for index in _TRIANGLE]


def _matrix_of(triangle: Sequence[float]) -> list[float]:
    matrix = [0.0] * 36
    for index, value in zip(_TRIANGLE, triangle):
        row, column = divmod(index, 6)
        matrix[index] = matrix[6 * column + row] = value
    return matrix


def _require_float32(values: Sequence[float]) -> None:
    if not fit_float32(filter(math.isfinite, values)):
        raise ValueError("it holds a number beyond 3.4e38")
