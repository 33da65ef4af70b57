"""Points and other fields of sensor_msgs/PointCloud2."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField


class CloudError(Exception):
    """A cloud that cannot be read; the message is one sentence for the user."""


_FORMATS = {PointField.FLOAT32: "f4", PointField.FLOAT64: "f8"}
FORMATS = {**_FORMATS, PointField.UINT32: "u4", PointField.INT32: "i4"}
"""Of the fields that `rows_of` reads."""


def points_of(message: PointCloud2) -> np.ndarray:
    """Return the points (n, 3) of a cloud in its own frame, float32, m; some may not be finite.

    A point at the frame's origin is NaN: so the drivers of Ouster and Livox tell a beam without return.

    Raises:
        CloudError: it has no x, y and z as floats, or its steps and its length do not agree.
    """
    fields = {f.name: f for f in message.fields if f.name in tuple("xyz") and f.datatype in _FORMATS}
    if len(fields) < 3:
        raise CloudError("The cloud has no fields x, y and z of 32 or 64 bits; check its source.")
    rows = rows_of(message, [fields[name] for name in "xyz"])
    with np.errstate(over="ignore"):  # then it is not finite
        points = np.stack([rows[name] for name in "xyz"], axis=-1).reshape(-1, 3).astype(np.float32)
    points[~points.any(axis=1)] = np.nan
    return points


def rows_of(message: PointCloud2, fields: list[PointField]) -> np.ndarray:
    """Return some fields of the points, (height, width), by name; each is of one of `FORMATS`.

    Raises:
        CloudError: its steps and its length do not agree.
    """
    step, order = message.point_step, ">" if message.is_bigendian else "<"
    formats = [np.dtype(order + FORMATS[field.datatype]) for field in fields]
    offsets = [field.offset for field in fields]
    if max(offset + each.itemsize for offset, each in zip(offsets, formats)) > step:
        raise CloudError(f"The cloud's fields do not fit into points of {step} bytes; check its source.")
    names = [field.name for field in fields]
    kind = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": step})
    shape, row_step = (message.height, message.width), _row_step(message)
    return np.ndarray(shape, kind, message.data, strides=(row_step, step))


def _row_step(message: PointCloud2) -> int:
    """Return the bytes from row to row.

    Drivers that send one row often leave row_step at 0, or at the length of a point. As in PCL, it then does
    not count, and neither do bytes behind the last point.
    """
    row, rows = message.width * message.point_step, message.height
    row_step = message.row_step if message.row_step >= row else row
    if rows and row and len(message.data) < (rows - 1) * row_step + row:
        raise CloudError(
            f"The cloud has {len(message.data)} bytes for {rows} rows of {row_step} bytes; check its source."
        )
    return int(row_step)
