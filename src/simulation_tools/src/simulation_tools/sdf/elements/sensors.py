"""The sensors of SDF, and the plugins that add to them."""

from __future__ import annotations

from dataclasses import dataclass, field

from simulation_tools.geometry import Pose


@dataclass(frozen=True)
class Plugin:
    """A ``<plugin>`` as the file has it; the code that knows its name reads it.

    parameters: stripped text of each child element by its path (``"motorNumber"``, ``"control/kp"``).
    line: where it stands in the file, for messages.
    """

    name: str
    filename: str
    parameters: dict[str, str] = field(default_factory=dict)
    line: int = 0


@dataclass(frozen=True)
class Noise:
    """Gaussian noise."""

    mean: float = 0.0
    stddev: float = 0.0


NO_NOISE = Noise()


@dataclass(frozen=True)
class ScanAxis:
    """Beams of a lidar about one axis: samples from min_angle_rad to max_angle_rad, both included."""

    samples: int
    min_angle_rad: float
    max_angle_rad: float

    @property
    def increment_rad(self) -> float:
        """Angle between neighbouring beams; zero when there is only one."""
        return (self.max_angle_rad - self.min_angle_rad) / (self.samples - 1) if self.samples > 1 else 0.0


@dataclass(frozen=True)
class RaySensor:
    """A lidar (``ray`` or ``gpu_ray``). pose: in the link frame; beams lie in its x-y plane.

    range_resolution_m: ranges are rounded to it, 0: not at all. update_rate_hz: 0 means every step.
    sees_what_is_drawn: as a ``gpu_ray``, in place of the collision shapes.
    """

    name: str
    pose: Pose
    update_rate_hz: float
    horizontal: ScanAxis
    vertical: ScanAxis
    range_min_m: float
    range_max_m: float
    range_resolution_m: float = 0.0
    noise: Noise = NO_NOISE
    plugins: tuple[Plugin, ...] = ()
    sees_what_is_drawn: bool = False


@dataclass(frozen=True)
class ImuSensor:
    """An inertial measurement unit. pose: in the link frame. Noise about x, y, z in rad/s and m/s2."""

    name: str
    pose: Pose
    update_rate_hz: float
    gyroscope_noise: tuple[Noise, Noise, Noise] = (NO_NOISE,) * 3
    accelerometer_noise: tuple[Noise, Noise, Noise] = (NO_NOISE,) * 3
    plugins: tuple[Plugin, ...] = ()


@dataclass(frozen=True)
class CameraSensor:
    """A camera (depth: a depth camera). pose: in the link frame, looking along x with z up."""

    name: str
    pose: Pose
    update_rate_hz: float
    depth: bool
    width: int
    height: int
    horizontal_fov_rad: float
    near_m: float
    far_m: float
    noise: Noise = NO_NOISE
    plugins: tuple[Plugin, ...] = ()


@dataclass(frozen=True)
class AirPressureSensor:
    """A barometer. pose: in the link frame. Noise in pascal.

    reference_altitude_m: altitude of the world's origin.
    """

    name: str
    pose: Pose
    update_rate_hz: float
    reference_altitude_m: float = 0.0
    noise: Noise = NO_NOISE
    plugins: tuple[Plugin, ...] = ()


Sensor = RaySensor | ImuSensor | CameraSensor | AirPressureSensor
