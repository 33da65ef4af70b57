"""Poses in the plane: rows of x, y in metres and yaw in radians.

``a_in_b`` is the pose of frame a in frame b; ``compose(a_in_c, b_in_a)`` is then b in c. Every function takes
one pose (3,) or many (..., 3) and broadcasts.
"""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike

TURN = 2.0 * np.pi


def wrap(angle_rad: Any) -> Any:
    """Return an angle, or an array of them, in [-pi, pi)."""
    return (angle_rad + np.pi) % TURN - np.pi


def compose(frame: ArrayLike, pose: ArrayLike) -> np.ndarray:
    """Return ``pose``, given in ``frame``, in the frame that ``frame`` is given in."""
    frame, pose = np.asarray(frame, float), np.asarray(pose, float)
    x, y, yaw = frame[..., 0], frame[..., 1], frame[..., 2]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.stack(
        np.broadcast_arrays(
            x + cos * pose[..., 0] - sin * pose[..., 1],
            y + sin * pose[..., 0] + cos * pose[..., 1],
            wrap(yaw + pose[..., 2]),
        ),
        axis=-1,
    )


def inverse(pose: ArrayLike) -> np.ndarray:
    """Return the pose of the outer frame in ``pose``'s own frame."""
    pose = np.asarray(pose, float)
    cos, sin = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = pose[..., 0], pose[..., 1]
    return np.stack((-cos * x - sin * y, sin * x - cos * y, wrap(-pose[..., 2])), axis=-1)


def between(first: ArrayLike, second: ArrayLike) -> np.ndarray:
    """Return ``second`` in the frame of ``first``, both given in one frame."""
    return compose(inverse(first), second)


def transform(pose: Sequence[float] | np.ndarray, points_xy: ArrayLike) -> np.ndarray:
    """Return points (n, 2), given in one pose's frame, in the frame that the pose is given in."""
    x, y, yaw = (float(value) for value in pose)
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.asarray(points_xy) @ np.array([[cos, sin], [-sin, cos]]) + (x, y)


def transform_each(poses: np.ndarray, points_xy: np.ndarray) -> np.ndarray:
    """Return points (n, 2), each given in the frame of its own pose (n, 3), in the frame of the poses."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x, y = points_xy[:, 0], points_xy[:, 1]
    return poses[:, :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
