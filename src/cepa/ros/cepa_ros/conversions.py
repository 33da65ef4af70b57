"""Between messages and the library's types; every fault of a message becomes one sentence."""

from __future__ import annotations

import dataclasses
import math
from typing import Callable

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import Imu, PointCloud2, PointField
from sensor_msgs.msg import LaserScan as LaserScanMessage
from std_msgs.msg import Header

from cepa import Decision, LaserScan2D, MotionError, MountError, Reason, ScanError, VelocityError
from cepa.algorithm import GREATEST_SPEED_M_S
from cepa.dynamic.constants.choice import HELD_S
from cepa.dynamic.report import Report, View
from cepa.motion import rotation_matrix
from cepa.steering.inertial_path import NOT_MEASURED, InertialReading
from cepa.steering.mount import Mount
from cepa.steering.own_motion import OwnState
from input_checks_ros.lidar_readings import UNSEEN_INTENSITY
from node_tools.conversions import xyz, xyzw

MOST_STEPS_BEHIND = 1.99
"""Steps of a scan from its last beam to angle_max: fewer than two, less what rounding to 32 bits adds."""


def own_state_of(
    odometry: OdometryMessage, base_frame: str, mount_of: Callable[[str], Mount]
) -> tuple[OwnState, str]:
    """Return a nav_msgs/Odometry's state, and what is wrong with its velocity (empty: nothing).

    The twist is along the axes of child_frame_id, whatever frame that is; none means the body's. mount_of:
    returns how a frame sits on the body, or raises MountError.
    """
    pose, complaint = odometry.pose.pose, ""
    child, parent = odometry.child_frame_id.lstrip("/"), odometry.header.frame_id.lstrip("/")
    is_told_in_odometry = child == parent != ""
    velocity = None
    try:
        velocity = velocity_of(odometry.twist.twist, "odometry's velocity")
        if child not in ("", base_frame, parent):
            x, y, z = (rotation_matrix(mount_of(child).orientation_xyzw) @ velocity).tolist()
            velocity = x, y, z
    except VelocityError as error:
        complaint = f"{error} The own speed counts as zero."
    except MountError as error:
        complaint = f"{error} The odometry's velocity (twist) is taken along the axes of {base_frame}. "
        complaint += "Publish that transform, or let its source tell child_frame_id of the body."
    state = OwnState(velocity, xyz(pose.position), xyzw(pose.orientation), is_told_in_odometry)
    return state, complaint


def scan_of(message: LaserScanMessage) -> LaserScan2D:
    """Return a sensor_msgs/LaserScan as the library's type.

    Raises:
        ScanError: it makes no sense, or holds no valid reading at all.
    """
    intensities = np.asarray(message.intensities)
    if intensities.size not in (0, len(message.ranges)):
        raise ScanError(
            f"The scan has {intensities.size} intensities for {len(message.ranges)} ranges; "
            "give none or as many."
        )
    seen = intensities != UNSEEN_INTENSITY if intensities.size else None
    geometry = message.angle_min, message.angle_increment, message.range_min, message.range_max
    scan = LaserScan2D(message.ranges, *geometry, seen)
    _check_length(message, scan)
    if np.isnan(scan.ranges[scan.seen]).all():
        raise ScanError(f"The scan holds no valid reading among {scan.ranges.size} beams; check the lidar.")
    return scan


def _check_length(message: LaserScanMessage, scan: LaserScan2D) -> None:
    """Compare the number of beams with the angles.

    The last beam may lie before angle_max, because the step is seldom a whole part of the angle: by up to one
    step in a scan of pointcloud_to_laserscan, by up to two in one of velodyne_laserscan.

    Raises:
        ScanError: they do not agree.
    """
    beams = scan.ranges.size
    steps = (message.angle_max - message.angle_min) / message.angle_increment
    if not -0.5 < steps - (beams - 1) < MOST_STEPS_BEHIND:
        raise ScanError(
            f"The scan has {beams} ranges, but its angles ask for {steps + 1.0:.0f}; check the driver."
        )


def inertial_of(message: Imu) -> InertialReading:
    """Return a sensor_msgs/Imu in the axes of the body, as MAVROS gives it.

    Raises:
        MotionError: it holds no rates.
    """
    if message.angular_velocity_covariance[0] < 0.0:
        raise MotionError("The IMU tells no rates (its covariance begins with -1).")
    has_force = message.linear_acceleration_covariance[0] >= 0.0
    force = xyz(message.linear_acceleration) if has_force else NOT_MEASURED
    return InertialReading(xyz(message.angular_velocity), force)


def velocity_of(twist: Twist, what: str) -> tuple[float, float, float]:
    """Return the linear velocity (x, y, z) of a geometry_msgs/Twist.

    Raises:
        VelocityError: not finite, or faster than anything flies.
    """
    velocity = xyz(twist.linear)
    if not all(math.isfinite(component) for component in velocity):
        raise VelocityError(f"The {what} is not finite: {velocity}.")
    if math.hypot(*velocity) > GREATEST_SPEED_M_S:
        raise VelocityError(
            f"The {what} is beyond {GREATEST_SPEED_M_S:.0e} m/s: {velocity}; check its source."
        )
    return velocity


def stats_of(
    stamp: rospy.Time,
    name: str,
    algorithm: str,
    decision: Decision,
    computation_ms: float,
    cpu_ms: float,
    report: Report | None = None,
) -> DiagnosticArray:
    """Return the figures of one decision, and what `Dynamic` reports of it.

    computation_ms: how long it took. cpu_ms: processor time.
    """
    values = {
        "computation_time_ms": f"{computation_ms:.4f}",
        "cpu_time_ms": f"{cpu_ms:.4f}",
        "directions_tested": str(decision.directions_tested),
        "cost": f"{decision.cost:.9g}",
        "emergency": str(decision.emergency),
        "reason": decision.reason.value,
        "algorithm": algorithm,
    }
    reported = dataclasses.asdict(report) if report else {}
    values.update({key: f"{value:.4g}" for key, value in reported.items() if value is not None})
    is_held = report is not None and report.held_s >= HELD_S
    alarming = decision.emergency or is_held or decision.reason in (Reason.BLOCKED, Reason.NO_WAY)
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN if alarming else DiagnosticStatus.OK,
        name=name,
        message=f"held up: {decision.reason.value}" if is_held else decision.reason.value,
        hardware_id="",
        values=[KeyValue(key, value) for key, value in values.items()],
    )
    message = DiagnosticArray(status=[status])
    message.header.stamp = stamp
    return message


def remembered_of(header: Header, view: View) -> PointCloud2:
    """Return what `Dynamic` remembers, in the scan's frame; hidden is 1 where the scan cannot see it."""
    rows = np.zeros((len(view.remembered_m), 4), np.float32)
    rows[:, :3], rows[:, 3] = view.remembered_m, view.hidden
    names = ("x", "y", "z", "hidden")
    return PointCloud2(
        header=header,
        height=1,
        width=len(rows),
        fields=[PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate(names)],
        point_step=16,
        row_step=16 * len(rows),
        is_dense=True,
        data=rows.tobytes(),
    )
