"""Every particle's map, made of tiles.

Particles share a tile until one of them changes it. A particle owns only a table of tile indices. Resampling
copies tables. If a particle writes into a tile that others share, it gets a copy (copy on write, by
reference counts).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from gridslam.errors import MapError
from gridslam.kernels.agreement import AGREES, CLASHES, UNSEEN, verdicts
from gridslam.kernels.insertion import insert_path, insert_scan
from gridslam.kernels.tiles import EMPTY, FULLNESS, PARTS, SIDE
from gridslam.maps.beams import Beams
from gridslam.maps.board import Board
from gridslam.maps.free_space import FreeSpace, Maps
from gridslam.maps.tile_pool import TilePool, TilesState, require_indices
from gridslam.occupancy_grid import CELLS_MAX
from gridslam.tracking.evidence import Agreement

ROOM = 6
"""Extra tiles on each side when the tables grow."""
RESERVE = 1024
"""When the pool grows, room is made for this many tiles besides one for each place in a table."""
COMPARED_BEAMS_MAX = 200
"""More beams of one scan than this tell nothing new about its agreement with a map."""
SCANS_AT_ONCE = 64
"""Of a path: more would need memory in proportion."""
NO_HIT = np.zeros(1, bool)
TABLE_MAX = CELLS_MAX // SIDE**2
"""Greatest number of tiles in one particle's table, because the drawn map has a byte for each cell."""

FREE_SHARE = 0.5
"""If more than this share of a map's tiles are free space alone, it pays to let them wait: most particles die
out before they get tiles of their own."""
FAR = 1e12
"""Tiles: farther than any map reaches, but still within whole numbers."""


@dataclass(frozen=True, eq=False)
class MapsState:
    """The content of `TileMaps`, to save it."""

    tables: np.ndarray
    """(particles, h, w) indices of tiles, from 1 on; 0: nothing was seen there."""
    corner: np.ndarray
    """(2,) position of the tables' first tile: x, y, in tiles from the map's origin."""
    stamp: int
    tiles: TilesState


