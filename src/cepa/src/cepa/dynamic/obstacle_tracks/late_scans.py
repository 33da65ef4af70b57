"""Scans that wait for late odometry, so that each counts with the pose at which it was taken."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import (
    KEPT_POSES,
    LATE_S,
    LONGEST_POSE_GAP_S,
    LONGEST_WAIT_S,
    TURN_RATE_S,
)
from cepa.motion import Motion
from cepa.scan import Beams


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
            if start_s < stamp_s <= end_s and end_s - start_s <= LONGEST_POSE_GAP_S:
                return _between(earlier, later, (stamp_s - start_s) / (end_s - start_s), stamp_s)
        return None

    def _turn_rate_rad_s(self) -> float:
        newest = self._poses[-1]
        for pose in reversed(self._poses):
            passed_s = _told_s(newest) - _told_s(pose)
            if passed_s > LONGEST_POSE_GAP_S:
                break
            if passed_s >= TURN_RATE_S:
                return math.remainder(newest.yaw_rad - pose.yaw_rad, 2.0 * math.pi) / passed_s
        return 0.0


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
