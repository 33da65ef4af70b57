"""The further sensors of a UAV: range finders, cameras, barometers, three-dimensional lidars.

A sensor measures only if somebody reads it when it is due. Each has its own random stream, so reading one
sensor does not change the others.
"""

from __future__ import annotations

from typing import Callable

import numpy as np

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import CameraSensor, Link, Model, RaySensor, Sensor
from simulation_tools.sensors.schedule import Schedule
from simulation_tools.simulation.sensor_kinds import Device, Reading, Surroundings, kind_of
from simulation_tools.vehicle.uav import MountedSensor, Uav, mounted
from simulation_tools.world.rays import RayScene
from simulation_tools.world.world import PhysicsWorld


class PayloadError(SimulationToolsError):
    """The further sensors of a UAV contradict each other."""


class PayloadSensor:
    """One sensor at its place. device: what measures; its class tells the kind of the readings.

    name: of the sensor in the SDF. mount: where it is, and its frame.
    """

    def __init__(
        self, mount: MountedSensor, device: Device, look: Callable[[MountedSensor], Reading]
    ) -> None:
        self.name = mount.sensor.name
        self.mount = mount
        self.device = device
        self.schedule = Schedule(mount.sensor.update_rate_hz)
        self._look = look
        self._shared: tuple[int, Reading] | None = None

    def read(self) -> Reading:
        """Return what the sensor measures now."""
        return self._look(self.mount)

    def shared(self) -> Reading:
        """Return the reading of the instant at which the sensor was due: the same one for all who ask."""
        if self._shared is None or self._shared[0] != self.schedule.due_us:
            self._shared = self.schedule.due_us, self.read()
        return self._shared[1]


def payload_sensors(
    uav: Uav,
    world: PhysicsWorld,
    place: Callable[[MountedSensor], Pose],
    rng: Callable[[str], np.random.Generator],
) -> tuple[PayloadSensor, ...]:
    """Return the further sensors of a UAV.

    place: returns a sensor's present pose in the world. rng: returns the random stream of a sensor's name.
    """

    def payload_sensor(link: Link, sensor: Sensor) -> PayloadSensor:
        kind = kind_of(sensor)
        assert kind is not None
        device, read = kind.make(sensor, rng(sensor.name)), kind.read

        def look(mount: MountedSensor) -> Reading:
            return read(device, Surroundings(world, scene_of(world, sensor), uav.model.name), place(mount))

        return PayloadSensor(mounted(link, sensor), device, look)

    return tuple(payload_sensor(*pair) for pair in further_sensors(uav))


def further_sensors(uav: Uav) -> list[tuple[Link, Sensor]]:
    """Return (link, sensor) of all sensors measured on demand; PayloadError if two have the same name."""
    found = [pair for pair in _sensors(uav.model) if kind_of(pair[1])]
    names = [sensor.name for _, sensor in found]
    for name in names:
        if names.count(name) > 1:
            raise PayloadError(
                f'{uav.model.source}: Two sensors are called "{name}", as their topics are; rename one.'
            )
    return found


def unsimulated(uav: Uav) -> tuple[str, ...]:
    """Return a sentence for each flat lidar besides the first: the simulator has one scan."""
    first = uav.lidar.sensor if uav.lidar else None
    return tuple(
        f'{uav.model.source}: The lidar "{sensor.name}" is not simulated: a UAV has one scan.'
        for _, sensor in _sensors(uav.model)
        if isinstance(sensor, RaySensor) and not kind_of(sensor) and sensor is not first
    )


def has_camera(model: Model) -> bool:
    """Whether a model carries a camera for colours. It needs a world with visual shapes."""
    return any(not camera.depth for _, camera in model.sensors(CameraSensor))


def sees_visuals(model: Model) -> bool:
    """Whether a model carries a depth camera or a lidar that sees what is drawn."""
    cameras, lidars = model.sensors(CameraSensor), model.sensors(RaySensor)
    return any(one.depth for _, one in cameras) or any(one.sees_what_is_drawn for _, one in lidars)


def scene_of(world: PhysicsWorld, sensor: Sensor) -> RayScene:
    """Return what a lidar sees: collision shapes, or as a ``gpu_ray`` what is drawn."""
    is_gpu_ray = isinstance(sensor, RaySensor) and sensor.sees_what_is_drawn
    return world.visuals if is_gpu_ray and world.visuals is not None else world.rays


def _sensors(model: Model) -> list[tuple[Link, Sensor]]:
    return [(link, sensor) for link in model.links for sensor in link.sensors]
