"""A scanning lidar: the ranges that its beams measure, by REP-117.

The beams lie in the x-y plane of the lidar's own frame and tilt with the UAV. The ranges of a scan are the
true distances plus Gaussian noise, rounded to the sensor's resolution; +inf means nothing within range_max,
-inf something nearer than range_min.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.compiled_geometry import quaternion_multiply, rotate
from simulation_tools.geometry import Pose, Quaternion, Vector3
from simulation_tools.sdf.elements import RaySensor, ScanAxis


class Rays(Protocol):
    """The part of the world that a lidar uses (see `world.rays.RayScene.cast`)."""

    def cast(
        self, origins: np.ndarray, directions: np.ndarray, max_range_m: float, ignore_model: str | None
    ) -> np.ndarray:
        """Return the distance along each ray, inf for none."""


class Lidar:
    """One lidar on a body. Its beams go counter-clockwise from angle_min to angle_max by angle_increment.

    directions: their unit vectors in the lidar's own frame, float32 (beams, 3).

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
        self._sensor = sensor
        self._rng = rng
        self._origin, self._turn = np.zeros(3), np.zeros((3, 3), np.float32)  # in the world, see `_aim`
        self.directions = _beam_directions(axis, _level_elevation(sensor.vertical))

    def scan(self, rays: Rays, body_pose: Pose, own_model: str | None = None) -> np.ndarray:
        """Return the measured ranges, float32 (beams,).

        rays: the world's shapes. body_pose: of the body in the world. own_model: the model that carries the
        lidar, which its beams do not see.
        """
        mount = self.pose_in_body
        place = body_pose.position_m, body_pose.orientation_xyzw
        _aim(*place, mount.position_m, mount.orientation_xyzw, self._origin, self._turn)
        directions = self.directions @ self._turn.T
        true = rays.cast(self._origin, directions, reach_m(self._sensor), own_model)
        return measured(true, self._sensor, self._rng)


@njit(cache=True)
def _aim(
    at: Vector3,
    q: Quaternion,
    mount_at: Vector3,
    mount_q: Quaternion,
    origin: np.ndarray,
    turn: np.ndarray,
) -> None:
    """Fill in where a lidar is (3,), and its rotation matrix (3, 3), float32, in the world.

    at, q: of the body in the world. mount_at, mount_q: of the lidar on the body.
    """
    (x, y, z), (dx, dy, dz) = at, rotate(q, mount_at)
    origin[0], origin[1], origin[2] = x + dx, y + dy, z + dz
    (x, y, z, w) = quaternion_multiply(q, mount_q)
    # As `geometry.rotation_matrix`
    turn[0] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    turn[1] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    turn[2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


def reach_m(sensor: RaySensor) -> float:
    """Return the distance to search.

    Noise may bring what lies up to five sigma beyond range_max into range.
    """
    return sensor.range_max_m + abs(sensor.noise.mean) + 5.0 * sensor.noise.stddev


def measured(ranges: np.ndarray, sensor: RaySensor, rng: np.random.Generator) -> np.ndarray:
    """Turn true ranges, float32 (n,), into measured ones, in place: with noise, resolution and limits."""
    noise = sensor.noise
    # Always draw one number per beam, so that a beam's noise does not depend on what other beams hit.
    count = len(ranges) if noise.stddev > 0.0 else 0
    normals = rng.standard_normal(count, np.float32)
    limits = np.float32(sensor.range_min_m), np.float32(sensor.range_max_m)
    resolution = np.float32(max(sensor.range_resolution_m, 0.0))
    _measure(ranges, normals, np.float32(noise.stddev), np.float32(noise.mean), resolution, *limits)
    return ranges


@njit(cache=True)
def _measure(
    ranges: np.ndarray,
    normals: np.ndarray,
    stddev: np.float32,
    mean: np.float32,
    resolution: np.float32,
    range_min: np.float32,
    range_max: np.float32,
) -> None:
    """Do what `measured` says, all in single precision. normals: (n,), or none without noise."""
    for i in range(ranges.size):
        true = ranges[i]
        value = true
        if normals.size:
            value += normals[i] * stddev
        value += mean
        if resolution > 0.0:
            value = np.rint(value / resolution) * resolution
        # Noise must not move a range that is truly within the sensor's limits out of them.
        value = max(value, range_min)
        if value > range_max:
            value = np.inf
        ranges[i] = -np.inf if true < range_min else value


def all_directions(sensor: RaySensor) -> np.ndarray:
    """Return unit vectors of all beams in the sensor's frame, float32 (rows, beams, 3), lowest row first."""
    axis = sensor.vertical
    elevations = axis.min_angle_rad + axis.increment_rad * np.arange(axis.samples)
    return np.stack([_beam_directions(sensor.horizontal, float(elevation)) for elevation in elevations])


def _beam_directions(axis: ScanAxis, elevation_rad: float) -> np.ndarray:
    """Return unit vectors (samples, 3), float32, in the lidar's frame."""
    angles = axis.min_angle_rad + axis.increment_rad * np.arange(axis.samples)
    level = math.cos(elevation_rad)
    rows = (level * np.cos(angles), level * np.sin(angles), np.full(axis.samples, math.sin(elevation_rad)))
    return np.column_stack(rows).astype(np.float32)


def _level_elevation(vertical: ScanAxis) -> float:
    elevations = vertical.min_angle_rad + vertical.increment_rad * np.arange(vertical.samples)
    return float(elevations[np.argmin(np.abs(elevations))])
