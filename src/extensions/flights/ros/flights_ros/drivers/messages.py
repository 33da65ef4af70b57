"""ROS messages as rows of a flight's log."""

from __future__ import annotations

from typing import Any

from node_tools.conversions import xyz, xyzw, yaw_of
from simulation_tools.bounds import are_sane


def stamp_s(message: Any) -> float:
    """Return a message's stamp, s."""
    return message.header.stamp.to_sec()


def pose_values(message: Any) -> tuple[float, ...]:
    """Return (x, y, z, qx, qy, qz, qw) of a geometry_msgs/Pose.

    Raises:
        ValueError: a value is not a number, or the place is absurdly far away.
    """
    position = xyz(message.position)
    values = (*position, *xyzw(message.orientation))
    if not are_sane(values):
        raise ValueError("it lies at ({:g}, {:g}, {:g})".format(*position))
    return values


def planar_pose(message: Any) -> tuple[float, float, float]:
    """Return (x, y, yaw) of a geometry_msgs/Pose; raises ValueError as `pose_values` does."""
    x, y, *_ = pose_values(message)
    return x, y, yaw_of(message.orientation)


def twist_row(message: Any) -> tuple[float, ...]:
    """Return (t, vx, vy, vz, yaw rate) of a geometry_msgs/TwistStamped."""
    return (stamp_s(message), *xyz(message.twist.linear), message.twist.angular.z)


def decision_rows(message: Any) -> list[tuple]:
    """Return CEPA's decisions in a diagnostic_msgs/DiagnosticArray, as `flight_log.DECISION_COLUMNS`.

    If a node does not tell its processor time, how long it took counts.

    Raises:
        KeyError: a value is missing.
        ValueError: a value is not a number.
    """
    rows: list[tuple] = []
    for status in message.status:
        values = {item.key: item.value for item in status.values}
        decision = (
            float(values.get("cpu_time_ms", values["computation_time_ms"])),
            int(values["directions_tested"]),
            float(values["cost"]),
            values["emergency"].lower() == "true",
            values["reason"],
        )
        rows.append((stamp_s(message), *decision))
    return rows
