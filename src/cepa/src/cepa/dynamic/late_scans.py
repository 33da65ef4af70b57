"""What moves, also when odometry comes late: each scan counts with the pose at which it was taken."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cepa.dynamic.lookout import Lookout, Seen
from cepa.dynamic.movers import BESIDE_M, Movers, nothing_moves
from cepa.motion import Motion
from cepa.parameters import CepaParameters
from cepa.scan import Beams

LATE_S = 0.03
"""Odometry that is no older than this at a scan is in time: the UAV has hardly turned since."""
LONGEST_WAIT_S = 0.5
"""A scan that is older has no use any more."""
LONGEST_GAP_S = 0.3
"""Between poses that are farther apart nobody knows how the UAV turned."""
TURN_RATE_S = 0.05
"""The turn rate is taken over so much time."""
KEPT_POSES = 64
NO_DISCS, NO_POINTS = np.empty((0, 6)), np.empty(0, np.bool_)


class LateScans:
    """Holds scans until odometry has told where the lidar was when they were taken.

    A late pose is old, above all in yaw and tilt. With it, things that stand seem to move. So a scan waits,
    and its pose is interpolated between two that odometry told. A scan between poses that are too far
    apart is dropped.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all scans and poses."""
        self._poses: deque[Motion] = deque(maxlen=KEPT_POSES)
        self._waiting: deque[tuple[Beams, float]] = deque()
        self._newest_s = -math.inf

    def tell(self, motion: Motion) -> float:
        """Take in what odometry tells at a scan; return the turn about the vertical since that pose, rad.

        It is 0 if odometry is in time. Otherwise the UAV is assumed to turn on as before.
        """
        age_s = motion.age_s
        told_s = motion.stamp_s - age_s
        if told_s > self._newest_s:
            self._newest_s = told_s
            self._poses.append(motion)
        return self._turn_rate_rad_s() * age_s if age_s > LATE_S else 0.0

    def hold(self, beams: Beams, stamp_s: float) -> None:
        """Keep a scan until it is ready."""
        while self._waiting and stamp_s - self._waiting[0][1] > LONGEST_WAIT_S:
            self._waiting.popleft()
        copied = beams._replace(ranges=beams.ranges.copy(), seen=beams.seen.copy())
        self._waiting.append((copied, stamp_s))

    def ready(self) -> list[tuple[Beams, Motion]]:
        """Return the held scans whose poses are known by now, oldest first."""
        ready = []
        while self._waiting and self._waiting[0][1] <= self._newest_s:
            beams, stamp_s = self._waiting.popleft()
            motion = self._at(stamp_s)
            if motion is not None:
                ready.append((beams, motion))
        return ready

    def _at(self, stamp_s: float) -> Motion | None:
        """Return the motion at a time that is not after the newest pose; None: it is not known."""
        for earlier, later in zip(self._poses, list(self._poses)[1:]):
            start_s, end_s = _told_s(earlier), _told_s(later)
            if start_s < stamp_s <= end_s and end_s - start_s <= LONGEST_GAP_S:
                return _between(earlier, later, (stamp_s - start_s) / (end_s - start_s), stamp_s)
        return None

    def _turn_rate_rad_s(self) -> float:
        newest = self._poses[-1]
        for pose in reversed(self._poses):
            passed_s = _told_s(newest) - _told_s(pose)
            if passed_s > LONGEST_GAP_S:
                break
            if passed_s >= TURN_RATE_S:
                return math.remainder(newest.yaw_rad - pose.yaw_rad, 2.0 * math.pi) / passed_s
        return 0.0


class Sighting(NamedTuple):
    """A scan, and what moves in it, along the odometry's axes with the lidar at the origin."""

    points: np.ndarray
    """(n, 3) m: the ends of the beams that hit something; overwritten by the next scan."""
    seen: Seen
    """How far each direction is seen."""
    is_moving: np.ndarray
    """(n,) bool: which points belong to what moves."""
    discs: np.ndarray
    """(k, 6): what moves when an answer shows its effect, see kernels/surroundings.py."""


