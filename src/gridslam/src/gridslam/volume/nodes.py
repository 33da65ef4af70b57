"""Nodes of the path with their clouds, and what else changes a map for good."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError
from gridslam.volume.clouds import KeptCloud, Pose
from gridslam.volume.voxel_map import Box


@dataclass(frozen=True)
class NodeSpacing:
    """How far the sensor moves or turns, or how much time passes, from one cloud that is kept to the next.

    Raises:
        ParameterError: a value is not above 0.
    """

    distance_m: float = limited(0.25, above=0.0, most=math.inf)
    """Way of the sensor, m."""
    angle_rad: float = limited(math.radians(5.0), above=0.0, most=math.inf)
    """Turn of the sensor, rad."""
    period_s: float = limited(1.0, above=0.0, most=math.inf)
    """Time, s."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "{} between kept clouds")

    def asks_for(self, stamp_s: float, pose: Pose, last: CloudNode | None) -> bool:
        """Return whether a cloud from a sensor's pose in odom is to be kept, given the last one that was."""
        if last is None or not 0.0 <= stamp_s - last.stamp_s < self.period_s:
            return True
        way_m = np.linalg.norm(pose.translation - last.sensor_in_odom.translation)
        return bool(way_m >= self.distance_m or pose.turn_from(last.sensor_in_odom) >= self.angle_rad)


@dataclass(frozen=True, eq=False)
class TouchedTiles:
    """The tiles that a cloud has written to."""

    low: np.ndarray
    """(3,) least tile, x, y, z."""
    shape: tuple[int, ...]
    """Tiles along z, y, x."""
    bits: np.ndarray
    """Packed, in the order z, y, x."""

    @classmethod
    def of(cls, low: np.ndarray, are_touched: np.ndarray) -> TouchedTiles:
        """Return the tiles of an array (d, h, w) of bool that begins at a tile."""
        return cls(low, are_touched.shape, np.packbits(are_touched))

    def unpacked(self) -> np.ndarray:
        """Return them as an array (d, h, w) of bool."""
        size = int(np.prod(self.shape))
        return np.unpackbits(self.bits, count=size).view(bool).reshape(self.shape)


@dataclass(eq=False)
class CloudNode:
    """A place on the path with its cloud."""

    stamp_s: float
    cloud: KeptCloud
    sensor_in_odom: Pose
    """As odometry told it then; it never changes."""
    sensor_in_map: Pose
    """The pose with which the cloud is in the map."""
    reach_m: float
    """Median length of the cloud's rays."""
    touched: TouchedTiles | None = field(default=None, repr=False)


@dataclass(frozen=True, eq=False)
class ClearedBox:
    """A box in which somebody has set all known voxels free."""

    box: Box


def shift_of(node: CloudNode, pose: Pose) -> float:
    """Return how far, at most, the end of a ray of median length moves with a node's sensor to a pose, m."""
    way_m = float(np.linalg.norm(pose.translation - node.sensor_in_map.translation))
    return way_m + node.reach_m * pose.turn_from(node.sensor_in_map)
