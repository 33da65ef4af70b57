"""Rotations in three dimensions: quaternions (x, y, z, w), and roll, pitch and yaw by REP-103."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam.errors import ScanError

NORM_TOLERANCE = 1e-2


def matrix_of_quaternion(xyzw: Sequence[float]) -> np.ndarray:
    """Return the (3, 3) rotation matrix of a unit quaternion (x, y, z, w).

    Raises:
        ScanError: it is not finite, or its norm is not 1 (within 1 %).
    """
    norm = math.sqrt(sum(component * component for component in xyzw))
    if not abs(norm - 1.0) < NORM_TOLERANCE:
        raise ScanError(f"The quaternion {_listed(xyzw)} has norm {norm:.3g}; a rotation has norm 1.")
    x, y, z, w = (component / norm for component in xyzw)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def roll_pitch_yaw_of(rotation: np.ndarray) -> tuple[float, float, float]:
    """Return (roll, pitch, yaw) in radians of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch_rad = math.asin(min(1.0, max(-1.0, -rotation[2, 0])))
    roll_rad = math.atan2(rotation[2, 1], rotation[2, 2])
    return roll_rad, pitch_rad, math.atan2(rotation[1, 0], rotation[0, 0])


def matrix_of_lean(roll_rad: float, pitch_rad: float) -> np.ndarray:
    """Return (3, 3) Ry(pitch) Rx(roll), which takes a vector of a leaning body to its levelled frame."""
    cr, sr, cp, sp = math.cos(roll_rad), math.sin(roll_rad), math.cos(pitch_rad), math.sin(pitch_rad)
    return np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])


def _listed(numbers: Sequence[float]) -> str:
    return "(" + ", ".join(f"{number:g}" for number in numbers) + ")"
