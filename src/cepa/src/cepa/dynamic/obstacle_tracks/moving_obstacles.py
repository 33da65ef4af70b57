"""Finds what moves in each scan, and where it is when an answer shows its effect; also with late odometry."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import BESIDE_DISC_M, LATE_S
from cepa.dynamic.free_space.free_ranges import BeamEnds, FreeRanges
from cepa.dynamic.obstacle_tracks.late_scans import LateScans
from cepa.dynamic.obstacle_tracks.tracker import ObstacleTracker
from cepa.dynamic.obstacle_tracks.tracks import nothing_moves
from cepa.motion import Motion
from cepa.parameters import CepaParameters
from cepa.scan import Beams

NO_MOVERS, NO_POINTS = np.empty((0, 6)), np.empty(0, np.bool_)


class SegmentedScan(NamedTuple):
    """A scan, and what moves in it, along the odometry's axes with the lidar at the origin."""

    points: np.ndarray
    """(n, 3) m: the ends of the beams that hit something; overwritten by the next scan."""
    free: FreeRanges
    """How far each direction is free."""
    is_moving: np.ndarray
    """(n,) bool: which points belong to what moves."""
    movers: np.ndarray
    """(k, 6): what moves when an answer shows its effect, see kernels/surroundings.py."""

    def without(self, stands: np.ndarray) -> SegmentedScan:
        """Return the scan without the movers (k,) that stand."""
        if not stands.any():
            return self
        movers = self.movers[~stands]
        return self._replace(movers=movers, is_moving=self.is_moving & _are_in(movers, self.points))


class MovingObstacles:
    """Finds what moves in each scan, and where it is when an answer shows its effect."""

    def __init__(self, parameters: CepaParameters):
        self._p, self._beam_ends = parameters, BeamEnds()
        self._delay_s = parameters.response.delay_s
        self._tracker, self._late = ObstacleTracker(), LateScans()
        self.reset()

    def reset(self) -> None:
        """Forget what moves, and all scans that wait."""
        self._tracker.reset()
        self._late.reset()
        self._moving, self._moving_s = nothing_moves(0), -math.inf

    def take_over(self, earlier: MovingObstacles) -> None:
        """Take over what one with other parameters knows; it must not be used any longer."""
        self._tracker, self._late = earlier._tracker, earlier._late
        self._moving, self._moving_s = earlier._moving, earlier._moving_s

    def tell(self, motion: Motion) -> float:
        """Take in what odometry tells at a scan; return the turn since that pose, rad (see `LateScans`)."""
        return self._late.tell(motion)

    def take_in(
        self,
        beams: Beams,
        motion: Motion,
        age_s: float,
        range_max: float,
        are_upright: bool = True,
        counts: bool = True,
    ) -> SegmentedScan:
        """Return what a scan shows.

        motion: at the scan's stamp, as far as it is known. age_s: how much older odometry is. If odometry is
        late, what moves is that of the newest scan that was ready, moved on. While odometry tells nothing,
        it moves on until it would be forgotten out of sight. So a thing that moves stays one, and nothing
        that stands seems to move. are_upright: see `ObstacleTracker.update`. counts: whether the tracks take
        in the scan; else what moves moves on.
        """
        for held, then in self._late.ready():
            self._follow(*self._beam_ends.of(held, then, range_max), then, are_upright)
        points, free = self._beam_ends.of(beams, motion, range_max)
        in_time = age_s <= LATE_S
        if in_time and counts:
            self._follow(points, free, motion, are_upright)
        elif counts:
            self._late.hold(beams, motion.stamp_s)
        since_s = motion.stamp_s - self._moving_s
        if not len(self._moving.radii) or since_s > self._tracker.parameters.forget_s:
            return SegmentedScan(points, free, nothing_moves(len(points)).is_moving, NO_MOVERS)
        movers = self._moving.movers(np.array(motion.position_m[:2]))
        is_moving = (
            self._moving.is_moving if in_time and counts else _are_in(_moved_on(movers, since_s), points)
        )
        return SegmentedScan(points, free, is_moving, _moved_on(movers, since_s + self._delay_s))

    def _follow(self, points: np.ndarray, free: FreeRanges, motion: Motion, are_upright: bool) -> None:
        x, y, z = motion.position_m
        floor_m, ceiling_m = self._p.floor_height - z, self._p.ceiling_height - z
        is_level = self._tracker.clear_of_floor(points, floor_m, ceiling_m) if len(points) else NO_POINTS
        scan = points, (x, y), free, is_level, z
        speed_m_s = math.hypot(*motion.velocity_m_s[:2])
        self._moving = self._tracker.update(motion.stamp_s, *scan, are_upright, motion.doubt, speed_m_s)
        self._moving_s = motion.stamp_s


def _moved_on(movers: np.ndarray, time_s: float) -> np.ndarray:
    """Return the discs (k, 6) after a time."""
    moved = movers.copy()
    moved[:, :2] += time_s * movers[:, 2:4]
    moved[:, 4] += time_s * movers[:, 5]
    return moved


def _are_in(movers: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) are in a disc or beside it (n,)."""
    apart_m = np.hypot(points[:, :1] - movers[:, 0], points[:, 1:2] - movers[:, 1])
    return np.any(apart_m < movers[:, 4] + BESIDE_DISC_M, axis=1)
