"""Points of sensor_msgs/PointCloud2."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField


class CloudError(Exception):
    """A cloud that cannot be read; the message is one sentence for the user."""


def points_of(message: PointCloud2) -> np.ndarray:
    """Return the points (n, 3) of a cloud in its own frame, float32, m; some may not be finite.

    Raises:
        CloudError: it has no x, y and z as float32, or its steps and its length do not agree.
    """
    offsets = {f.name: f.offset for f in message.fields if f.datatype == PointField.FLOAT32}
    if not {"x", "y", "z"} <= set(offsets):
        raise CloudError("The cloud has no fields x, y and z of 32 bits; check its source.")
    step = message.point_step
    if max(offsets[name] for name in "xyz") + 4 > step or message.row_step < message.width * step:
        raise CloudError(
            f"The cloud's fields do not fit into points of {step} bytes and rows of {message.row_step}; "
            "check its source."
        )
    if len(message.data) != message.height * message.row_step:
        raise CloudError(
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
    shape, strides = (message.height, message.width), (message.row_step, step)
    rows: np.ndarray = np.ndarray(shape, kind, message.data, strides=strides)
    return np.stack([rows[name] for name in "xyz"], axis=-1).reshape(-1, 3).astype(np.float32)
