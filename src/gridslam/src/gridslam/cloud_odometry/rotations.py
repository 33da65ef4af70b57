"""Rotations in space by scipy. It is imported when the first cloud comes, because level scans need none."""

from __future__ import annotations

from typing import Sequence

import numpy as np


def matrix_of(vector: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) of a rotation vector (3,), rad."""
    from scipy.spatial.transform import Rotation  # 15 MB

    matrix: np.ndarray = Rotation.from_rotvec(vector).as_matrix()
    return matrix


def vector_of(matrix: np.ndarray) -> np.ndarray:
    """Return the rotation vector (3,), rad, of a matrix (3, 3)."""
    from scipy.spatial.transform import Rotation

    vector: np.ndarray = Rotation.from_matrix(matrix).as_rotvec()
    return vector
