"""Makes the map of a corrected path beside the one in service, and then takes it over."""

from __future__ import annotations

from typing import Callable, Sequence

import numpy as np

from gridslam.volume.board import Board
from gridslam.volume.clouds import Pose
from gridslam.volume.corrected_map import CorrectedMap
from gridslam.volume.correction.events import insert_event
from gridslam.volume.correction.settled_events import PackedVoxels, SettledEvents
from gridslam.volume.kernels.tiles import SIDE, UNSEEN
from gridslam.volume.nodes import CloudNode, TouchedTiles
from gridslam.volume.voxel_map import VoxelMap

UNSETTLED = (600, 300, 60)
"""So many events of the latest may still move: by the closure of a long loop, of a short one, and often."""
AT_ONCE = 256
"""Tiles that are compared at once: more would need memory in proportion."""


class Rebuilding:
    """Events entered one by one into the tiles that a correction may change.

    ``step`` and ``settle`` may run in another thread than the map's own methods. ``take_over`` may not.

    Args:
        corrected: the map, which goes on meanwhile.
        poses: of the sensors of its present nodes in the map.
    """

    def __init__(self, corrected: CorrectedMap, poses: Sequence[Pose]):
        self._corrected = corrected
        self._generation = corrected.generation
        nodes = corrected.nodes
        are_moved = corrected.moved(poses)
        self.moved = int(np.count_nonzero(are_moved))
        """Number of nodes that move."""
        self._poses = {id(node): pose for node, pose, moves in zip(nodes, poses, are_moved) if moves}
        self._touched: dict[int, TouchedTiles] = {}
        self._settled = corrected.settled = [
            each for each in corrected.settled if self._are_settled(each.count, nodes, are_moved)
        ]
        self._next, self._board = self._settled[-1].count if self._settled else 0, Board()
        self._shadow = VoxelMap(corrected.parameters)
        self._low, self._are_open = _tiles_around(
            [node for node, moves in zip(nodes, are_moved) if moves],
            self._poses,
            corrected.parameters.resolution_m,
        )
        self._open_tiles()

    def _are_settled(self, count: int, nodes: Sequence[CloudNode], are_moved: np.ndarray) -> bool:
        """Return whether no node among the first events moves."""
        settled = [each for each in self._corrected.events[:count] if isinstance(each, CloudNode)]
        return not are_moved[: len(settled)].any() and settled == list(nodes[: len(settled)])

    def _open_tiles(self) -> None:
        """Let the shadow hold the settled events' voxels in the tiles that may change, and none elsewhere."""
        shadow, shape = self._shadow, np.array(self._are_open.shape[::-1])
        if not shape.all():
            return
        shadow.cover(self._low, self._low + shape)
        are_open = np.zeros(shadow.table.shape, bool)
        x, y, z = self._low - shadow.corner
        are_open[z : z + shape[2], y : y + shape[1], x : x + shape[0]] = self._are_open
        voxels = self._settled[-1].voxels.unpacked() if self._settled else self._corrected.base
        if voxels is not None and voxels.table.size:
            shadow.take_tiles(voxels, are_open)
        shadow.close_outside(are_open)

    @property
    def is_due(self) -> bool:
        """Whether events are left to enter."""
        return self.moved > 0 and self._next < len(self._corrected.events)

    @property
    def progress(self) -> tuple[int, int]:
        """Number of events that are entered, and of all."""
        return self._next, len(self._corrected.events)

    def step(self) -> None:
        """Enter the next event."""
        event = self._corrected.events[self._next]
        self._next += 1
        if isinstance(event, CloudNode) and id(event) not in self._poses and not self._meets(event):
            return
        touched = insert_event(self._shadow, event, self._poses.get(id(event)), self._board)
        if touched is not None and id(event) in self._poses:
            self._touched[id(event)] = touched

    def _meets(self, node: CloudNode) -> bool:
        """Return whether the cloud of a node that does not move touches a tile that may change."""
        touched = node.touched
        if touched is None:
            return True
        low, size = touched.low - self._low, np.array(touched.shape[::-1])
        first, last = np.maximum(low, 0), np.minimum(low + size, self._are_open.shape[::-1])
        if not (last > first).all():
            return False
        here, there = first - low, last - low
        its = touched.unpacked()[here[2] : there[2], here[1] : there[1], here[0] : there[0]]
        return bool((its & self._are_open[first[2] : last[2], first[1] : last[1], first[0] : last[0]]).any())

    def take_over(self) -> None:
        """Enter what is left, and put the corrected tiles into the map's service."""
        corrected = self._corrected
        if corrected.generation != self._generation:  # it began anew meanwhile
            return
        while self.is_due:
            self.step()
        for node in corrected.nodes:
            if id(node) in self._poses:
                node.sensor_in_map, node.touched = self._poses[id(node)], self._touched[id(node)]
        if self.moved:
            _replace(corrected.voxels, self._shadow)
            corrected.transient.forget()
            corrected.generation += 1

    def settle(self, goes_on: Callable[[], bool] = lambda: True) -> None:
        """Enter all but the latest events among the settled ones, after they have been taken over.

        goes_on: asked before each event; if not, the rest is left to a later correction.
        """
        events = self._corrected.events
        for number, unsettled in enumerate(UNSETTLED):
            if number == len(self._settled):
                self._settled.append(self._next_settled())
            settled = self._settled[number]
            waiting = events[settled.count : max(len(events) - unsettled, 0)]
            if not settled.enter(waiting, self._board, lambda: self._is_current and goes_on()):
                return

    def _next_settled(self) -> SettledEvents:
        """Return what the last settled events, or else the earlier map, go on as."""
        if self._settled:
            return SettledEvents(self._settled[-1].voxels, self._settled[-1].count)
        base = self._corrected.base
        return SettledEvents(PackedVoxels.of(VoxelMap(self._corrected.parameters) if base is None else base))

    @property
    def _is_current(self) -> bool:
        """Whether the map still begins its corrections behind these settled events."""
        return self._corrected.settled is self._settled


