"""The ways between places, in 3D and clear of everything, and the time that they take."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from exploration.planning.kernels.neighbours import STEPS
from exploration.planning.kernels.pulling import pull
from exploration.planning.kernels.search import DONE, START, UNREACHED, search
from flight_basics.errors import SurveyError
from inspection.survey.kernels.ways import straight_ways
from inspection.survey.parameters import FlightParameters
from inspection.survey.surface.room import Room

WINDOW = 150
"""Voxels of a way that one leg may skip."""


class Ways:
    """Shortest known ways between places (n, 3): straight where that is clear, else over others and corners.

    Attributes:
        lengths_m: (n, n).
    """

    def __init__(self, room: Room, places_m: np.ndarray):
        self._room = room
        self._squares = np.where(room.flyable, room.squares, 0).astype(np.uint16)
        corners_m = np.empty((0, 3))
        while True:
            self._nodes_m = np.concatenate((places_m, corners_m))
            straight = straight_ways(self._squares, room.need, room.inner(self._nodes_m)) * room.voxel_m
            graph = csr_matrix(np.where(np.isfinite(straight), np.maximum(straight, 1e-6), 0.0))
            lengths, self._came = dijkstra(graph, directed=False, return_predecessors=True)
            cut_off = np.flatnonzero(~np.isfinite(lengths[0, : len(places_m)]))
            if not len(cut_off):
                break
            corners_m = np.concatenate((corners_m, self._corners(places_m[0], places_m[cut_off[0]])))
        self.lengths_m = lengths[: len(places_m), : len(places_m)]
        np.fill_diagonal(self.lengths_m, 0.0)

    def _corners(self, begin_m: np.ndarray, end_m: np.ndarray) -> np.ndarray:
        """Return the corners (k, 3) of the way between two places that no straight legs join."""
        ends = np.floor(self._room.inner(np.array((begin_m, end_m)))).astype(np.int64)
        came = np.full(self._squares.shape, UNREACHED, np.int8)
        plain = np.ones(int(self._squares.max()) + 1)
        if math.isinf(search(self._squares, self._room.need, plain, ends, came)):
            raise SurveyError("No way leads to one of the places of the photographs.")
        voxel, chain = tuple(ends[1].tolist()), []
        while True:
            chain.append(np.array(voxel) + 0.5)
            if came[voxel] % DONE == START:
                break
            voxel = tuple((np.array(voxel) - STEPS[came[voxel] % DONE]).tolist())
        points = np.array(chain[::-1])
        kept = pull(self._squares, self._room.need, plain, points, WINDOW)
        return self._room.outer(points[kept])

    def between(self, a: int, b: int) -> np.ndarray:
        """Return the corners (k, 3) of the way from one place to another, without both ends."""
        found, here = [], int(self._came[a, b])
        while here >= 0 and here != a:
            found.append(here)
            here = int(self._came[a, here])
        return self._nodes_m[found[::-1]]


def leg_times_s(
    lengths_m: np.ndarray, yaws_rad: np.ndarray, tilts_rad: np.ndarray, flight: FlightParameters
) -> np.ndarray:
    """Return (n, n) the time from one photograph to the next: of the way or, if longer, of the turn.

    The first place is home, where the camera looks anywhere. Hovering, the UAV stops at each; in passing it
    keeps the passing speed or more.
    """
    turn = np.abs((yaws_rad[:, None] - yaws_rad[None] + math.pi) % (2.0 * math.pi) - math.pi)
    tilt = np.abs(tilts_rad[:, None] - tilts_rad[None])
    turns_s = np.maximum(np.degrees(turn) / flight.yaw_rate, np.degrees(tilt) / flight.tilt_rate)
    turns_s[0], turns_s[:, 0] = 0.0, 0.0
    slow = flight.shooting_speed
    fast, push = flight.speed, flight.acceleration
    ramps_m = (fast**2 - slow**2) / push
    peak = np.sqrt(slow**2 + push * np.minimum(lengths_m, ramps_m))
    times_s = 2.0 * (peak - slow) / push + np.maximum(lengths_m - ramps_m, 0.0) / fast
    times_s = np.maximum(times_s, turns_s)
    np.fill_diagonal(times_s, 0.0)
    return times_s
