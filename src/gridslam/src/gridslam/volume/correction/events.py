"""What changes a map of voxels for good, in its order: kept clouds, and boxes that somebody cleared."""

from __future__ import annotations

import numpy as np

from gridslam.volume.board import Board
from gridslam.volume.clouds import Pose
from gridslam.volume.kernels.tiles import SIDE_BITS
from gridslam.volume.nodes import ClearedBox, CloudNode, TouchedTiles
from gridslam.volume.voxel_map import Box, VoxelMap

Event = CloudNode | ClearedBox


def insert_event(voxels: VoxelMap, event: Event, pose: Pose | None, board: Board) -> TouchedTiles | None:
    """Enter an event into a map, a cloud from its sensor's pose. Return the tiles that the cloud touches."""
    if isinstance(event, ClearedBox):
        clear_box(voxels, event.box)
        return None
    sensor_in_map = event.sensor_in_map if pose is None else pose
    rays = voxels.rays(sensor_in_map.translation, sensor_in_map.of_points(event.cloud.points()))
    return TouchedTiles.of(rays.low, voxels.insert(rays, board))


def clear_box(voxels: VoxelMap, box: Box) -> None:
    """Give all known voxels of a box the least probability."""
    places = voxels.known_places()
    tiles = places[:, ::-1] + voxels.corner
    low, high = np.asarray(box.low), np.asarray(box.high)
    inside = ((tiles >= low >> SIDE_BITS) & (tiles <= (high - 1) >> SIDE_BITS)).all(axis=1)
    voxels.stamp += 1
    arrays, side = voxels.pool.tiles, 1 << SIDE_BITS
    for tile, place in zip(tiles[inside], places[inside]):
        index = voxels.table[tuple(place)]
        cube = voxels.pool.cubes[index].reshape(side, side, side)
        first, last = np.maximum(low - tile * side, 0), np.minimum(high - tile * side, side)
        part = cube[first[2] : last[2], first[1] : last[1], first[0] : last[0]]
        part[~np.isnan(part)] = voxels.parameters.model.low
        arrays.written[index] = arrays.turned[index] = voxels.stamp
