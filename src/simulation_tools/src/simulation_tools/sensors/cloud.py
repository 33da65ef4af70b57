"""The three-dimensional cloud of a lidar with several channels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import RaySensor
from simulation_tools.sensors.lidar import Rays, all_directions, measured, reach_m


class Cloud(NamedTuple):
    """The points of one turn. points_m: float32 (n, 3), lidar's frame; rings: uint16 (n,), 0 the lowest."""

    points_m: np.ndarray
    rings: np.ndarray


class CloudLidar:
    """All channels of one lidar, `sensor`. A beam that hits nothing gives no point."""

    def __init__(self, sensor: RaySensor, rng: np.random.Generator) -> None:
        """Aim the beams. rng: source of the noise."""
        self.sensor = sensor
        self._directions = all_directions(sensor).reshape(-1, 3)
        rows, beams = sensor.vertical.samples, sensor.horizontal.samples
        self._rings = np.repeat(np.arange(rows, dtype=np.uint16), beams)
        self._rng = rng

    def read(self, rays: Rays, pose: Pose, own_model: str | None = None) -> Cloud:
        """Return the cloud. pose: of the lidar's frame in the world."""
        directions = self._directions @ pose.rotation.astype(np.float32).T
        true = rays.cast(np.array(pose.position_m), directions, reach_m(self.sensor), own_model)
        ranges = measured(true, self.sensor, self._rng)
        met = np.isfinite(ranges)
        return Cloud(self._directions[met] * ranges[met, None], self._rings[met])