class TileMaps:
    """The maps of all particles over one window of tiles, which grows in any direction."""

    def __init__(self, particles: int, delta_m: float):
        self.delta_m = delta_m
        self.pool = TilePool()
        self.tables = np.zeros((particles, 1, 1), np.int32)
        """(particles, h, w) tile indices."""
        self.corner = np.zeros(2, np.int64)
        """Position of the window's lower left tile: x, y, in tiles from the map's origin."""
        self.stamp = 0
        """How many times a particle's map was written."""
        self._board = Board()
        self._free_space: FreeSpace | None = None
        """Scans that are not entered everywhere yet; None: all are."""

    def to_cells(self, poses: np.ndarray) -> np.ndarray:
        """Return poses (..., 3) in m and rad in cells from the window's corner, and rad."""
        scaled = np.array(poses, float)
        scaled[..., :2] = scaled[..., :2] / self.delta_m - self.corner * SIDE
        return scaled

    def to_metres(self, poses: np.ndarray) -> np.ndarray:
        """Return poses (..., 3) in cells from the window's corner and rad in m and rad."""
        scaled = np.array(poses, float)
        scaled[..., :2] = (scaled[..., :2] + self.corner * SIDE) * self.delta_m
        return scaled

    def are_seen(self, particle: int, points: np.ndarray) -> np.ndarray:
        """Return whether a beam has met the cells at points (n, 2), in cells from the window's corner."""
        height, width = self.tables.shape[1:]
        x, y = np.floor(points).astype(np.int64).T
        inside = (x >= 0) & (y >= 0) & (x < width * SIDE) & (y < height * SIDE)
        x, y = np.where(inside, x, 0), np.where(inside, y, 0)
        cells = (y % SIDE) * SIDE + x % SIDE
        seen = inside & (self.pool.tiles.visits[self.tables[particle][y // SIDE, x // SIDE], cells] > 0)
        unsure = inside & ~seen
        if self._free_space is None or not unsure.any():
            return seen
        places = np.unique(np.stack((y // SIDE, x // SIDE), axis=1)[unsure], axis=0)
        self._free_space.settle_places(self._maps, particle, places, self.stamp)
        self.stamp += 1
        return inside & (self.pool.tiles.visits[self.tables[particle][y // SIDE, x // SIDE], cells] > 0)

    def cover(self, low_xy_m: ArrayLike, high_xy_m: ArrayLike) -> None:
        """Let the window cover a box in the map frame. Raises MapError if the box is absurdly large."""
        tile_m = SIDE * self.delta_m
        low = np.floor(np.clip(np.asarray(low_xy_m) / tile_m - 0.5, -FAR, FAR)).astype(np.int64)
        high = np.ceil(np.clip(np.asarray(high_xy_m) / tile_m + 0.5, -FAR, FAR)).astype(np.int64)
        height, width = self.tables.shape[1:]
        end = self.corner + np.array((width, height))
        if (low >= self.corner).all() and (high <= end).all():
            return
        with_room = np.where(low < self.corner, low - ROOM, low), np.where(high > end, high + ROOM, high)
        for lower, upper in (with_room, (low, high)):
            lower, upper = np.minimum(lower, self.corner), np.maximum(upper, end)
            width, height = (int(size) for size in upper - lower)
            if width * height <= TABLE_MAX:
                self._grow(lower, width, height)
                return
        extent = SIDE * self.delta_m * np.array([width, height])
        raise MapError(
            f"The map would grow to {extent[0]:.0f} x {extent[1]:.0f} m, too large for cells of "
            f"{self.delta_m} m; check whether odometry and ranges are in metres, or "
            "choose a larger delta."
        )

    def _grow(self, low: np.ndarray, width: int, height: int) -> None:
        x, y = (int(value) for value in self.corner - low)
        tables = np.zeros((self.tables.shape[0], height, width), np.int32)
        tables[:, y : y + self.tables.shape[1], x : x + self.tables.shape[2]] = self.tables
        self.tables, self.corner = tables, low

    def resample(self, parents: np.ndarray) -> None:
        """Give particle i the map of particle parents[i]. No tile is copied."""
        self.tables = self.tables[parents]
        if self._free_space is not None:
            self._free_space.resample(parents)
        self.pool.count_references(self.tables)
        if self._free_space is None and self._is_mostly_free():
            self._free_space = FreeSpace(len(parents))

    def _is_mostly_free(self) -> bool:
        """Return whether several particles have maps in most of whose tiles no beam has ended."""
        used = self.tables[0][self.tables[0] != EMPTY]
        free = np.count_nonzero(self.pool.tiles.ends[used] == EMPTY)
        return len(self.tables) > 1 and free > FREE_SHARE * used.size

    def prepare(self, poses: np.ndarray, beams: Beams) -> None:
        """Let the window cover all beams (base frame) at poses (particles, 3) in the map."""
        reach_m = self.delta_m * float(np.hypot(*np.vstack((beams.ends, beams.lidar)).T).max() + 2.0)
        self.cover(poses[:, :2].min(axis=0) - reach_m, poses[:, :2].max(axis=0) + reach_m)

    def agreement(self, particle: int, pose: np.ndarray, beams: Beams) -> Agreement:
        """Compare a scan, taken at a pose (3,) of the base in the map, with one particle's map."""
        every = max(1, len(beams.matching) // COMPARED_BEAMS_MAX)
        ends = np.ascontiguousarray(beams.matching[::every, :2])
        placed, tables, occupied = np.empty_like(ends), self.tables[particle], self.pool.tiles.occupied
        found = verdicts(self.to_cells(pose), beams.lidar, ends, tables, occupied, placed)
        unseen = np.flatnonzero(found == UNSEEN)
        found[unseen[self.are_seen(particle, placed[unseen])]] = CLASHES
        return Agreement(*(int(np.count_nonzero(found == kind)) for kind in (AGREES, CLASHES, UNSEEN)))

    def insert(self, poses: np.ndarray, beams: Beams) -> None:
        """Enter a scan into every particle's map, taken at its pose (particles, 3)."""
        self.prepare(poses, beams)
        points = np.concatenate((beams.lidar[None], beams.ends))
        self.insert_at(self.to_cells(poses), points, beams.hits)

    def insert_at(self, cells: np.ndarray, points: np.ndarray, hits: np.ndarray) -> None:
        """Enter a scan that the window holds, taken at poses (particles, 3) in cells.

        ``points`` (n + 1, 2), in the base frame, are the lidar and its beams' ends; hits (n,) says which of
        these are at something.
        """
        if self._free_space is not None:
            self.stamp = self._free_space.insert(self._maps, cells, points, hits, self.stamp)
            return
        self._board.reserve(float(np.hypot(*(points[1:] - points[0]).T).max(initial=0.0)))
        scan, particle = self._board.ends(points, hits), 0
        while particle < len(self.tables):
            particle = insert_scan(particle, self.tables, cells, scan, self.stamp + 1, self.pool.tiles)
            if particle < len(self.tables):
                self.pool.reserve(self.tables[0].size + RESERVE)
        self.stamp += len(self.tables)

    def settle(self, particle: int | None = None) -> None:
        """Enter into a particle's map, or into all (None), what waits to be entered."""
        if self._free_space is None:
            return
        if particle is None:
            self.stamp = self._free_space.settle_all(self._maps, self.stamp)
        else:
            self.stamp = self._free_space.settle(self._maps, particle, self.stamp)

    @property
    def _maps(self) -> Maps:
        return Maps(self.tables, self.corner, self.pool, self._board)

    def insert_path(self, poses: np.ndarray, scans: Sequence[Beams]) -> None:
        """Enter scans, taken at poses (k, 3), one after the other into the map of the first particle."""
        for first in range(0, len(scans), SCANS_AT_ONCE):
            self._insert_lot(poses[first : first + SCANS_AT_ONCE], scans[first : first + SCANS_AT_ONCE])

    def _insert_lot(self, poses: np.ndarray, scans: Sequence[Beams]) -> None:
        points = np.concatenate([part for scan in scans for part in (scan.lidar[None], scan.ends)])
        hits = np.concatenate([part for scan in scans for part in (NO_HIT, scan.hits)])
        starts = np.cumsum([0, *(len(scan.ends) + 1 for scan in scans)])
        reach_m = self.delta_m * (np.maximum.reduceat(np.hypot(*points.T), starts[:-1])[:, None] + 2.0)
        self.cover((poses[:, :2] - reach_m).min(axis=0), (poses[:, :2] + reach_m).max(axis=0))
        self._board.reserve(
            float(np.hypot(*(points - np.repeat(points[starts[:-1]], np.diff(starts), axis=0)).T).max())
        )
        cells, ends, done = self.to_cells(poses), self._board.ends(points, hits), 0
        while done < len(scans):
            done = insert_path(done, self.tables[0], cells, starts, ends, self.stamp + 1, self.pool.tiles)
            if done < len(scans):
                self.pool.reserve(self.tables[0].size + RESERVE)
        self.stamp += len(scans)

    def enter(self, cells_xy: np.ndarray, hits: np.ndarray, visits: int) -> None:
        """Enter these counts into cells (n, 2) of maps that are empty and all alike."""
        x, y = np.floor(cells_xy).astype(np.int64).T
        places, which = np.unique((y // SIDE) * self.tables.shape[2] + x // SIDE, return_inverse=True)
        self.pool.reserve(places.size)
        self.stamp += 1
        tiles = self.pool.take(places.size, self.stamp)
        self.tables.reshape(len(self.tables), -1)[:, places] = tiles
        tile, row, column, arrays = tiles[which], y % SIDE, x % SIDE, self.pool.tiles
        cell = row * SIDE + column
        arrays.visits[tile, cell] = visits
        arrays.hits[arrays.ends[tile], cell] = hits
        arrays.means[arrays.ends[tile], cell] = (cells_xy - np.stack((x, y), axis=1)) * PARTS
        wall = hits > FULLNESS * visits
        np.bitwise_or.at(
            arrays.occupied, (tile[wall], row[wall]), np.uint32(1) << column[wall].astype(np.uint32)
        )
        self.pool.count_references(self.tables)

    def state(self) -> MapsState:
        """Return the maps' content, without unused tiles."""
        self.settle()
        used = np.unique(self.tables)
        used = used[used != EMPTY]
        tables = np.searchsorted(used, self.tables).astype(np.int32) + (self.tables != EMPTY)
        return MapsState(tables, self.corner, int(self.stamp), self.pool.state(used))

    def restore(self, state: MapsState) -> None:
        """Take over saved maps. Tiles may get other indices, which changes no result.

        Raises:
            ValueError: they are no maps of so many particles.
        """
        tables, corner = state.tables, state.corner
        if tables.ndim != 3 or len(tables) != len(self.tables) or not 0 < tables[0].size <= TABLE_MAX:
            raise ValueError(f"tables of shape {tables.shape} are none of {len(self.tables)} particles")
        if corner.shape != (2,) or corner.dtype.kind != "i" or not (np.abs(corner) <= FAR).all():
            raise ValueError("the maps' corner is not a place")
        self.pool = TilePool.from_state(state.tiles)
        require_indices(tables, len(state.tiles.stamps), "the maps' tables")
        self.tables = np.ascontiguousarray(tables, np.int32)
        self.corner, self.stamp = corner.astype(np.int64), int(state.stamp)
        self.pool.count_references(self.tables)
        self._free_space = FreeSpace(len(tables)) if self._is_mostly_free() else None
