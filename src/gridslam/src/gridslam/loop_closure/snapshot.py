"""Stage 1, the snapshot: path, scans and odometry of a filter at one moment. Nobody changes it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam.level_cloud import LevelCloud
from gridslam.maps.new_map import ALL_HEIGHTS, Band, MapDraft
from gridslam.maps.newest_scans import NewestScan, placed
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

ARRAYS = ("stamps_s", "poses_in_map", "odometry", "heights_m", "is_usable")


@dataclass(frozen=True, eq=False)
class Snapshot:
    """What a filter knows of its path. A node is a processed scan. The arrays are copies, and read-only.

    Raises:
        ValueError: the arrays are not of one length.
    """

    stamps_s: np.ndarray
    """(k,) s, of the nodes."""
    poses_in_map: np.ndarray
    """(k, 3) the best particle's path: x, y in m and yaw in rad."""
    odometry: np.ndarray
    """(k, 3) pose of the base in the odometry's frame, at the nodes."""
    heights_m: np.ndarray
    """(k,) of the base in the map, at the nodes; NaN: not known."""
    scans: tuple[PlanarScan, ...]
    """k scans."""
    clouds: tuple[LevelCloud | None, ...]
    """What the lidar saw in space at each; None: it told none."""
    in_map: tuple[PlanarScan | None, ...]
    """Each scan that enters the map; None: it was taken at another height, or is left out."""
    first_in_map: int
    """Number of nodes before the present map began; 0: the map holds all. See `MapPieces`."""
    is_usable: np.ndarray
    """(k,) bool: whether a node is in the present map or in the earlier one, and so may be recognised."""
    filter_parameters: SlamParameters
    """Of the maps."""
    starting_map: OccupancyGrid | None = None
    """The map that the filter began with; None: an empty one."""
    band: Band = ALL_HEIGHTS
    """Heights whose scans enter the map."""
    newest: tuple[NewestScan, ...] = ()
    """Of known places."""

    def __post_init__(self) -> None:
        for name in ARRAYS:
            array = np.array(getattr(self, name))
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        count = len(self.stamps_s)
        lengths = {len(getattr(self, name)) for name in (*ARRAYS, "scans", "clouds", "in_map")}
        if lengths != {count} or self.poses_in_map.shape != (count, 3) or self.odometry.shape != (count, 3):
            raise ValueError("a snapshot's path, scans and odometry are not of one length")

    def __len__(self) -> int:
        return len(self.stamps_s)

    def in_band(self, node: int, band_m: float) -> np.ndarray:
        """Return which nodes (k,) were at a node's height within a band, as far as heights are known."""
        return ~(np.abs(self.heights_m - self.heights_m[node]) > band_m)  # NaN is in every band

    def map_of(self, poses_in_map: np.ndarray, first: int) -> MapDraft:
        """Return a new map of the scans from the ``first`` on, at poses (k, 3) of all nodes.

        What has changed in known places is in their newest scans, which enter it last.
        """
        draft = MapDraft(self.filter_parameters, self.starting_map, first, self.band)
        draft.add(poses_in_map[first:], self.in_map[first:])
        usable = self.is_usable & (np.arange(len(self)) >= first)
        draft.add_beside(*placed(self.newest, poses_in_map, usable, self.band))
        return draft
