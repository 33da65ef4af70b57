"""Quaternion arithmetic for poses; quaternions are (x, y, z, w)."""

from __future__ import annotations

import math

from flight_basics.errors import PoseError

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""(x, y, z, w)."""


def normalised(quaternion_xyzw: Quaternion) -> Quaternion:
    """Return the unit quaternion.

    Raises:
        PoseError: it is not finite, or all zeros as in a message that nobody filled in.
    """
    x, y, z, w = quaternion_xyzw
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not (math.isfinite(norm) and norm > 1e-6):
        raise PoseError("The pose's orientation is not a rotation: its quaternion is zero or not finite.")
    return x / norm, y / norm, z / norm, w / norm


def yaw_of(quaternion_xyzw: Quaternion) -> float:
    """Heading of a unit quaternion about z, in (-pi, pi] (REP-103)."""
    x, y, z, w = quaternion_xyzw
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def multiply(a_xyzw: Quaternion, b_xyzw: Quaternion) -> Quaternion:
    """Return the rotation b followed by a."""
    ax, ay, az, aw = a_xyzw
    bx, by, bz, bw = b_xyzw
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(quaternion_xyzw: Quaternion, vector: Vector3) -> Vector3:
    """Return `vector` rotated by a unit quaternion."""
    x, y, z, w = quaternion_xyzw
    conjugate = (-x, -y, -z, w)
    return multiply(multiply(quaternion_xyzw, (*vector, 0.0)), conjugate)[:3]


def heading_rate(quaternion_xyzw: Quaternion, rates_rad_s: Vector3) -> float:
    """Return how fast the heading of a body turns, rad/s; nan if its x axis points straight up or down.

    quaternion_xyzw: of the body. rates_rad_s: of its turns, in its own frame.
    """
    x, y, z, w = quaternion_xyzw
    _, up_y, up_z = rotate((-x, -y, -z, w), (0.0, 0.0, 1.0))
    level = up_y**2 + up_z**2
    return (rates_rad_s[1] * up_y + rates_rad_s[2] * up_z) / level if level > 0.0 else math.nan
