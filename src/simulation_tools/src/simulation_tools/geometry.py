"""Rigid transforms: quaternions and poses on plain Python floats.

Conventions (REP-103): right-handed frames, metres, radians; x forward, y left, z up. Quaternions are unit,
ordered (x, y, z, w), and turn the child frame's coordinates into the parent's. Roll, pitch and yaw turn about
the *fixed* axes x, y, z in this order, R = Rz(yaw) Ry(pitch) Rx(roll), as in SDF's ``<pose>``, URDF and ROS.

The simulator calls these functions a dozen times per 4 ms step; on three or four numbers, plain floats are
several times faster than numpy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from simulation_tools.bounds import MAX_MAGNITUDE, are_sane

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

IDENTITY_QUATERNION: Quaternion = (0.0, 0.0, 0.0, 1.0)
ORIGIN: Vector3 = (0.0, 0.0, 0.0)


def wrap_angle(angle_rad: float) -> float:
    """Wrap an angle to (-pi, pi]."""
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def quaternion_multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product a b: the rotation b followed by the rotation a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def quaternion_conjugate(q: Quaternion) -> Quaternion:
    """Return the inverse rotation of a unit quaternion."""
    return (-q[0], -q[1], -q[2], q[3])


def quaternion_normalised(q: Sequence[float]) -> Quaternion:
    """Scale to unit length. Raises ValueError for zero, NaN and infinity."""
    x, y, z, w = (float(component) for component in q)
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not 1e-9 < length < math.inf:
        raise ValueError(f"the quaternion ({x}, {y}, {z}, {w}) is not a rotation")
    return (x / length, y / length, z / length, w / length)


def rotate(q: Quaternion, v: Sequence[float]) -> Vector3:
    """Take a vector's coordinates from the child frame to the parent frame."""
    qx, qy, qz, qw = q
    vx, vy, vz = v
    # v + 2 qw (q x v) + 2 q x (q x v)
    tx = 2.0 * (qy * vz - qz * vy)
    ty = 2.0 * (qz * vx - qx * vz)
    tz = 2.0 * (qx * vy - qy * vx)
    return (
        vx + qw * tx + qy * tz - qz * ty,
        vy + qw * ty + qz * tx - qx * tz,
        vz + qw * tz + qx * ty - qy * tx,
    )


def rotate_inverse(q: Quaternion, v: Sequence[float]) -> Vector3:
    """Take a vector's coordinates from the parent frame to the child frame."""
    # As `rotate` by the inverse, without a second call.
    qx, qy, qz, qw = q
    qx, qy, qz = -qx, -qy, -qz
    vx, vy, vz = v
    tx = 2.0 * (qy * vz - qz * vy)
    ty = 2.0 * (qz * vx - qx * vz)
    tz = 2.0 * (qx * vy - qy * vx)
    return (
        vx + qw * tx + qy * tz - qz * ty,
        vy + qw * ty + qz * tx - qx * tz,
        vz + qw * tz + qx * ty - qy * tx,
    )


