"""Makes the map of voxels of a bag's clouds along a path that is known already."""

from __future__ import annotations

import argparse
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
from tqdm import tqdm

from gridslam import MapError, SlamError
from gridslam.volume import CorrectedMap, Pose, VolumeParameters, stream_of, write_octree
from gridslam.volume.path_poses import PathCorrections
from gridslam_ros.bags import POINT_CLOUD, BagError, first_of, open_bag, read_raw, topic_of
from gridslam_ros.volume.frames import CloudFrames
from gridslam_ros.volume.moving_lidar import MovingLidar
from node_tools.bags import DAMAGE

ENDINGS = {".bt": True, ".ot": False}
"""Whether a file is binary."""
WAITING_MAX = 100
"""Clouds that wait for TF."""


@dataclass(frozen=True)
class VolumeRequest:
    """A map of voxels to make.

    file: .bt or .ot. cloud: topic. resolution_m: of the voxels. range_m: a longer ray is free up to here.
    sensor_frame: of the lidar, if the clouds are in a frame that the vehicle does not carry.

    Raises:
        MapError: the file's ending is another one, or its folder is missing.
        ParameterError: resolution or range make no sense.
    """

    file: Path
    cloud: str = "/cloud"
    resolution_m: float = 0.1
    range_m: float = 30.0
    sensor_frame: str = ""

    def __post_init__(self) -> None:
        if self.file.suffix not in ENDINGS:
            raise MapError(f"{self.file}: a map of voxels is a file .bt or .ot.")
        if not self.file.parent.is_dir() or self.file.is_dir():
            raise MapError(f"{self.file}: cannot be written; check its folder.")
        self.parameters()

    def parameters(self) -> VolumeParameters:
        """Return the map's parameters."""
        return VolumeParameters(resolution_m=self.resolution_m, max_range_m=self.range_m)


def add_volume_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the map of voxels."""
    parser.add_argument("--volume", type=Path, metavar="MAP.bt", help="map of voxels to write, .bt or .ot")
    for name, default, meaning in (
        ("--cloud", VolumeRequest.cloud, "topic of its clouds"),
        ("--resolution", VolumeRequest.resolution_m, "side of its voxels, m"),
        ("--max-range", VolumeRequest.range_m, "a longer ray is free up to here, m"),
        ("--sensor-frame", VolumeRequest.sensor_frame, "the lidar's frame, if its clouds are in the map's"),
    ):
        kind: type = type(default)
        parser.add_argument(name, type=kind, default=default, help=f"{meaning} (default: %(default)s)")


def volume_request(given: argparse.Namespace) -> VolumeRequest | None:
    """Return the map of voxels that is asked for.

    Raises:
        SlamError: it makes no sense.
    """
    if given.volume is None:
        return None
    return VolumeRequest(given.volume, given.cloud, given.resolution, given.max_range, given.sensor_frame)


class BagVolume:
    """Reads the clouds of a bag that become nodes of the map, each at its corrected pose.

    Args:
        request: what to make.
        frames: names of the odometry's and the vehicle's frames.
        corrections: of odometry, along the path.
        say: is called with a sentence when something is odd.
    """

    def __init__(
        self,
        request: VolumeRequest,
        frames: tuple[str, str],
        corrections: PathCorrections,
        say: Callable[[str], None],
    ):
        odom_frame, base_frame = frames
        self._request, self._corrections, self._say = request, corrections, say
        self._map = CorrectedMap(request.parameters())
        self._frames = CloudFrames(odom_frame, odom_frame, base_frame, request.sensor_frame)
        self._lidar = MovingLidar(self._frames, request.range_m, say)
        self._waiting: deque[PointCloud2] = deque()
        self._last_s = -float("inf")
        self.clouds, self.without_tf = 0, 0

    def make(self, path: str) -> dict:
        """Read a bag, write the map, and return figures about it.

        Raises:
            BagError: the bag is damaged, or has no such clouds, or none can be used.
            MapError: the file cannot be written.
        """
        with open_bag(path) as bag:
            topic = topic_of(bag, self._request.cloud, POINT_CLOUD)
            total = bag.get_message_count(topic)
            self._lidar.readings.look_ahead(first_of(bag, topic, POINT_CLOUD))
            try:
                with tqdm(total=total, unit="cloud", desc=self._request.file.name, mininterval=0.2) as bar:
                    for name, data in read_raw(bag, {topic: PointCloud2}, self._say):
                        if name == topic:
                            bar.update()
                            self._offer(PointCloud2().deserialize(data))
                        else:
                            self._frames.add(TFMessage().deserialize(data).transforms, "static" in name)
                        self._enter_known()
            except DAMAGE as error:
                raise BagError(f"The bag {path} is damaged ({error}).") from None
        self.without_tf += len(self._waiting)
        return self._write(total)

    def _offer(self, cloud: PointCloud2) -> None:
        stamp_s = cloud.header.stamp.to_sec()
        if stamp_s < self._last_s - 1.0:  # the clock went back, and SLAM began anew, too
            self._map.reset()
            self._frames.forget()
            self._waiting.clear()
        self._last_s = stamp_s
        self._waiting.append(cloud)
        if len(self._waiting) > WAITING_MAX:
            self._waiting.popleft()
            self.without_tf += 1

    def _enter_known(self) -> None:
        """Enter the clouds whose poses TF knows. Older ones than these are without TF."""
        for cloud in tuple(self._waiting):
            try:
                poses = self._frames.sensor(cloud.header.frame_id, cloud.header.stamp)
                if poses is None or not self._lidar.is_complete(cloud):
                    continue
                self._enter(cloud, poses[0])
            except SlamError as error:
                self._say(f"{error} The cloud at {cloud.header.stamp.to_sec():.3f} s is left out.")
            while self._waiting[0] is not cloud:
                self._waiting.popleft()
                self.without_tf += 1
            self._waiting.popleft()

    def _enter(self, cloud: PointCloud2, sensor_in_odom: Pose) -> None:
        stamp_s = cloud.header.stamp.to_sec()
        if not self._corrections.cover(stamp_s) or not self._map.asks_for(stamp_s, sensor_in_odom):
            return
        self._map.add(stamp_s, self._lidar.points_of(cloud), sensor_in_odom, self._corrections.at(stamp_s))
        self.clouds += 1

    def _write(self, total: int) -> dict:
        if not self.clouds:
            raise BagError(
                f"None of the {total} clouds on {self._request.cloud} could be used: {self.without_tf} are "
                "without TF, the others not along SLAM's path."
            )
        octree = stream_of(self._map.voxels, ENDINGS[self._request.file.suffix])
        write_octree(self._request.file, octree, self._request.resolution_m)
        return {
            "file": str(self._request.file),
            "clouds_read": total,
            "clouds_without_tf": self.without_tf,
            "clouds_integrated": self.clouds,
            "resolution_m": self._request.resolution_m,
        }
