"""A scanning lidar: what its beams would measure, by REP-117.

The beams lie in the x-y plane of the lidar's own frame and tilt with the UAV. The ranges of a scan are the
true distances plus Gaussian noise, rounded to the sensor's resolution; +inf means nothing within range_max,
-inf something nearer than range_min.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import RaySensor, ScanAxis


class Rays(Protocol):
    """What a lidar needs of the world (see `world.rays.RayScene.cast`)."""

    def cast(
        self, origins: np.ndarray, directions: np.ndarray, max_range_m: float, ignore_model: str | None
    ) -> np.ndarray:
        """Return the distance along each ray, inf for none."""


class Lidar:
    """One lidar on a body. Its beams go counter-clockwise from angle_min to angle_max by angle_increment.

    period_us: microseconds between scans. range_min, range_max: metres. A sensor with several vertical
    samples scans with the row nearest to the horizontal.
    """

    def __init__(self, sensor: RaySensor, pose_in_body: Pose, rng: np.random.Generator) -> None:
        """Aim the beams. pose_in_body: of the lidar's frame in the model frame; rng: source of the noise."""
        axis = sensor.horizontal
        self.name = sensor.name
        self.pose_in_body = pose_in_body
        self.period_us = round(1e6 / sensor.update_rate_hz) if sensor.update_rate_hz > 0.0 else 0
        self.angle_min = axis.min_angle_rad
        self.angle_max = axis.max_angle_rad
        self.angle_increment = axis.increment_rad
        self.beams = axis.samples
        self.range_min = sensor.range_min_m
        self.range_max = sensor.range_max_m
        self._resolution = sensor.range_resolution_m
        self._noise = sensor.noise
        self._rng = rng
        self._directions = _beam_directions(axis, _level_elevation(sensor.vertical))

    def scan(self, rays: Rays, body_pose: Pose, own_model: str | None = None) -> np.ndarray:
        """Return the measured ranges, float32 (beams,).

        rays: the world's shapes. body_pose: of the body in the world. own_model: the model that carries the
        lidar, which its beams do not see.
        """
        pose = body_pose @ self.pose_in_body
        directions = self._directions @ pose.rotation.astype(np.float32).T
        # A surface just beyond range_max may be measured within it; five sigma is far enough.
        reach = self.range_max + abs(self._noise.mean) + 5.0 * self._noise.stddev
        true = rays.cast(np.array(pose.position_m), directions, reach, own_model)
        return self._measured(true)

    def _measured(self, ranges: np.ndarray) -> np.ndarray:
        too_close = ranges < self.range_min
        if self._noise.stddev > 0.0:
            # Always one number per beam: the noise of a beam must not depend on what the others see.
            noise = self._rng.standard_normal(self.beams, np.float32)
            ranges += noise * np.float32(self._noise.stddev)
        if self._noise.mean:
            ranges += np.float32(self._noise.mean)
        if self._resolution > 0.0:
            np.rint(ranges / np.float32(self._resolution), out=ranges)
            ranges *= np.float32(self._resolution)
        # What is truly within the sensor's reach stays within it, whatever the noise says.
        np.maximum(ranges, np.float32(self.range_min), out=ranges)
        ranges[ranges > self.range_max] = np.inf
        ranges[too_close] = -np.inf
        return ranges


def _beam_directions(axis: ScanAxis, elevation_rad: float) -> np.ndarray:
    """Return unit vectors (samples, 3), float32, in the lidar's frame."""
    angles = axis.min_angle_rad + axis.increment_rad * np.arange(axis.samples)
    level = math.cos(elevation_rad)
    rows = (level * np.cos(angles), level * np.sin(angles), np.full(axis.samples, math.sin(elevation_rad)))
    return np.column_stack(rows).astype(np.float32)


def _level_elevation(vertical: ScanAxis) -> float:
    elevations = vertical.min_angle_rad + vertical.increment_rad * np.arange(vertical.samples)
    return float(elevations[np.argmin(np.abs(elevations))])
