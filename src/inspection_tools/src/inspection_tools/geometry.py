"""The little quaternion arithmetic that poses need; quaternions are (x, y, z, w)."""

from __future__ import annotations

import math

from inspection_tools.errors import PoseError


def normalised(quaternion_xyzw) -> tuple:
    """Return the unit quaternion.

    Raises:
        PoseError: it is not finite, or all zeros as in a message that nobody filled in.
    """
    norm = math.sqrt(sum(q * q for q in quaternion_xyzw))
    if not (math.isfinite(norm) and norm > 1e-6):
        raise PoseError("The pose's orientation is not a rotation: its quaternion is zero or not finite.")
    return tuple(q / norm for q in quaternion_xyzw)


def yaw_of(quaternion_xyzw) -> float:
    """Heading of a unit quaternion about z, in (-pi, pi] (REP-103)."""
    x, y, z, w = quaternion_xyzw
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def multiply(a_xyzw, b_xyzw) -> tuple:
    """Return the rotation b followed by a."""
    ax, ay, az, aw = a_xyzw
    bx, by, bz, bw = b_xyzw
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(quaternion_xyzw, vector) -> tuple:
    """Return `vector` rotated by a unit quaternion."""
    x, y, z, w = quaternion_xyzw
    conjugate = (-x, -y, -z, w)
    return multiply(multiply(quaternion_xyzw, (*vector, 0.0)), conjugate)[:3]
