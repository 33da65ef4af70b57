"""A range finder: one distance, the least of a narrow bundle of beams."""

from __future__ import annotations

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import RaySensor
from simulation_tools.sensors.lidar import Rays, all_directions, measured, reach_m


class RangeFinder:
    """One range finder, looking along the x axis of its own frame.

    range_min, range_max: metres. field_of_view_rad: of its bundle of beams.
    """

    def __init__(self, sensor: RaySensor, rng: np.random.Generator) -> None:
        """Aim the beams. rng: source of the noise."""
        self.range_min, self.range_max = sensor.range_min_m, sensor.range_max_m
        axes = (sensor.horizontal, sensor.vertical)
        self.field_of_view_rad = max(axis.max_angle_rad - axis.min_angle_rad for axis in axes)
        self._sensor = sensor
        self._directions = all_directions(sensor).reshape(-1, 3)
        self._rng = rng

    def read(self, rays: Rays, pose: Pose, own_model: str | None = None) -> float:
        """Return the range in metres by REP-117: +inf nothing met, -inf too close. pose: in the world."""
        directions = self._directions @ pose.rotation.astype(np.float32).T
        true = rays.cast(np.array(pose.position_m), directions, reach_m(self._sensor), own_model)
        return float(measured(true.min(keepdims=True), self._sensor, self._rng)[0])
