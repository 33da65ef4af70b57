"""Publishes what a map shows, by octomap_server's names, while somebody listens."""

from __future__ import annotations

from typing import Any, Callable

import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid
from octomap_msgs.msg import Octomap
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from gridslam.msg import VoxelTiles
from gridslam.volume import FREE, OCCUPIED, Box, CorrectedMap, ShownMap, stream_of
from gridslam.volume.kernels.tiles import SIDE
from gridslam_ros.volume import messages
from gridslam_ros.volume.layers import Layers
from gridslam_ros.volume.parameters import OctomapParameters

STEPS = 255
"""Of a distance in ~distances."""
QUEUE = 500
"""Changes that may wait for a listener that is busy: those of 100 s."""


class OctomapPublisher(rospy.SubscribeListener):
    """Topics of the whole map are latched. One is made when the map has changed, and for a new subscriber.

    Args:
        parameters: of the node.
        wake: is called when somebody new listens.
    """

    def __init__(self, parameters: OctomapParameters, wake: Callable[[], None]):
        super().__init__()
        self._parameters, self._wake = parameters, wake
        self._z_range_m = (parameters.occupancy_min_z, parameters.occupancy_max_z)
        self._resolution_m = parameters.volume.resolution_m
        self._asked: set[str] = set()
        self._topics = {
            name: rospy.Publisher(name, kind, queue_size=1, latch=True, subscriber_listener=self)
            for name, kind in (
                ("octomap_binary", Octomap),
                ("octomap_full", Octomap),
                ("occupied_cells_vis_array", MarkerArray),
                ("free_cells_vis_array", MarkerArray),
                ("octomap_point_cloud_centers", PointCloud2),
                ("projected_map", OccupancyGrid),
                ("~frontiers", PointCloud2),
                ("~unknown", PointCloud2),
            )
        }
        # Boxes add up, so each new listener gets all once, and none may be lost
        self._updates, self._distances = (
            rospy.Publisher(name, VoxelTiles, queue_size=QUEUE, subscriber_listener=self)
            for name in ("~updates", "~distances")
        )
        self._has_changed = False
        """Whether the map has, since the topics of the whole map were published."""

    def peer_subscribe(self, topic_name: str, *_: Any) -> None:
        """Note a new subscriber."""
        self._asked.add(topic_name)
        self._wake()

    @property
    def is_asked(self) -> bool:
        """Whether somebody new listens."""
        return bool(self._asked)

    @property
    def has_followers(self) -> bool:
        """Whether somebody follows the map box by box."""
        return self._updates.get_num_connections() > 0 or self._distances.get_num_connections() > 0

    def publish(self, corrected: CorrectedMap, layers: Layers, stamp: rospy.Time, is_whole: bool) -> None:
        """Publish what is new, to whom it may concern. is_whole: also the topics of the whole map."""
        asked, self._asked = self._asked, set()
        layers.refresh(corrected)
        changed, renewed = layers.take_changes()
        header = Header(stamp=stamp, frame_id=self._parameters.frame("frame_id"))
        self._has_changed = self._has_changed or len(changed) > 0
        for name, topic in self._topics.items():
            has_news = is_whole and (self._has_changed or name == "octomap_full")
            if (has_news and topic.get_num_connections() > 0) or topic.resolved_name in asked:
                topic.publish(self._message(name, corrected, layers, header))
        self._has_changed = self._has_changed and not is_whole
        if self._updates.get_num_connections():
            if self._updates.resolved_name in asked:
                changed = layers.shown.known_tiles()
            if len(changed):
                self._updates.publish(self._tiles(layers.shown, changed, layers.shown.kinds, 0.0, header))
        if self._distances.get_num_connections():
            self._publish_distances(layers, renewed, header, self._distances.resolved_name in asked)

    def _message(self, name: str, corrected: CorrectedMap, layers: Layers, header: Header) -> Any:
        shown = layers.shown
        if name == "octomap_binary":
            return messages.octomap_of(shown.octree(), self._resolution_m, header)
        if name == "octomap_full":
            return messages.octomap_of(stream_of(corrected.voxels, False), self._resolution_m, header)
        if name == "occupied_cells_vis_array":
            return messages.markers_of(shown, OCCUPIED, header, self._z_range_m)
        if name == "free_cells_vis_array":
            kind = FREE if self._parameters.publish_free_space else 255  # of which there is none
            return messages.markers_of(shown, kind, header, self._z_range_m)
        if name == "octomap_point_cloud_centers":
            centres, half = shown.centres(OCCUPIED), self._resolution_m / 2.0
            low, high = self._z_range_m
            inside = (centres[:, 2] + half > low) & (centres[:, 2] - half < high)
            return messages.cloud_of(centres[inside], header)
        if name == "projected_map":
            return messages.projected_map(shown, header, self._z_range_m)
        if name == "~unknown":
            return messages.cloud_of(layers.frontiers.unknown_centres(shown), header)
        return messages.cloud_of(layers.frontiers.centres(), header)

    def _publish_distances(self, layers: Layers, renewed: np.ndarray, header: Header, is_new: bool) -> None:
        field = layers.distances
        tiles = layers.shown.known_tiles() if is_new else renewed
        if not len(tiles):
            return
        steps = np.rint(np.sqrt(np.arange(field.reach**2 + 1)) * STEPS / field.reach).astype(np.uint8)
        cubes = steps[field.squares[field.indices(tiles)]]
        unit = field.reach * self._resolution_m / STEPS
        self._distances.publish(self._tiles(None, tiles, cubes, unit, header))

    def _tiles(
        self, shown: ShownMap | None, tiles: np.ndarray, cubes: np.ndarray, unit: float, header: Header
    ) -> VoxelTiles:
        voxels = cubes if shown is None else cubes[shown.indices(tiles)]
        return VoxelTiles(header, self._resolution_m, SIDE, tiles.ravel().tolist(), unit, voxels.tobytes())


def inside(points: np.ndarray, box: Box, resolution_m: float) -> np.ndarray:
    """Return those of points (n, 3), m, that lie in a box of voxels."""
    low, high = np.asarray(box.low) * resolution_m, np.asarray(box.high) * resolution_m
    return points[((points >= low) & (points < high)).all(axis=1)]
