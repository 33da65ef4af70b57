"""Readers of ``<sensor>``."""

from __future__ import annotations

import math
from typing import Callable

from simulation_tools.geometry import Pose
from simulation_tools.sdf.checks import NOT_NEGATIVE, POSITIVE, whole_number
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import (
    NO_NOISE,
    AirPressureSensor,
    CameraSensor,
    ImuSensor,
    Noise,
    RaySensor,
    ScanAxis,
    Sensor,
)
from simulation_tools.sdf.plugins import read_plugins

MAX_BEAMS = 100_000  # of one lidar: five times those of a 128-channel scanner
MAX_PIXELS = 8192
ROUNDED_RAD = 0.01
"""By which a full circle may be too large: files say 3.1416 or 6.29 for it."""
ON_GPU = "gpu_ray", "gpu_lidar"
"""Types of lidars that see what is drawn. Gazebo's successor calls them by the second name."""


def read_sensor(node: Node, pose: Pose) -> Sensor:
    """Read a sensor of a type that `is_supported`.

    pose: the sensor's in its link's frame, resolved by the caller.
    """
    reader = _READERS[node.attribute("type")]
    node.accept("always_on", "visualize", "topic")
    return reader(node, pose)


def is_supported(node: Node) -> bool:
    """Whether `read_sensor` knows this sensor's type."""
    return node.attribute("type") in _READERS


def _read_ray(node: Node, pose: Pose) -> RaySensor:
    ray = node.one_of("ray", "lidar")
    scan = ray.required("scan")
    horizontal = _read_axis(scan.required("horizontal"))
    vertical_node = scan.child("vertical")
    vertical = ScanAxis(1, 0.0, 0.0) if vertical_node is None else _read_axis(vertical_node)
    if horizontal.samples * vertical.samples > MAX_BEAMS:
        raise scan.error(
            f"The lidar has {horizontal.samples * vertical.samples} beams; at most {MAX_BEAMS} are allowed"
        )
    limits = ray.required("range")
    least, greatest = limits.value("min", 0.0, NOT_NEGATIVE), limits.required_value("max", POSITIVE)
    if least >= greatest:
        raise limits.error(
            f"The least range ({least:g} m) must be smaller than the greatest ({greatest:g} m)"
        )
    return RaySensor(
        name=node.attribute("name"),
        pose=pose,
        update_rate_hz=node.value("update_rate", 0.0, NOT_NEGATIVE),
        horizontal=horizontal,
        vertical=vertical,
        range_min_m=least,
        range_max_m=greatest,
        range_resolution_m=limits.value("resolution", 0.0, NOT_NEGATIVE),
        noise=_read_noise(ray.child("noise")),
        plugins=read_plugins(node),
        sees_what_is_drawn=node.attribute("type") in ON_GPU,
    )


def _read_axis(node: Node) -> ScanAxis:
    samples = int(node.required_value("samples", whole_number(1, MAX_BEAMS)))
    low, high = node.required_value("min_angle"), node.required_value("max_angle")
    # In SDF a resolution other than 1 interpolates more beams between the measured ones.
    node.accept_value("resolution", "1", "1.0")
    if samples > 1 and low >= high:
        raise node.error(f"<min_angle> ({low:g}) must be smaller than <max_angle> ({high:g})")
    if high - low > 2.0 * math.pi + ROUNDED_RAD:
        raise node.error(f"The beams span {high - low:g} rad, more than a circle")
    return ScanAxis(samples, low, high)


def _read_noise(node: Node | None) -> Noise:
    if node is None:
        return NO_NOISE
    kind = node.child("type")
    name = node.attribute("type", "") or (kind.text if kind is not None else "none")
    if name == "none":
        node.accept("mean", "stddev")
        return NO_NOISE
    if not name.startswith("gaussian"):
        raise node.error(f'Noise of type "{name}" is not supported; use gaussian')
    return Noise(node.value("mean", 0.0), node.value("stddev", 0.0, NOT_NEGATIVE))


