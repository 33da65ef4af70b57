"""Conversions between the world's frames (ENU, FLU, quaternions x y z w) and PX4's (NED, FRD, w x y z).

Each function is its own inverse up to the order of a quaternion's components.
"""

from __future__ import annotations

import math
from typing import Sequence

_HALF_ROOT = math.sqrt(0.5)


def enu_to_ned(v: Sequence[float]) -> tuple[float, float, float]:
    """East-north-up to north-east-down, and back."""
    return (v[1], v[0], -v[2])


def flu_to_frd(v: Sequence[float]) -> tuple[float, float, float]:
    """Forward-left-up to forward-right-down, and back."""
    return (v[0], -v[1], -v[2])


def attitude_to_ned(q_xyzw: Sequence[float]) -> tuple[float, float, float, float]:
    """Attitude of FLU in ENU (x, y, z, w) to attitude of FRD in NED (w, x, y, z)."""
    x, y, z, w = q_xyzw
    return (_HALF_ROOT * (w + z), _HALF_ROOT * (x + y), _HALF_ROOT * (x - y), _HALF_ROOT * (w - z))


def attitude_to_enu(q_wxyz: Sequence[float]) -> tuple[float, float, float, float]:
    """Attitude of FRD in NED (w, x, y, z) to attitude of FLU in ENU (x, y, z, w)."""
    w, x, y, z = q_wxyz
    return (_HALF_ROOT * (x + y), _HALF_ROOT * (x - y), _HALF_ROOT * (w - z), _HALF_ROOT * (w + z))


def covariance_to_ned(matrix: Sequence[float]) -> list[float]:
    """Covariance in ENU to NED, and back: n x n, row by row, n a multiple of 3 (position, rotation).

    One NaN means that all is unknown, as when the whole matrix is rotated.
    """
    return _permuted(matrix, (1, 0, 2), (1.0, 1.0, -1.0))


def covariance_to_frd(matrix: Sequence[float]) -> list[float]:
    """Covariance in FLU to FRD, and back; see `covariance_to_ned`."""
    return _permuted(matrix, (0, 1, 2), (1.0, -1.0, -1.0))


def _permuted(matrix: Sequence[float], axes: Sequence[int], signs: Sequence[float]) -> list[float]:
    """Rotate each 3 x 3 block of a matrix to new axes: new axis i is signs[i] times old axis axes[i]."""
    if any(map(math.isnan, matrix)):
        return [math.nan] * len(matrix)
    size = math.isqrt(len(matrix))
    old = [i - i % 3 + axes[i % 3] for i in range(size)]
    return [
        signs[row % 3] * signs[column % 3] * matrix[size * old[row] + old[column]]
        for row in range(size)
        for column in range(size)
    ]


def yaw_to_ned(yaw_enu_rad: float) -> float:
    """Heading counter-clockwise from east to heading clockwise from north, and back; in (-pi, pi]."""
    yaw = math.remainder(0.5 * math.pi - yaw_enu_rad, 2.0 * math.pi)
    return math.pi if yaw == -math.pi else yaw
