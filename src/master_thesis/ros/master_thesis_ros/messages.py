"""ROS messages as rows of a flight's log."""

from __future__ import annotations

import math

from simulation_tools.bounds import are_sane


def stamp_s(message) -> float:
    """Return a message's stamp, s."""
    return message.header.stamp.to_sec()


def pose_values(message) -> tuple:
    """Return (x, y, z, qx, qy, qz, qw) of a geometry_msgs/Pose.

    Raises:
        ValueError: it lies beyond every world, or is made of no numbers.
    """
    p, q = message.position, message.orientation
    values = (p.x, p.y, p.z, q.x, q.y, q.z, q.w)
    if not are_sane(values):
        raise ValueError(f"it lies at ({p.x:g}, {p.y:g}, {p.z:g})")
    return values


def planar_pose(pose) -> tuple:
    """Return (x, y, yaw) of a geometry_msgs/Pose."""
    x, y, _, qx, qy, qz, qw = pose_values(pose)
    return (x, y, math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))


def twist_row(message) -> tuple:
    """Return (t, vx, vy, vz, yaw rate) of a geometry_msgs/TwistStamped."""
    linear = message.twist.linear
    return (stamp_s(message), linear.x, linear.y, linear.z, message.twist.angular.z)


def decision_rows(message) -> list[tuple]:
    """Return CEPA's decisions in a diagnostic_msgs/DiagnosticArray, as `flight_log.DECISION_COLUMNS`.

    Raises:
        KeyError: a figure is missing.
        ValueError: a figure is no number.
    """
    rows = []
    for status in message.status:
        values = {item.key: item.value for item in status.values}
        figures = (
            float(values["computation_time_ms"]),
            int(values["directions_tested"]),
            float(values["cost"]),
            values["emergency"].lower() == "true",
            values["reason"],
        )
        rows.append((stamp_s(message), *figures))
    return rows
