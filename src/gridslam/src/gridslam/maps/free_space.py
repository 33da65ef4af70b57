"""Enters scans into the particles' maps, free space later than surfaces; see `kernels.deferred_scans`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.kernels.deferred_scans import (
    LEFT_MAX,
    DeferredScans,
    insert_surfaces,
    settle_places,
    write_free,
)
from gridslam.maps.board import Board
from gridslam.maps.tile_pool import TilePool

SCANS = 64
"""So many scans wait. Of thirty particles, most have the same path up to there."""
NO_HIT = np.zeros(0, bool)


class Maps(NamedTuple):
    """The particles' maps at one moment."""

    tables: np.ndarray
    """(particles, h, w) tile indices."""
    corner: np.ndarray
    """(2,) position of the tables' first tile: x, y, in tiles from the map's origin."""
    pool: TilePool
    board: Board


class FreeSpace:
    """The scans of which free space waits to be entered."""

    def __init__(self, particles: int):
        self._particles = particles
        self._deferred = _room(particles, 0)

    def resample(self, parents: np.ndarray) -> None:
        """Give particle i the past of particle parents[i]."""
        old = self._deferred
        poses, parts = np.take(old.poses, parents, axis=1), np.take(old.parts, parents, axis=1)
        self._deferred = old._replace(poses=poses, parts=parts, settled=old.settled[parents])

    def insert(self, maps: Maps, cells: np.ndarray, points: np.ndarray, hits: np.ndarray, stamp: int) -> int:
        """Enter a scan, taken at poses (particles, 3) in cells; its free space waits.

        ``points`` (n + 1, 2), in the base frame, are the lidar and its beams' ends; hits (n,) says which of
        these are at something. Returns the last stamp that was given, from ``stamp`` on.
        """
        first, number = self._deferred.numbers.tolist()
        if number - first == SCANS:
            stamp = self._write_oldest(maps, stamp)
        self._reserve(len(points))
        deferred = self._deferred
        slot = number % SCANS
        reach = float(np.hypot(*(points[1:] - points[0]).T).max(initial=0.0))
        deferred.points[slot, : len(points)], deferred.counts[slot] = points, len(points)
        deferred.poses[slot], deferred.corners[slot], deferred.reaches[slot] = cells, maps.corner, reach
        maps.board.reserve(reach)
        scan, particle = maps.board.ends(points, hits), 0
        while particle < self._particles:
            particle = insert_surfaces(
                particle, maps.tables, scan, maps.corner, stamp + 1, deferred, maps.pool.tiles
            )
            if particle < self._particles:
                maps.pool.reserve(maps.board.tables.size)
        deferred.numbers[1] += 1
        return stamp + self._particles

    def settle_places(self, maps: Maps, particle: int, places: np.ndarray, stamp: int) -> None:
        """Enter all scans that wait into some tiles of a particle: those at places (n, 2), row and column."""
        table = maps.tables[particle]
        maps.pool.reserve(len(places))
        settle_places(particle, table, places, maps.corner, stamp + 1, self._deferred, maps.pool.tiles)

    def settle(self, maps: Maps, particle: int, stamp: int) -> int:
        """Enter all scans that wait into a particle's map. Return the last stamp that was given."""
        for number in range(int(self._deferred.settled[particle]) + 1, int(self._deferred.numbers[1])):
            stamp += 1
            self._write(maps, number, particle, stamp)
        return stamp

    def settle_all(self, maps: Maps, stamp: int) -> int:
        """Enter all scans that wait into all maps. Return the last stamp that was given."""
        while self._deferred.numbers[0] < self._deferred.numbers[1]:
            stamp = self._write_oldest(maps, stamp)
        return stamp

    def _write_oldest(self, maps: Maps, stamp: int) -> int:
        number = int(self._deferred.numbers[0])
        for particle in range(self._particles):
            if self._deferred.settled[particle] < number:
                stamp += 1
                self._write(maps, number, particle, stamp)
        self._deferred.numbers[0] += 1
        return stamp

    def _write(self, maps: Maps, number: int, particle: int, stamp: int) -> None:
        deferred, board = self._deferred, maps.board
        slot = number % SCANS
        scan = board.ends(deferred.points[slot, : deferred.counts[slot]], NO_HIT)
        maps.pool.reserve(board.tables.size + LEFT_MAX * self._particles)
        where, tiles = (board.tables, maps.corner, stamp), maps.pool.tiles
        write_free(number, particle, maps.tables, scan, *where, deferred, tiles)

    def _reserve(self, points: int) -> None:
        """Make room for a scan of so many points."""
        old = self._deferred
        if old.points.shape[1] < points:
            larger = _room(self._particles, points)
            larger.points[:, : old.points.shape[1]] = old.points
            self._deferred = old._replace(points=larger.points, placed=larger.placed)


def _room(particles: int, points: int) -> DeferredScans:
    return DeferredScans(
        points=np.zeros((SCANS, points, 2)),
        counts=np.zeros(SCANS, np.int64),
        reaches=np.zeros(SCANS),
        poses=np.zeros((SCANS, particles, 3)),
        parts=np.ones((SCANS, particles), np.int64),
        corners=np.zeros((SCANS, 2), np.int64),
        numbers=np.array((1, 1)),
        settled=np.zeros(particles, np.int64),
        placed=np.zeros((max(points, 1), 2)),
    )
