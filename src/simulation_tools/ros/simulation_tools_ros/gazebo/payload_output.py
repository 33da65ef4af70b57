"""Topics of the further sensors, named like the sensors. A sensor measures only if it has subscribers."""

from __future__ import annotations

from typing import Any, Callable, Sequence

import numpy as np
from sensor_msgs.msg import CameraInfo, FluidPressure, Image, PointCloud2, PointField, Range
from std_msgs.msg import Header

from simulation_tools.camera.optics import CameraOptics
from simulation_tools.sdf.frames import optical_frame
from simulation_tools.sensors.barometer import Barometer
from simulation_tools.sensors.camera import Camera
from simulation_tools.sensors.cloud import Cloud, CloudLidar
from simulation_tools.sensors.range_finder import RangeFinder
from simulation_tools.simulation.payload import PayloadError, PayloadSensor
from simulation_tools_ros.conversions import stamp

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("ring", "<u2"), ("padding", "<u2")])
"""Memory layout of a point in a cloud's message."""


class PayloadOutput:
    """Publishes what the further sensors of a UAV measure; all calls come from the simulation's thread.

    advertise: (topic, message class) -> publisher. prefix: goes before the frames of the model.

    Raises:
        PayloadError: a sensor has no entry in MESSAGES.
    """

    def __init__(self, sensors: Sequence[PayloadSensor], advertise: Callable, prefix: str = "") -> None:
        self._prefix = prefix
        self._publish = {sensor.name: self._publisher_of(sensor, advertise) for sensor in sensors}

    def publish(self, time_us: int, due: Sequence[PayloadSensor]) -> None:
        """Publish the sensors that are due and have subscribers."""
        for sensor in due:
            self._publish[sensor.name](time_us, sensor)

    def _publisher_of(self, sensor: PayloadSensor, advertise: Callable) -> Callable:
        """Return the function that publishes a sensor's readings."""
        device, name, frame = sensor.device, sensor.name, self._prefix + sensor.mount.frame
        if isinstance(device, Camera):
            frame = self._prefix + optical_frame(f"{sensor.mount.link}/{name}")
            image, info = advertise(f"{name}/image_raw", Image), advertise(f"{name}/camera_info", CameraInfo)
            points = advertise(f"{name}/points", PointCloud2) if device.depth else None
            return _camera(frame, image, info, points, device)
        if type(device) not in MESSAGES:
            raise PayloadError(
                f"The sensor {name} has no message; enter its class {type(device).__name__} in MESSAGES of "
                "simulation_tools_ros/gazebo/payload_output.py."
            )
        message_class, make = MESSAGES[type(device)]
        topic = advertise(name, message_class)
        message: Any = None

        def publish(time_us: int, sensor: PayloadSensor) -> None:
            nonlocal message
            if not topic.get_num_connections():
                return
            if message is None or message.header.stamp != stamp(time_us):
                message = make(Header(stamp=stamp(time_us), frame_id=frame), sensor.read(), device)
            # Lockstep publishes the first instant until it is answered. A new reading each time would leave
            # the noise of all later ones to chance.
            topic.publish(message)

        return publish


def _camera(frame: str, image: Any, info: Any, points: Any, camera: Camera) -> Callable:
    """Return the function that publishes a camera's picture and optics with one stamp.

    points: publisher of a depth camera's cloud, or None.
    """

    def publish(time_us: int, sensor: PayloadSensor) -> None:
        header = Header(stamp=stamp(time_us), frame_id=frame)
        if info.get_num_connections():
            info.publish(camera_info_message(header, camera))
        wants_points = points is not None and points.get_num_connections()
        if not (wants_points or image.get_num_connections()):
            return
        picture: Any = sensor.read()
        if image.get_num_connections():
            image.publish(image_message(header, picture))
        if wants_points:
            points.publish(depth_cloud_message(header, picture, camera))

    return publish


def range_message(header: Header, range_m: float, finder: RangeFinder) -> Range:
    """Return a sensor_msgs/Range; +inf and -inf by REP-117."""
    return Range(
        header=header,
        radiation_type=Range.INFRARED,
        field_of_view=finder.field_of_view_rad,
        min_range=finder.range_min,
        max_range=finder.range_max,
        range=range_m,
    )


def pressure_message(header: Header, pressure_pa: float, barometer: Barometer) -> FluidPressure:
    """Return a sensor_msgs/FluidPressure."""
    return FluidPressure(header=header, fluid_pressure=pressure_pa, variance=barometer.stddev_pa**2)


def cloud_message(header: Header, cloud: Cloud, _lidar: CloudLidar | None = None) -> PointCloud2:
    """Return a sensor_msgs/PointCloud2 of x, y, z and ring, without beams that hit nothing."""
    points = np.zeros(len(cloud.rings), POINT)
    for column, name in enumerate("xyz"):
        points[name] = cloud.points_m[:, column]
    points["ring"] = cloud.rings
    fields = [PointField(name, 4 * column, PointField.FLOAT32, 1) for column, name in enumerate("xyz")]
    return PointCloud2(
        header=header,
        height=1,
        width=len(points),
        fields=[*fields, PointField("ring", 12, PointField.UINT16, 1)],
        is_bigendian=False,
        point_step=POINT.itemsize,
        row_step=POINT.itemsize * len(points),
        data=points.tobytes(),
        is_dense=True,
    )


def image_message(header: Header, picture: np.ndarray) -> Image:
    """Return a sensor_msgs/Image: rgb8 of colours, 32FC1 (metres, REP-118) of depths."""
    height, width = picture.shape[:2]
    return Image(
        header=header,
        height=height,
        width=width,
        encoding="32FC1" if picture.ndim == 2 else "rgb8",
        is_bigendian=0,
        step=picture.strides[0],
        data=picture.tobytes(),
    )


def depth_cloud_message(header: Header, depths_m: np.ndarray, camera: Camera) -> PointCloud2:
    """Return the points of a depth camera's picture (height, width), in its optical frame.

    A pixel that shows nothing is a point of NaN, as in depth_image_proc.
    """
    (height, width), (cx, cy) = depths_m.shape, camera.centre_px
    z = np.where(np.isfinite(depths_m), depths_m, np.nan)
    x = (np.arange(width) - cx) / camera.focal_px * z
    y = (np.arange(height)[:, None] - cy) / camera.focal_px * z
    points = np.stack([x, y, z], axis=-1).astype("<f4")
    return PointCloud2(
        header=header,
        height=height,
        width=width,
        fields=[PointField(name, 4 * column, PointField.FLOAT32, 1) for column, name in enumerate("xyz")],
        is_bigendian=False,
        point_step=12,
        row_step=12 * width,
        data=points.tobytes(),
        is_dense=bool(np.isfinite(points).all()),
    )


def camera_info_message(header: Header, camera: Camera | CameraOptics) -> CameraInfo:
    """Return a sensor_msgs/CameraInfo of a pinhole without distortion."""
    f, (cx, cy) = camera.focal_px, camera.centre_px
    return CameraInfo(
        header=header,
        height=camera.height,
        width=camera.width,
        distortion_model="plumb_bob",
        D=[0.0] * 5,
        K=[f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0],
        R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P=[f, 0.0, cx, 0.0, 0.0, f, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


MESSAGES: dict[type, tuple[type, Callable]] = {
    RangeFinder: (Range, range_message),
    CloudLidar: (PointCloud2, cloud_message),
    Barometer: (FluidPressure, pressure_message),
}
"""By what measures: the class of its message, and the function (header, reading, device) that makes one."""
