"""The UAV that flies: a model of the model path, with the lidar of choice on its back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Callable, Generic, Sequence, TypeVar

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import DEFAULT_INERTIAL, ImuSensor, Link, Model, RaySensor, Sensor
from simulation_tools.sdf.frames import attach, root_link
from simulation_tools.sdf.parser import PathLike, load_model
from simulation_tools.sdf.uri import MODEL_PATH_VARIABLE, model_path_from_environment, shipped_models

LIDARS = ("urg", "ust", "utm", "puck", "tim", "m8")
"""The lidars of thesis tables 8.2 and D.1. Each is a model `lidar_<name>`; a user's own lidar is one, too."""

NO_LIDAR = ("", "none")
RANGE_PLUGIN = "libgazebo_ros_range.so"
"""A ray sensor with this plugin is a range finder, as in Gazebo."""

LIDAR_MOUNT = "lidar_mount"
"""The link of a UAV that carries the lidar."""


class UavError(SimulationToolsError):
    """The UAV cannot be put together."""


SensorKind = TypeVar("SensorKind", bound=Sensor)


@dataclass(frozen=True)
class MountedSensor(Generic[SensorKind]):
    """A sensor and where it is mounted.

    frame: TF name. pose: of the sensor in the model frame, all joints at zero. link: that carries it.
    """

    sensor: SensorKind
    frame: str
    pose: Pose
    link: str


@dataclass(frozen=True)
class Uav:
    """A model ready to fly. lidar, imu: its first ones, None when it has none."""

    model: Model
    lidar: MountedSensor[RaySensor] | None
    imu: MountedSensor[ImuSensor] | None


def load_uav(
    model: str,
    lidar: str | None = None,
    model_path: Sequence[PathLike] | None = None,
    range_max_m: float = 0.0,
    sensors: Sequence[str] = (),
    noise_factor: float = 1.0,
) -> Uav:
    """Load a UAV, put a lidar on its link `lidar_mount` and further sensors on its first link.

    model: a name, a model:// uri, a folder or an SDF file. lidar: one of `LIDARS`, or NAME for another model
    lidar_NAME; None: the model as it is. range_max_m: replaces the lidar's own range when it is positive.
    sensors: further models (range_finder, camera, ...); their SDF says where they are mounted. noise_factor:
    times the lidar's noise. model_path: folders of models; None: those of ``GAZEBO_MODEL_PATH``, and a name
    that this package has means this package's model. Raises SdfError or UavError.
    """

    def load(name: str) -> Model:
        return load_model(_location(name, model_path is None), model_path)

    carrier = load(model)
    if lidar is not None:
        if not is_lidar(lidar, model_path):
            raise UavError(
                f'There is no lidar "{lidar}"; choose one of {", ".join(LIDARS)}, '
                f"or put a model lidar_{lidar} into a folder of {MODEL_PATH_VARIABLE}."
            )
        carrier = attach(carrier, load(f"lidar_{lidar}"), _lidar_mount(carrier))
    if range_max_m > 0.0:
        carrier = with_lidar_range(carrier, range_max_m)
    if noise_factor != 1.0:
        carrier = with_lidar_noise(carrier, noise_factor)
    for sensor in sensors:
        carrier = attach(carrier, load(sensor), root_link(carrier).name)
    imus = [mounted(link, imu) for link, imu in carrier.sensors(ImuSensor)]
    return Uav(carrier, _first_lidar(carrier), imus[0] if imus else None)


def is_lidar(name: str, model_path: Sequence[PathLike] | None = None) -> bool:
    """Tell whether the model path has a model `lidar_<name>`."""
    folders = model_path_from_environment() if model_path is None else model_path
    return Path(name).name == name and any(Path(folder, f"lidar_{name}").is_dir() for folder in folders)


def with_lidar_range(model: Model, range_max_m: float) -> Model:
    """Return the model with another greatest range of all its lidars, metres."""

    def changed(sensor: RaySensor) -> RaySensor:
        if range_max_m <= sensor.range_min_m:
            raise UavError(
                f"A lidar's range_max of {range_max_m:g} m must be above its "
                f"range_min of {sensor.range_min_m:g} m."
            )
        return replace(sensor, range_max_m=range_max_m)

    return _with_lidars(model, changed)


def with_lidar_noise(model: Model, factor: float) -> Model:
    """Return the model with the noise of all its lidars multiplied by a factor."""

    def changed(sensor: RaySensor) -> RaySensor:
        return replace(sensor, noise=replace(sensor.noise, stddev=factor * sensor.noise.stddev))

    return _with_lidars(model, changed)


def _with_lidars(model: Model, change: Callable[[RaySensor], RaySensor]) -> Model:
    def changed(sensor: Sensor) -> Sensor:
        return change(sensor) if isinstance(sensor, RaySensor) else sensor

    links = tuple(replace(link, sensors=tuple(map(changed, link.sensors))) for link in model.links)
    return replace(model, links=links)


def _location(model: str, prefers_shipped: bool) -> str:
    """Return a model's uri or folder. A bare name means a model of this package, or else of the model path.

    prefers_shipped: a model of the same name before it on the path, as PX4's iris, does not replace this
    package's; ``model://iris`` means that one.
    """
    if "/" in model or model.endswith(".sdf"):
        return model
    shipped = shipped_models() / model
    return str(shipped) if prefers_shipped and shipped.is_dir() else f"model://{model}"


def _lidar_mount(carrier: Model) -> str:
    """Return the name of the link for the lidar; it may be that of a UAV inside the model."""
    names = [link.name for link in carrier.links]
    inner = (name for name in names if name.endswith(f"::{LIDAR_MOUNT}"))
    return LIDAR_MOUNT if LIDAR_MOUNT in names else next(inner, LIDAR_MOUNT)


def remarks_on(name: str, uav: Model) -> tuple[str, ...]:
    """Return a sentence on each thing about a UAV that its user may not expect. name: as the user gave it."""
    said = [
        f'{uav.source}: The link "{link.name}" has no <inertia>, so SDF\'s 1 kg m2 about each axis counts. '
        "A UAV with it hardly turns."
        for link in uav.links
        if link.inertial.moments_kg_m2 == DEFAULT_INERTIAL.moments_kg_m2 and not uav.static
    ]
    others = [folder / name for folder in model_path_from_environment() if folder != shipped_models()]
    shadow = next((other for other in others if other.is_dir() and "/" not in name), None)
    if shadow is not None and Path(uav.source).is_relative_to(shipped_models()):
        said.append(f'The UAV is this package\'s "{name}", not {shadow}, which model:=model://{name} takes.')
    return tuple(said)


def _first_lidar(model: Model) -> MountedSensor[RaySensor] | None:
    """Return the lidar whose scan is published: the first flat one, else the first one."""
    lidars = [
        (link, sensor)
        for link, sensor in model.sensors(RaySensor)
        if all(plugin.filename != RANGE_PLUGIN for plugin in sensor.plugins)
    ]
    lidars.sort(key=lambda pair: pair[1].vertical.samples > 1)
    return mounted(*lidars[0]) if lidars else None


def mounted(link: Link, sensor: SensorKind) -> MountedSensor[SensorKind]:
    """Return a sensor with the place that its link gives it."""
    return MountedSensor(sensor, sensor_frame(link, sensor), link.pose @ sensor.pose, link.name)


def sensor_frame(link: Link, sensor: Sensor) -> str:
    """Name of a sensor's frame: the link's when they coincide, as they do in the shipped models."""
    return link.name if sensor.pose == Pose.identity() else f"{link.name}/{sensor.name}"
