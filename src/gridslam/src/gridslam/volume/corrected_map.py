"""A map of voxels that follows its path: by definition what the clouds kept with the path's nodes give."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam.errors import ScanError
from gridslam.volume.board import Board, Rays
from gridslam.volume.clouds import KeptCloud, Pose, rounded
from gridslam.volume.correction.events import Event, clear_box
from gridslam.volume.correction.settled_events import SettledEvents
from gridslam.volume.nodes import ClearedBox, CloudNode, NodeSpacing, TouchedTiles, shift_of
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.transient import TransientLayer
from gridslam.volume.voxel_map import Box, VoxelMap

POINTS_MAX = 4_000_000
"""Of a cloud."""
MOVED_VOXELS = 0.5
"""A node is moved in the map when the end of a ray of median length moves by more than this."""


class CorrectedMap:
    """Voxels of the kept clouds, and of those between them for a short time.

    Args:
        parameters: of the voxels.
        spacing: of the clouds that are kept.
        base: an earlier map to begin with; it is no part of the path, and no loop moves it.
    """

    def __init__(
        self,
        parameters: VolumeParameters,
        spacing: NodeSpacing | None = None,
        base: VoxelMap | None = None,
    ):
        self.parameters = parameters
        self.spacing = spacing or NodeSpacing()
        self.base = base
        self.voxels = VoxelMap(parameters) if base is None else base.copy()
        """What the events give, in their order."""
        self.transient = TransientLayer(parameters)
        self.events: list[Event] = []
        self.generation = 0
        """How many times a correction was taken over, or the map began anew."""
        self.settled: list[SettledEvents] = []
        """The fewest events first. Used by corrections only."""
        self._board = Board()
        self._last: CloudNode | None = None

    @property
    def nodes(self) -> list[CloudNode]:
        """The path's nodes."""
        return [event for event in self.events if isinstance(event, CloudNode)]

    def asks_for(self, stamp_s: float, sensor_in_odom: Pose) -> bool:
        """Return whether a cloud from a sensor's pose in odom would be kept with a node."""
        return self.spacing.asks_for(stamp_s, sensor_in_odom, self._last)

    def add(self, stamp_s: float, points: np.ndarray, sensor_in_odom: Pose, odom_in_map: Pose) -> bool:
        """Take in a cloud (n, 3) of the sensor's frame; return whether it is kept with a node.

        Raises:
            ScanError: the cloud has too many points, or none that can be used.
            MapError: map or cloud would be too large.
        """
        if len(points) > POINTS_MAX:
            raise ScanError(
                f"A cloud of {len(points)} points is too large; thin it to {POINTS_MAX} or fewer."
            )
        resolution_m = self.parameters.resolution_m
        exact = rounded(points, resolution_m)
        if not len(exact):
            raise ScanError("A cloud has no point with finite x, y and z.")
        sensor_in_map = odom_in_map @ sensor_in_odom
        rays = self._rays(sensor_in_map, exact)
        thinned = exact[self._board.thinned(rays, resolution_m)]
        rays = self._rays(sensor_in_map, thinned)
        self.transient.insert(stamp_s, rays, self._board)
        if not self.asks_for(stamp_s, sensor_in_odom):
            return False
        cloud = KeptCloud.of(thinned, resolution_m)
        reach_m = float(np.median(np.linalg.norm(rays.ends - rays.origin, axis=1)))
        node = CloudNode(stamp_s, cloud, sensor_in_odom, sensor_in_map, reach_m)
        node.touched = TouchedTiles.of(rays.low, self.voxels.insert(rays, self._board))
        self.events.append(node)
        self._last = node
        return True

    def _rays(self, sensor_in_map: Pose, points: np.ndarray) -> Rays:
        return self.voxels.rays(sensor_in_map.translation, sensor_in_map.of_points(points))

    def clear(self, box: Box) -> None:
        """Set all known voxels of a box free."""
        clear_box(self.voxels, box)
        self.events.append(ClearedBox(box))
        self.transient.forget()

    def reset(self) -> None:
        """Begin anew, without an earlier map."""
        self.base, self.voxels = None, VoxelMap(self.parameters)
        self.settled = []
        self.transient.forget()
        self.events, self._last = [], None
        self.generation += 1

    def go_on(self, voxels: VoxelMap, events: Sequence[Event]) -> None:
        """Go on with events and the voxels that they gave on the base."""
        self.voxels, self.events = voxels, list(events)
        nodes = self.nodes
        self._last = nodes[-1] if nodes else None

    def take_over(self, other: CorrectedMap) -> None:
        """Become another map of the same parameters, which nobody uses from now on."""
        self.base, self.voxels, self.settled = other.base, other.voxels, other.settled
        self.spacing, self.events, self._last = other.spacing, other.events, other._last
        self.transient.forget()
        self.generation += 1

    def moved(self, poses: Sequence[Pose]) -> np.ndarray:
        """Return which nodes (n,) must move to reach the poses (n,) of their sensors in the map."""
        limit_m = MOVED_VOXELS * self.parameters.resolution_m
        shifts = [shift_of(node, pose) for node, pose in zip(self.nodes, poses)]
        return np.array(shifts, float) > limit_m
