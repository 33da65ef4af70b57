"""The complete state of a corrected map, to go on with it: in a node that died, or in the next flight."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gridslam.files import state_file
from gridslam.volume.clouds import KeptCloud, Pose
from gridslam.volume.corrected_map import CorrectedMap
from gridslam.volume.correction.events import Event
from gridslam.volume.nodes import ClearedBox, CloudNode, NodeSpacing, TouchedTiles
from gridslam.volume.octree.stream import map_from, stream_of
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.path_poses import OdometryHistory
from gridslam.volume.saved.map_time import Flight, MapTime
from gridslam.volume.tile_table import Box
from gridslam.volume.voxel_map import VoxelMap


@dataclass(frozen=True, eq=False)
class NodeState:
    """A node with its cloud. Poses are (3, 4): rotation and translation.

    Raises:
        ValueError: it makes no sense.
    """

    stamp_s: float
    packed: np.ndarray
    count: int
    step_m: float
    sensor_in_odom: np.ndarray
    sensor_in_map: np.ndarray
    reach_m: float
    low: np.ndarray
    shape: tuple[int, ...]
    bits: np.ndarray

    def __post_init__(self) -> None:
        for pose in (self.sensor_in_odom, self.sensor_in_map):
            if pose.shape != (3, 4) or not np.isfinite(pose).all():
                raise ValueError("a node's pose is none")
        tiles = int(np.prod(self.shape))
        if self.low.shape != (3,) or len(self.shape) != 3 or 8 * len(self.bits) < tiles:
            raise ValueError("a node's tiles are none")

    @classmethod
    def of(cls, node: CloudNode) -> NodeState:
        """Return a node's state."""
        assert node.touched is not None  # it is in the map
        return cls(
            node.stamp_s,
            np.frombuffer(node.cloud.packed, np.uint8),
            node.cloud.count,
            node.cloud.step_m,
            _as_array(node.sensor_in_odom),
            _as_array(node.sensor_in_map),
            node.reach_m,
            np.asarray(node.touched.low, np.int64),
            tuple(int(side) for side in node.touched.shape),
            node.touched.bits,
        )

    def node(self) -> CloudNode:
        """Return the node.

        Raises:
            ValueError, zlib.error: its cloud is damaged.
        """
        cloud = KeptCloud(self.packed.tobytes(), self.count, self.step_m)
        cloud.points()  # or a correction would find the damage, in flight
        touched = TouchedTiles(self.low, self.shape, self.bits)
        return CloudNode(
            self.stamp_s,
            cloud,
            _as_pose(self.sensor_in_odom),
            _as_pose(self.sensor_in_map),
            self.reach_m,
            touched,
        )


@dataclass(frozen=True, eq=False)
class ClearedState:
    """A box (3,), (3,) of voxels that somebody has set free."""

    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, eq=False)
class VolumeState:
    """A `CorrectedMap` and what its path is corrected with.

    voxels, base: the data of their octrees. stamps_s (n,), poses (n, 4): the odometry's history. offsets_s:
    of the flights, see `MapTime`.
    """

    parameters: VolumeParameters
    spacing: NodeSpacing
    voxels: np.ndarray
    base: np.ndarray | None
    events: list[NodeState | ClearedState]
    stamps_s: np.ndarray
    poses: np.ndarray
    flights: list[Flight]
    newest_s: float


SAVED_CLASSES = (ClearedState, Flight, NodeSpacing, NodeState, VolumeParameters, VolumeState)
"""If you change the fields of one, count up `state_file.FORMAT`."""


class Restored(NamedTuple):
    """What a state gives."""

    corrected: CorrectedMap
    history: OdometryHistory
    time: MapTime


def state_of(corrected: CorrectedMap, history: OdometryHistory, time: MapTime) -> VolumeState:
    """Return the state. What was seen within the last seconds, and is of no node, is not in it."""
    stamps_s, poses = history.arrays()
    return VolumeState(
        corrected.parameters,
        corrected.spacing,
        _octree_of(corrected.voxels),
        None if corrected.base is None else _octree_of(corrected.base),
        [_state_of_event(event) for event in corrected.events],
        stamps_s,
        poses,
        list(time.flights),
        float(time.newest_s),
    )


def restored(state: VolumeState) -> Restored:
    """Return the map of a state, and what it is corrected with.

    Raises:
        MapError, ValueError, zlib.error: the state is damaged.
    """
    base = None if state.base is None else map_from(state.base.tobytes(), False, state.parameters)
    corrected = CorrectedMap(state.parameters, state.spacing, base)
    events = [each.node() if isinstance(each, NodeState) else _cleared(each) for each in state.events]
    corrected.go_on(map_from(state.voxels.tobytes(), False, state.parameters), events)
    if not state.flights:
        raise ValueError("it knows no flight")
    return Restored(
        corrected, OdometryHistory.of(state.stamps_s, state.poses), MapTime(state.flights, state.newest_s)
    )


def write_volume(state: VolumeState, path: str | Path) -> None:
    """Write a state; raises StateError if that fails. A kill leaves the old file or the new one."""
    state_file.write(state, path, is_packed=True)


def read_volume(path: str | Path) -> Restored:
    """Return what a file holds.

    Raises:
        StateError: the file cannot be read, is damaged, or holds something else.
    """

    def build(state: object) -> Restored:
        if not isinstance(state, VolumeState):
            raise ValueError("it holds no map of voxels")
        return restored(state)

    return state_file.read(path, build, SAVED_CLASSES)


def _octree_of(voxels: VoxelMap) -> np.ndarray:
    return np.frombuffer(stream_of(voxels, is_binary=False).data, np.uint8)


def _state_of_event(event: Event) -> NodeState | ClearedState:
    if isinstance(event, CloudNode):
        return NodeState.of(event)
    return ClearedState(np.asarray(event.box.low, np.int64), np.asarray(event.box.high, np.int64))


def _cleared(state: ClearedState) -> ClearedBox:
    if state.low.shape != (3,) or state.high.shape != (3,):
        raise ValueError("a cleared box is none")
    return ClearedBox(Box(state.low, state.high))


def _as_array(pose: Pose) -> np.ndarray:
    return np.column_stack((pose.rotation, pose.translation)).astype(float)


def _as_pose(array: np.ndarray) -> Pose:
    return Pose(array[:, :3].copy(), array[:, 3].copy())
