"""Telemetry of the estimator: its covariances, its test ratios, and the height over ground."""

from __future__ import annotations

import math
from typing import Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.geometry import rotate_inverse
from simulation_tools.px4.modes import LandedState
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.status import Px4Status

_CLEARANCE_ON_GROUND_M = 0.1  # PX4's EKF2_MIN_RNG
_ACCELERATION_VARIANCE = 0.05**2  # m2/s4, of the estimated acceleration


def _estimator_status(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    known = px4.estimator_status
    return common.MAVLink_estimator_status_message(
        status.time_us,
        known.flags,
        known.velocity_ratio,
        known.horizontal_position_ratio,
        known.vertical_position_ratio,
        known.magnetometer_ratio,
        known.height_over_ground_ratio,
        known.airspeed_ratio,
        known.horizontal_accuracy_m,
        known.vertical_accuracy_m,
    )


def _local_position_with_covariance(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """Only on request. PX4 does not have this message; MAVROS takes pose_cov and accel from it."""
    if not status.position_valid:
        return None
    estimate, known = px4.estimate[0], px4.estimator_status
    variances = (*known.position_variance_m2, *known.velocity_variance_m2_s2, *(_ACCELERATION_VARIANCE,) * 3)
    return common.MAVLink_local_position_ned_cov_message(
        status.time_us,
        common.MAV_ESTIMATOR_TYPE_AUTOPILOT,
        *estimate["position"].tolist(),
        *estimate["velocity"].tolist(),
        *estimate["acceleration"].tolist(),
        _diagonal(variances, 9),
    )


def _odometry(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """As PX4's: variances along the axes of NED only; 0 for attitude and rates."""
    if not status.position_valid:
        return None
    estimate, known = px4.estimate[0], px4.estimator_status
    attitude = estimate["attitude"].tolist()
    w, x, y, z = attitude
    return common.MAVLink_odometry_message(
        status.time_us,
        common.MAV_FRAME_LOCAL_NED,
        common.MAV_FRAME_BODY_FRD,
        *estimate["position"].tolist(),
        attitude,
        *rotate_inverse((x, y, z, w), estimate["velocity"].tolist()),
        *estimate["rates"].tolist(),
        _diagonal(known.position_variance_m2, 6),
        _diagonal(known.velocity_variance_m2_s2, 6),
        reset_counter=known.resets % 256,
        estimator_type=common.MAV_ESTIMATOR_TYPE_AUTOPILOT,
    )


def _diagonal(variances: Sequence[float], size: int) -> list[float]:
    """Upper triangle, row by row, of a matrix with these first values on its diagonal and zeros elsewhere."""
    padded = (*variances, *(0.0,) * (size - len(variances)))
    return [padded[row] if row == column else 0.0 for row in range(size) for column in range(row, size)]


def _distance(px4: Px4, status: Px4Status) -> common.MAVLink_message | None:
    """Return the range finder's newest range; None without one."""
    sample = px4.newest_range
    if sample is None:
        return None
    lengths = (sample.range_min_m, sample.range_max_m, sample.distance_m)
    return common.MAVLink_distance_sensor_message(
        sample.time_us // 1000 % 2**32,
        *(int(min(max(100.0 * length, 0.0), 65535.0)) if length == length else 0 for length in lengths),
        common.MAV_DISTANCE_SENSOR_LASER,
        0,
        common.MAV_SENSOR_ROTATION_PITCH_270,
        0,
        signal_quality=0 if sample.quality < 0 else 1 + 99 * min(sample.quality, 100) // 100,
    )


def _altitude(px4: Px4, status: Px4Status) -> common.MAVLink_message:
    """Without a range finder PX4 knows the terrain only while it stands on it."""
    local = -float(px4.estimate["position"][0, 2])
    amsl = px4.origin.altitude_m + local
    relative = local + float(px4.home[2]) if px4.home is not None else local
    clearance = px4.estimator_status.height_over_ground_m
    if math.isnan(clearance) and status.landed_state is LandedState.ON_GROUND:
        clearance = _CLEARANCE_ON_GROUND_M
    return common.MAVLink_altitude_message(
        status.time_us, amsl, amsl, local, relative, local - clearance, clearance
    )


BUILDERS = {
    "ESTIMATOR_STATUS": _estimator_status,
    "LOCAL_POSITION_NED_COV": _local_position_with_covariance,
    "ODOMETRY": _odometry,
    "DISTANCE_SENSOR": _distance,
    "ALTITUDE": _altitude,
}
