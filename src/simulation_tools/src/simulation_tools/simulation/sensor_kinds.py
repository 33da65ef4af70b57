"""The kinds of further sensors: how each is known in SDF, what measures, and what it needs to know.

A new kind is one class that measures, in `simulation_tools.sensors`, one entry of `KINDS`, and its message in
`MESSAGES` of the node's `payload_output.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, NamedTuple

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import AirPressureSensor, CameraSensor, RaySensor, Sensor
from simulation_tools.sensors.barometer import Barometer
from simulation_tools.sensors.camera import Camera
from simulation_tools.sensors.cloud import Cloud, CloudLidar
from simulation_tools.sensors.range_finder import RangeFinder
from simulation_tools.vehicle.uav import RANGE_PLUGIN
from simulation_tools.world.rays import RayScene
from simulation_tools.world.world import PhysicsWorld

Reading = float | Cloud | np.ndarray
Device = RangeFinder | CloudLidar | Camera | Barometer


class Surroundings(NamedTuple):
    """What a sensor may look at. rays: what its beams meet. own_model: name of the UAV, which they pass."""

    world: PhysicsWorld
    rays: RayScene
    own_model: str


@dataclass(frozen=True)
class SensorKind:
    """One kind of sensors.

    is_one: whether a sensor of the SDF is of this kind. make: (sensor, random stream) -> what measures.
    read: (what measures, surroundings, the sensor's pose in the world) -> reading.
    """

    is_one: Callable[[Sensor], bool]
    make: Callable[[Any, np.random.Generator], Device]
    read: Callable[[Any, Surroundings, Pose], Reading]


def kind_of(sensor: Sensor) -> SensorKind | None:
    """Return the kind of a further sensor; None for another one, as the flat lidar and the IMU."""
    return next((kind for kind in KINDS if kind.is_one(sensor)), None)


def _is_range_finder(sensor: Sensor) -> bool:
    return isinstance(sensor, RaySensor) and any(one.filename == RANGE_PLUGIN for one in sensor.plugins)


def _gives_clouds(sensor: Sensor) -> bool:
    return isinstance(sensor, RaySensor) and sensor.vertical.samples > 1 and not _is_range_finder(sensor)


def _by_rays(device: RangeFinder | CloudLidar, around: Surroundings, pose: Pose) -> Reading:
    return device.read(around.rays, pose, around.own_model)


KINDS = (
    SensorKind(_is_range_finder, RangeFinder, _by_rays),
    SensorKind(_gives_clouds, CloudLidar, _by_rays),
    SensorKind(
        lambda sensor: isinstance(sensor, CameraSensor),
        Camera,
        lambda camera, around, pose: camera.read(around.world, pose),
    ),
    SensorKind(
        lambda sensor: isinstance(sensor, AirPressureSensor),
        Barometer,
        lambda barometer, around, pose: barometer.read(pose),
    ),
)
"""At most one of them is true of a sensor."""
