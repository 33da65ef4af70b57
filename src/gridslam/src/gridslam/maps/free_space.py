"""Enters scans into the maps of several particles, free space later than surfaces; see `kernels.waiting`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.kernels.waiting import LEFT_MAX, Waiting, insert_surfaces, settle_places, write_free
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
        self._waiting = _room(particles, 0)

    def resample(self, parents: np.ndarray) -> None:
        """Give particle i the past of particle parents[i]."""
        old = self._waiting
        poses, parts = np.take(old.poses, parents, axis=1), np.take(old.parts, parents, axis=1)
        self._waiting = old._replace(poses=poses, parts=parts, settled=old.settled[parents])

    def insert(self, maps: Maps, cells: np.ndarray, points: np.ndarray, hits: np.ndarray, stamp: int) -> int:
        """Enter a scan, taken at poses (particles, 3) in cells; its free space waits.

        ``points`` (n + 1, 2), in the base frame, are the lidar and its beams' ends; hits (n,) says which of
        these are at something. Returns the last stamp that was given, from ``stamp`` on.
        """
        first, number = self._waiting.numbers.tolist()
        if number - first == SCANS:
            stamp = self._write_oldest(maps, stamp)
        self._reserve(len(points))
        waiting = self._waiting
        slot = number % SCANS
        reach = float(np.hypot(*(points[1:] - points[0]).T).max(initial=0.0))
        waiting.points[slot, : len(points)], waiting.counts[slot] = points, len(points)
        waiting.poses[slot], waiting.corners[slot], waiting.reaches[slot] = cells, maps.corner, reach
        maps.board.reserve(reach)
        scan, particle = maps.board.ends(points, hits), 0
        while particle < self._particles:
            particle = insert_surfaces(
                particle, maps.tables, scan, maps.corner, stamp + 1, waiting, maps.pool.tiles
            )
            if particle < self._particles:
                maps.pool.reserve(maps.board.tables.size)
        waiting.numbers[1] += 1
        return stamp + self._particles

    def settle_places(self, maps: Maps, particle: int, places: np.ndarray, stamp: int) -> None:
        """Enter all scans that wait into some tiles of a particle: those at places (n, 2), row and column."""
        table = maps.tables[particle]
        maps.pool.reserve(len(places))
        settle_places(particle, table, places, maps.corner, stamp + 1, self._waiting, maps.pool.tiles)

    def settle(self, maps: Maps, particle: int, stamp: int) -> int:
        """Enter all scans that wait into a particle's map. Return the last stamp that was given."""
        for number in range(int(self._waiting.settled[particle]) + 1, int(self._waiting.numbers[1])):
            stamp += 1
            self._write(maps, number, particle, stamp)
        return stamp

    def settle_all(self, maps: Maps, stamp: int) -> int:
        """Enter all scans that wait into all maps. Return the last stamp that was given."""
        while self._waiting.numbers[0] < self._waiting.numbers[1]:
            stamp = self._write_oldest(maps, stamp)
        return stamp

    def _write_oldest(self, maps: Maps, stamp: int) -> int:
        number = int(self._waiting.numbers[0])
        for particle in range(self._particles):
            if self._waiting.settled[particle] < number:
                stamp += 1
                self._write(maps, number, particle, stamp)
        self._waiting.numbers[0] += 1
        return stamp

    def _write(self, maps: Maps, number: int, particle: int, stamp: int) -> None:
        waiting, board = self._waiting, maps.board
        slot = number % SCANS
        scan = board.ends(waiting.points[slot, : waiting.counts[slot]], NO_HIT)
        maps.pool.reserve(board.tables.size + LEFT_MAX * self._particles)
        where, tiles = (board.tables, maps.corner, stamp), maps.pool.tiles
        write_free(number, particle, maps.tables, scan, *where, waiting, tiles)

    def _reserve(self, points: int) -> None:
        """Make room for a scan of so many points."""
        old = self._waiting
        if old.points.shape[1] < points:
            larger = _room(self._particles, points)
            larger.points[:, : old.points.shape[1]] = old.points
            self._waiting = old._replace(points=larger.points, placed=larger.placed)


def _room(particles: int, points: int) -> Waiting:
    return Waiting(
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