def cross(a: Sequence[float], b: Sequence[float]) -> Vector3:
    """Return the vector product a x b."""
    ax, ay, az = a
    bx, by, bz = b
    return (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def quaternion_from_rpy(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    """Quaternion of Rz(yaw) Ry(pitch) Rx(roll)."""
    cr, sr = math.cos(0.5 * roll_rad), math.sin(0.5 * roll_rad)
    cp, sp = math.cos(0.5 * pitch_rad), math.sin(0.5 * pitch_rad)
    cy, sy = math.cos(0.5 * yaw_rad), math.sin(0.5 * yaw_rad)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def rpy_from_quaternion(q: Quaternion) -> Vector3:
    """Roll in (-pi, pi], pitch in [-pi/2, pi/2], yaw in (-pi, pi]; at pitch +-90 deg roll is set to zero."""
    x, y, z, w = q
    # R[2][0] = 2 (x z - w y) = -sin(pitch)
    sin_pitch = max(-1.0, min(1.0, 2.0 * (w * y - x * z)))
    cos_pitch_squared = (1.0 - 2.0 * (y * y + z * z)) ** 2 + (2.0 * (x * y + w * z)) ** 2
    if cos_pitch_squared < 1e-14:
        # Only yaw -+ roll is defined here. Take roll as zero.
        return (0.0, math.copysign(0.5 * math.pi, sin_pitch), wrap_angle(2.0 * math.atan2(z, w)))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    # atan2 keeps its accuracy near +-90 degrees, where asin loses half of the digits.
    pitch = math.atan2(sin_pitch, math.sqrt(cos_pitch_squared))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return (roll, pitch, yaw)


def yaw_from_quaternion(q: Quaternion) -> float:
    """Heading of the child's x axis in the parent's x-y plane, radians in (-pi, pi]."""
    x, y, z, w = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def quaternion_from_rotation_vector(v: Sequence[float]) -> Quaternion:
    """Quaternion of a rotation by |v| radians about v."""
    angle = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    # The series of sin(a/2)/a keeps tiny rotations exact, where the quotient is 0/0.
    factor = math.sin(0.5 * angle) / angle if angle > 1e-6 else 0.5 - angle * angle / 48.0
    return (factor * v[0], factor * v[1], factor * v[2], math.cos(0.5 * angle))


def rotation_vector_from_quaternion(q: Quaternion) -> Vector3:
    """Axis times angle of a unit quaternion, the angle in [0, pi]."""
    x, y, z, w = q if q[3] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    sine = math.sqrt(x * x + y * y + z * z)
    factor = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    return (factor * x, factor * y, factor * z)


def rotation_matrix(q: Quaternion) -> np.ndarray:
    """Rotation matrix (3, 3) of a unit quaternion: parent coordinates = R @ child coordinates."""
    x, y, z, w = q
    return np.array(
        (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )
    )


def quaternion_from_matrix(matrix: np.ndarray) -> Quaternion:
    """Quaternion (w >= 0) of a proper rotation matrix (3, 3)."""
    ((a, b, c), (d, e, f), (g, h, i)) = np.asarray(matrix, dtype=float).tolist()
    # Each candidate is 4 q_k q; the one with the largest pivot divides by no small number (Shepperd, 1978).
    candidates = (
        (1.0 + a - e - i, b + d, c + g, h - f),
        (b + d, 1.0 - a + e - i, f + h, c - g),
        (c + g, f + h, 1.0 - a - e + i, d - b),
        (h - f, c - g, d - b, 1.0 + a + e + i),
    )
    best = max(range(4), key=lambda k: candidates[k][k])
    q = quaternion_normalised(candidates[best])
    return q if q[3] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])


@dataclass(frozen=True)
class Pose:
    """Pose of a child frame in its parent frame.

    position_m: (x, y, z) of the child's origin in the parent. orientation_xyzw: unit quaternion that turns
    the child's coordinates into the parent's. Nothing is checked here, for speed; data from outside goes
    through `Pose.checked`.
    """

    position_m: Vector3 = ORIGIN
    orientation_xyzw: Quaternion = IDENTITY_QUATERNION

    @classmethod
    def identity(cls) -> Pose:
        """Return the pose of a frame in itself."""
        return cls()

    @classmethod
    def from_xyz_rpy(
        cls, x: float, y: float, z: float, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0
    ) -> Pose:
        """Build from metres and radians, as SDF's ``<pose>`` gives them."""
        return cls((float(x), float(y), float(z)), quaternion_from_rpy(roll, pitch, yaw))

    @classmethod
    def checked(cls, position_m: Sequence[float], orientation_xyzw: Sequence[float]) -> Pose:
        """Build from untrusted numbers: normalises; raises ValueError when they are no pose."""
        x, y, z = (float(component) for component in position_m)
        if not are_sane((x, y, z)):
            raise ValueError(f"the position ({x}, {y}, {z}) is not finite or beyond {MAX_MAGNITUDE:g} m")
        return cls((x, y, z), quaternion_normalised(orientation_xyzw))

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: (A in W) @ (B in A) = (B in W)."""
        orientation = quaternion_multiply(self.orientation_xyzw, other.orientation_xyzw)
        return Pose(self.place(other.position_m), orientation)

    def place(self, point_m: Sequence[float]) -> Vector3:
        """Take one point (3,) from the child frame to the parent frame."""
        x, y, z = self.position_m
        dx, dy, dz = rotate(self.orientation_xyzw, point_m)
        return x + dx, y + dy, z + dz

    def inverse(self) -> Pose:
        """Pose of the parent in the child."""
        conjugate = quaternion_conjugate(self.orientation_xyzw)
        x, y, z = rotate(conjugate, self.position_m)
        return Pose((-x, -y, -z), conjugate)

    def transform(self, points: np.ndarray) -> np.ndarray:
        """Take points (n, 3), or one point (3,) as an array, from the child frame to the parent frame."""
        return np.asarray(points) @ rotation_matrix(self.orientation_xyzw).T + np.array(self.position_m)

    @property
    def rotation(self) -> np.ndarray:
        """Rotation matrix (3, 3): parent coordinates = R @ child coordinates."""
        return rotation_matrix(self.orientation_xyzw)

    @property
    def yaw_rad(self) -> float:
        """Heading of the child's x axis, (-pi, pi]."""
        return yaw_from_quaternion(self.orientation_xyzw)

    @property
    def rpy_rad(self) -> Vector3:
        """Roll, pitch and yaw; see `rpy_from_quaternion`."""
        return rpy_from_quaternion(self.orientation_xyzw)


IDENTITY = Pose()
