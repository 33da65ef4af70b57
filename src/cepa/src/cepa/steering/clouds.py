"""Clouds of lidars with several channels and of depth cameras, in the scan's frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, NamedTuple

import numpy as np

from cepa.errors import MotionError, ParameterError
from cepa.motion import Cloud
from cepa.steering.mount import Mount, into_body, out_of_body

LIMITS = ("elevation_min", "elevation_max", "azimuth_min", "azimuth_max", "range_min", "range_max")


@dataclass(frozen=True)
class CloudLimits:
    """Where the sensor looks, rad and m in the scan's frame: a cloud does not tell it."""

    elevation_rad: tuple[float, float]
    azimuth_rad: tuple[float, float]
    range_m: tuple[float, float]

    @classmethod
    def of(cls, given: Any) -> CloudLimits:
        """Return the limits in a mapping, as the ROS parameter ~cloud is one. Raises ParameterError."""
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

    def cloud(self, points_m: np.ndarray, own_m: np.ndarray | None = None) -> Cloud:
        """Return a cloud of ``points_m`` (n, 3) in the scan's frame. Raises MotionError.

        own_m: as of a cloud.
        """
        return Cloud(points_m, self.elevation_rad, *self.range_m, self.azimuth_rad, own_m)


class SensedPoints(NamedTuple):
    """What a sensor saw, in its own frame."""

    points_m: np.ndarray
    """(n, 3); rows that are not finite are no returns."""
    mount: Mount
    """Of the sensor."""

    def seen_from(self, lidar: Mount) -> np.ndarray:
        """Return the points (n, 3) in the frame of a lidar."""
        if self.mount.has_pose_of(lidar):
            return self.points_m
        return out_of_body(into_body(self.points_m, self.mount), lidar)
