"""Clouds, octrees, markers and grids as messages."""

from __future__ import annotations

import io
import struct
from typing import Callable, TypeVar

import numpy as np
from geometry_msgs.msg import Point
from nav_msgs.msg import OccupancyGrid
from octomap_msgs.msg import Octomap
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from gridslam import PoseError, ScanError
from gridslam.volume import FREE, OCCUPIED, Box, OctreeStream, ShownMap
from gridslam.volume.kernels.tiles import SIDE
from gridslam_ros.conversions import NumpyGridMessage
from node_tools import clouds

Read = TypeVar("Read")
TREE = "OcTree"
VOXELS_MAX = 50_000_000
"""Of a box that somebody asks for."""
FREE_COLOUR = (0.0, 1.0, 0.0, 0.3)


def readable(read: Callable[[PointCloud2], Read], message: PointCloud2) -> Read:
    """Return what is read of a cloud. Raises ScanError if it cannot be read."""
    try:
        return read(message)
    except clouds.CloudError as error:
        raise ScanError(str(error)) from None


def cloud_of(points: np.ndarray, header: Header) -> PointCloud2:
    """Return points (n, 3), m, as a message."""
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    return PointCloud2(
        header=header,
        height=1,
        width=len(points),
        fields=fields,
        point_step=12,
        row_step=12 * len(points),
        data=np.ascontiguousarray(points, "<f4").tobytes(),
        is_dense=True,
    )


class PackedOctomap(Octomap):
    """An octree whose data are bytes; rospy would send a list number by number."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message."""
        data = self.data
        empty = io.BytesIO()
        Octomap(self.header, self.binary, self.id, self.resolution, []).serialize(empty)
        buff.write(empty.getvalue()[:-4] + struct.pack("<I", len(data)) + bytes(data))


def octomap_of(octree: OctreeStream, resolution_m: float, header: Header) -> Octomap:
    """Return an octree as a message for a topic."""
    return PackedOctomap(header, octree.is_binary, TREE, resolution_m, octree.data)


def octomap_answer(octree: OctreeStream, resolution_m: float, header: Header) -> Octomap:
    """Return an octree as a part of a service's answer, whose parts rospy writes itself."""
    data = np.frombuffer(octree.data, np.int8).tolist()
    return Octomap(header, octree.is_binary, TREE, resolution_m, data)


class PackedMarkers(MarkerArray):
    """Cubes of one list, whose centres and colours are arrays; rospy would send them number by number."""

    def __init__(self, marker: Marker, centres: np.ndarray, colours: np.ndarray) -> None:
        super().__init__([marker])
        self._points = np.ascontiguousarray(centres, "<f8")
        self._colours = np.ascontiguousarray(colours, "<f4")

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message."""
        empty = io.BytesIO()
        super().serialize(empty)
        # Behind the points: the lengths of points, colours, text and mesh, and one flag, all zero
        head, tail = empty.getvalue()[:-17], empty.getvalue()[-9:]
        points = struct.pack("<I", len(self._points)) + self._points.tobytes()
        colours = struct.pack("<I", len(self._colours)) + self._colours.tobytes()
        buff.write(head + points + colours + tail)


def markers_of(shown: ShownMap, kind: int, header: Header, z_range_m: tuple[float, float]) -> MarkerArray:
    """Return the voxels of a kind within heights as cubes; occupied ones have the colour of their height."""
    centres = shown.centres(kind)
    half = shown.resolution_m / 2.0
    centres = centres[(centres[:, 2] + half > z_range_m[0]) & (centres[:, 2] - half < z_range_m[1])]
    marker = Marker(header=header, ns=header.frame_id, type=Marker.CUBE_LIST, action=Marker.ADD)
    if not len(centres):  # RViz calls a list without cubes an error, and shows the display's name in red
        marker.action = Marker.DELETE
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = shown.resolution_m
    marker.color = ColorRGBA(*FREE_COLOUR) if kind == FREE else ColorRGBA(0.0, 0.0, 1.0, 1.0)
    colours = height_colours(centres[:, 2]) if kind == OCCUPIED else np.zeros((0, 4))
    return PackedMarkers(marker, centres, colours)


def height_colours(heights_m: np.ndarray) -> np.ndarray:
    """Return colours (n, 4) from blue, at the least height, to red at the greatest."""
    if not len(heights_m):
        return np.zeros((0, 4))
    low, high = float(heights_m.min()), float(heights_m.max())
    share = (heights_m - low) / max(high - low, 1e-9)
    channels = [np.clip(1.5 - np.abs(4.0 * share - middle), 0.0, 1.0) for middle in (3.0, 2.0, 1.0)]
    return np.stack([*channels, np.ones_like(share)], axis=1)


def projected_map(shown: ShownMap, header: Header, z_range_m: tuple[float, float]) -> OccupancyGrid:
    """Return the voxels within heights seen from above: occupied wins, then free."""
    tiles = shown.known_tiles()
    low_xy = tiles[:, :2].min(axis=0) if len(tiles) else np.zeros(2, np.int64)
    size = (tiles[:, :2].max(axis=0) + 1 - low_xy) * SIDE if len(tiles) else np.zeros(2, np.int64)
    kinds = np.zeros((size[1], size[0]), np.uint8)
    heights = np.arange(SIDE)
    for (x, y, z), index in zip(tiles.tolist(), shown.indices(tiles).tolist()):
        bottoms_m = (z * SIDE + heights) * shown.resolution_m
        meant = (bottoms_m + shown.resolution_m > z_range_m[0]) & (bottoms_m < z_range_m[1])
        if meant.any():
            row, column = (y - low_xy[1]) * SIDE, (x - low_xy[0]) * SIDE
            part = kinds[row : row + SIDE, column : column + SIDE]
            np.maximum(part, shown.kinds[index].reshape(SIDE, SIDE, SIDE)[meant].max(axis=0), out=part)
    message = NumpyGridMessage(header=header, data=np.array((-1, 0, 100), np.int8)[kinds].ravel())
    message.info.map_load_time = header.stamp
    message.info.resolution = shown.resolution_m
    message.info.height, message.info.width = kinds.shape
    message.info.origin.position = Point(*(low_xy * SIDE * shown.resolution_m).tolist(), 0.0)
    message.info.origin.orientation.w = 1.0
    return message


def box_of(low: Point, high: Point, resolution_m: float) -> Box:
    """Return the voxels that a box between two corners meets.

    Raises:
        PoseError: the corners are not finite, in the wrong order, or too far apart.
    """
    corners = np.array(((low.x, low.y, low.z), (high.x, high.y, high.z)))
    if not np.isfinite(corners).all() or not (corners[0] <= corners[1]).all() or np.abs(corners).max() > 1e6:
        raise PoseError(f"The box from {corners[0].tolist()} to {corners[1].tolist()} m makes no sense.")
    voxels = np.floor(corners / resolution_m).astype(np.int64)
    return Box(voxels[0], voxels[1] + 1)


def require_moderate(box: Box) -> None:
    """Raise PoseError if a box has too many voxels for one answer."""
    size = np.asarray(box.high) - np.asarray(box.low)
    if np.prod(size.astype(float)) > VOXELS_MAX:
        raise PoseError(f"A box of {' x '.join(map(str, size.tolist()))} voxels is too large; ask for parts.")
