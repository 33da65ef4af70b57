"""Points of sensor_msgs/PointCloud2."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

from cepa import MotionError


def points_of(message: PointCloud2) -> np.ndarray:
    """Return the points (n, 3) of a sensor_msgs/PointCloud2 in its own frame, m; rows may be NaN.

    Raises:
        MotionError: it has no x, y and z as float32, no valid point at all, or its steps and its length do
            not agree.
    """
    offsets = {f.name: f.offset for f in message.fields if f.datatype == PointField.FLOAT32}
    if not {"x", "y", "z"} <= set(offsets):
        raise MotionError("The cloud has no fields x, y and z of 32 bits; check its source.")
    shape, step = (message.height, message.width), message.point_step
    if max(offsets[name] for name in "xyz") + 4 > step or message.row_step < message.width * step:
        raise MotionError(
            f"The cloud's fields do not fit into points of {step} bytes and rows of {message.row_step}; "
            "check its source."
        )
    if len(message.data) != message.height * message.row_step:
        raise MotionError(
            f"The cloud has {len(message.data)} bytes for {message.height} rows of {message.row_step} bytes; "
            "check its source."
        )
    kind = np.dtype(
        {
            "names": ["x", "y", "z"],
            "formats": [">f4" if message.is_bigendian else "<f4"] * 3,
            "offsets": [offsets[name] for name in "xyz"],
            "itemsize": step,
        }
    )
    rows: np.ndarray = np.ndarray(shape, kind, message.data, strides=(message.row_step, step))
    points_m = np.stack([rows["x"], rows["y"], rows["z"]], axis=-1).reshape(-1, 3).astype(float)
    if not np.isfinite(points_m).all(axis=1).any():
        raise MotionError(f"The cloud has no valid point among {len(points_m)}; is its sensor covered?")
    return points_m
