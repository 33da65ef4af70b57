"""Clouds of lidars with several channels and of depth cameras, in the scan's frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

from cepa import Cloud, MotionError, ParameterError
from cepa.motion import rotation_matrix
from cepa_ros.frames import Mount

LIMITS = ("elevation_min", "elevation_max", "azimuth_min", "azimuth_max", "range_min", "range_max")


@dataclass(frozen=True)
class CloudLimits:
    """Where the sensor looks, rad and m in the scan's frame: a cloud does not tell it."""

    elevation_rad: tuple[float, float]
    azimuth_rad: tuple[float, float]
    range_m: tuple[float, float]

    @classmethod
    def of(cls, given: Any) -> CloudLimits:
        """Return the limits in the ROS parameter ~cloud. Raises ParameterError."""
        values = given if isinstance(given, Mapping) else {}
        values = {"azimuth_min": -math.pi, "azimuth_max": math.pi, **values}
        if set(values) != set(LIMITS) or not all(isinstance(v, (int, float)) for v in values.values()):
            raise ParameterError(f"cloud must hold numbers for {', '.join(LIMITS)}, not {given}.")
        numbers = [float(values[name]) for name in LIMITS]
        limits = cls((numbers[0], numbers[1]), (numbers[2], numbers[3]), (numbers[4], numbers[5]))
        try:
            limits.cloud(np.empty((0, 3)))
        except MotionError as error:
            raise ParameterError(str(error)) from None
        return limits

    @property
    def looks_all_around(self) -> bool:
        """As of a cloud."""
        return self.cloud(np.empty((0, 3))).looks_all_around

    def cloud(self, points_m: np.ndarray) -> Cloud:
        """Return a cloud of ``points_m`` (n, 3) in the scan's frame. Raises MotionError."""
        return Cloud(points_m, self.elevation_rad, *self.range_m, self.azimuth_rad)


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


def into_body(points_m: np.ndarray, mount: Mount) -> np.ndarray:
    """Return points (n, 3) of a sensor's frame in the body's."""
    return points_m @ rotation_matrix(mount.orientation_xyzw).T + mount.position_m


def out_of_body(points_m: np.ndarray, mount: Mount) -> np.ndarray:
    """Return points (n, 3) of the body's frame in a sensor's."""
    return (points_m - mount.position_m) @ rotation_matrix(mount.orientation_xyzw)