def _read_imu(node: Node, pose: Pose) -> ImuSensor:
    gyroscope = accelerometer = (NO_NOISE,) * 3
    imu = node.child("imu")
    if imu is not None:
        old = imu.child("noise") if node.document.version < (1, 6) else None
        gyroscope = _read_three_axes(imu.child("angular_velocity"), old, "rate")
        accelerometer = _read_three_axes(imu.child("linear_acceleration"), old, "accel")
    return ImuSensor(
        node.attribute("name"),
        pose,
        node.value("update_rate", 0.0, NOT_NEGATIVE),
        gyroscope,
        accelerometer,
        read_plugins(node),
    )


def _read_three_axes(node: Node | None, old: Node | None, kind: str) -> tuple[Noise, Noise, Noise]:
    """Return the noise of three axes. old: that of all axes, as it stands before SDF 1.6, under its kind."""
    if node is None:
        return (NO_NOISE if old is None else _read_old_noise(old, kind),) * 3
    axes = (node.child(tag) for tag in ("x", "y", "z"))
    x, y, z = (NO_NOISE if axis is None else _read_noise(axis.child("noise")) for axis in axes)
    return x, y, z


def _read_old_noise(node: Node, kind: str) -> Noise:
    """Return the noise of an IMU of SDF 1.5 and older: one type, and two kinds of numbers."""
    name, numbers = node.child("type"), node.child(kind)
    if name is not None and name.text == "none":
        return NO_NOISE
    if name is not None and not name.text.startswith("gaussian"):
        raise name.error(f'Noise of type "{name.text}" is not supported; use gaussian')
    if numbers is None:
        return NO_NOISE
    return Noise(numbers.value("mean", 0.0), numbers.value("stddev", 0.0, NOT_NEGATIVE))


def _read_camera(node: Node, pose: Pose) -> CameraSensor:
    camera = node.required("camera")
    image, clip = camera.child("image"), camera.child("clip")
    if image is None:
        camera.note("The <camera> has no <image>: SDF's default of 320 x 240 pixels counts")
        image = camera  # which holds no <width> and <height>
    image.accept("format")
    pixels = whole_number(1, MAX_PIXELS)
    near = 0.1 if clip is None else clip.value("near", 0.1, POSITIVE)
    far = 100.0 if clip is None else clip.value("far", 100.0, POSITIVE)
    if near >= far:
        where = clip or camera
        raise where.error(f"The near plane ({near:g} m) must be closer than the far one ({far:g} m)")
    return CameraSensor(
        name=node.attribute("name"),
        pose=pose,
        update_rate_hz=node.value("update_rate", 0.0, NOT_NEGATIVE),
        depth=node.attribute("type") in ("depth", "depth_camera"),
        width=int(image.value("width", 320.0, pixels)),
        height=int(image.value("height", 240.0, pixels)),
        horizontal_fov_rad=camera.value("horizontal_fov", 1.047, POSITIVE),
        near_m=near,
        far_m=far,
        noise=_read_noise(camera.child("noise")),
        plugins=read_plugins(node),
    )


def _read_air_pressure(node: Node, pose: Pose) -> AirPressureSensor:
    settings = node.child("air_pressure")
    altitude, noise = 0.0, NO_NOISE
    if settings is not None:
        altitude = settings.value("reference_altitude", 0.0)
        pressure = settings.child("pressure")
        noise = _read_noise(pressure.child("noise")) if pressure is not None else NO_NOISE
    return AirPressureSensor(
        node.attribute("name"),
        pose,
        node.value("update_rate", 0.0, NOT_NEGATIVE),
        altitude,
        noise,
        read_plugins(node),
    )


_READERS: dict[str, Callable[[Node, Pose], Sensor]] = {
    "ray": _read_ray,
    "gpu_ray": _read_ray,
    "lidar": _read_ray,
    "gpu_lidar": _read_ray,
    "imu": _read_imu,
    "camera": _read_camera,
    "depth": _read_camera,
    "depth_camera": _read_camera,
    "air_pressure": _read_air_pressure,
}