def _tiles_around(
    nodes: Sequence[CloudNode], poses: dict[int, Pose], resolution_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return what clouds may touch before and after a move: the least tile, and bool (d, h, w) from it."""
    if not nodes:
        return np.zeros(3, np.int64), np.zeros((0, 0, 0), bool)
    margin = max(_margin(node, poses[id(node)], SIDE * resolution_m) for node in nodes)
    touched = [node.touched for node in nodes if node.touched is not None]
    low = np.min([each.low for each in touched], axis=0) - margin
    high = np.max([each.low + each.shape[::-1] for each in touched], axis=0) + margin
    are_open = np.zeros((high - low)[::-1], bool)
    for each in touched:
        x, y, z = each.low - low
        depth, height, width = each.shape
        are_open[z : z + depth, y : y + height, x : x + width] |= each.unpacked()
    from scipy import ndimage  # 10 MB, and a replay without clouds needs none

    return low, ndimage.maximum_filter(are_open, 2 * margin + 1, mode="constant")


def _margin(node: CloudNode, pose: Pose, tile_m: float) -> int:
    """Return by how many tiles a node's longest ray may reach farther when its sensor moves to a pose."""
    assert node.touched is not None
    way_m = float(np.linalg.norm(pose.translation - node.sensor_in_map.translation))
    longest_m = float(np.linalg.norm(node.touched.shape)) * tile_m
    return int((way_m + longest_m * pose.turn_from(node.sensor_in_map)) / tile_m) + 2


def _replace(voxels: VoxelMap, shadow: VoxelMap) -> None:
    """Put the open tiles of a shadow into a map. Stamps tell which of them differ."""
    shape = np.array(shadow.table.shape[::-1])
    voxels.cover(shadow.corner, shadow.corner + shape)
    x, y, z = shadow.corner - voxels.corner
    table = voxels.table[z : z + shape[2], y : y + shape[1], x : x + shape[0]]
    voxels.stamp += 1
    new = (shadow.table > UNSEEN) & (table == UNSEEN)
    table[new] = voxels.pool.take(np.count_nonzero(new), voxels.stamp)
    places = np.argwhere((shadow.table >= UNSEEN) & (table > UNSEEN))
    arrays = voxels.pool.tiles
    for first in range(0, len(places), AT_ONCE):
        at = tuple(places[first : first + AT_ONCE].T)
        tiles, theirs = table[at], shadow.table[at]
        before, after = voxels.pool.cubes[tiles], shadow.pool.cubes[theirs]
        gone = np.isnan(before) != np.isnan(after)
        changed = gone | ((before != after) & ~np.isnan(after))
        turned = gone | ((before >= 0.0) != (after >= 0.0))
        arrays.written[tiles[changed.any(axis=1)]] = voxels.stamp
        arrays.turned[tiles[turned.any(axis=1)]] = voxels.stamp
        voxels.pool.copy(tiles, shadow.pool, theirs)