class MovingThings:
    """Finds what moves in each scan, and where it is when an answer shows its effect."""

    def __init__(self, parameters: CepaParameters, lookout: Lookout):
        self._p, self._lookout = parameters, lookout
        self._movers, self._late = Movers(), LateScans()
        self.reset()

    def reset(self) -> None:
        """Forget what moves, and all scans that wait."""
        self._movers.reset()
        self._late.reset()
        self._moving, self._moving_s = nothing_moves(0), -math.inf

    def take_over(self, earlier: MovingThings) -> None:
        """Take over what one with other parameters knows; it must not be used any longer."""
        self._movers, self._late = earlier._movers, earlier._late
        self._moving, self._moving_s = earlier._moving, earlier._moving_s

    def tell(self, motion: Motion) -> float:
        """As `LateScans.tell`."""
        return self._late.tell(motion)

    def see(self, beams: Beams, motion: Motion, age_s: float, range_max: float) -> Sighting:
        """Return what a scan shows.

        motion: at the scan's stamp, as far as it is known. age_s: how much older odometry is. If odometry is
        late, what moves is that of the newest scan that was ready, moved on. While odometry tells nothing,
        it moves on until it would be forgotten out of sight. So a thing that moves stays one, and nothing
        that stands seems to move.
        """
        for held, then in self._late.ready():
            self._follow(*self._lookout.see(held, then, range_max), then)
        points, seen = self._lookout.see(beams, motion, range_max)
        in_time = age_s <= LATE_S
        if in_time:
            self._follow(points, seen, motion)
        else:
            self._late.hold(beams, motion.stamp_s)
        since_s = motion.stamp_s - self._moving_s
        if not len(self._moving.radii) or since_s > self._movers.parameters.forget_s:
            return Sighting(points, seen, nothing_moves(len(points)).is_moving, NO_DISCS)
        discs = self._moving.discs(np.array(motion.position_m[:2]))
        is_moving = self._moving.is_moving if in_time else _are_in(_moved_on(discs, since_s), points)
        return Sighting(points, seen, is_moving, _moved_on(discs, since_s + self._p.response.delay_s))

    def _follow(self, points: np.ndarray, seen: Seen, motion: Motion) -> None:
        x, y, z = motion.position_m
        floor_m, ceiling_m = self._p.floor_height - z, self._p.ceiling_height - z
        is_level = self._movers.clear_of_floor(points, floor_m, ceiling_m) if len(points) else NO_POINTS
        self._moving = self._movers.update(motion.stamp_s, points, (x, y), seen, is_level)
        self._moving_s = motion.stamp_s


def _told_s(motion: Motion) -> float:
    return motion.stamp_s - motion.age_s


def _between(earlier: Motion, later: Motion, share: float, stamp_s: float) -> Motion:
    ends = np.array([earlier.position_m, later.position_m])
    turns = np.array([earlier.orientation_xyzw, later.orientation_xyzw])
    turns[1] *= math.copysign(1.0, turns[0] @ turns[1])  # q and -q are the same orientation
    weights = np.array([1.0 - share, share])
    x, y, z = weights @ ends
    a, b, c, d = weights @ turns / np.linalg.norm(weights @ turns)
    return replace(later, stamp_s=stamp_s, position_m=(x, y, z), orientation_xyzw=(a, b, c, d), age_s=0.0)


def _moved_on(discs: np.ndarray, time_s: float) -> np.ndarray:
    """Return the discs (k, 6) after a time."""
    moved = discs.copy()
    moved[:, :2] += time_s * discs[:, 2:4]
    moved[:, 4] += time_s * discs[:, 5]
    return moved


def _are_in(discs: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) are in a disc or beside it (n,)."""
    apart_m = np.hypot(points[:, :1] - discs[:, 0], points[:, 1:2] - discs[:, 1])
    return np.any(apart_m < discs[:, 4] + BESIDE_M, axis=1)
