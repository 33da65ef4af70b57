"""For how long the flight controller has had no external pose, and whether that is too long."""

from __future__ import annotations

import statistics
from collections import deque
from typing import Collection, NamedTuple

from simulation_tools.publisher.interface import PublisherParameters

_NS = 1e-9
GAPS_KEPT, GAPS_LEAST = 400, 10
BURST_S = 0.005
"""Poses that are closer together than this came together: vision_pose_publisher fills a slow lidar's gaps."""
LATER = 1.5
"""The next pose may be later than the latest but one of the last poses, by this factor."""
SLOW_GAPS = 1.4
"""A pose may stay away for so many usual gaps, if that is longer than vision_timeout_s."""
LOCKSTEP_GAPS = 4.0
"""In lockstep the simulator waits for each pose. It has been heard here up to three gaps later."""


class Blindness(NamedTuple):
    """The time without an external pose."""

    lasts_s: float
    """0 if the flight controller needs none."""
    is_too_long: bool


class VisionWatch:
    """The times at which external poses went to the flight controller.

    The next pose may be half as late again as the latest but one of the last poses, and a little more. So the
    UAV stops early when poses come evenly, and one lost scan changes nothing. On a busy machine it does not
    wait much longer: a wrong alarm ends with the next pose, but a stop that begins late may end at a wall.
    """

    def __init__(self) -> None:
        self._newest_ns: int | None = None
        self._has_come = False
        self._gaps_s: deque[float] = deque(maxlen=GAPS_KEPT)
        self._limit_s: float | None = None  # None: not computed yet

    @property
    def has_come(self) -> bool:
        """Whether a pose has gone to the flight controller."""
        return self._has_come

    def on_pose(self, now_ns: int) -> None:
        """Take in that a pose has gone to the flight controller."""
        if self._has_come and self._newest_ns is not None:
            self._gaps_s.append((now_ns - self._newest_ns) * _NS)
        self._newest_ns, self._has_come = now_ns, True
        self._limit_s = None

    def set_ahead(self, step_ns: int) -> None:
        """Count the newest pose as no older than it was: ROS's clock was set ahead."""
        if self._newest_ns is not None:
            self._newest_ns += step_ns

    def expect_pose(self, now_ns: int, p: PublisherParameters) -> None:
        """Count the flight controller as blind if no pose has come yet.

        A publisher that begins in the air may never hear one.
        """
        if self._newest_ns is None:
            self._newest_ns = now_ns - round(p.vision_timeout_s / _NS) - 1

    def blindness(self, now_ns: int, p: PublisherParameters) -> Blindness:
        """Return how blind the flight controller is."""
        if not p.needs_vision or self._newest_ns is None:
            return Blindness(0.0, False)
        if self._limit_s is None:
            self._limit_s = _limit_s(self._gaps_s, p)
        lasts_s = (now_ns - self._newest_ns) * _NS
        return Blindness(lasts_s, lasts_s > self._limit_s)


def _limit_s(gaps_s: Collection[float], p: PublisherParameters) -> float:
    if len(gaps_s) < GAPS_LEAST:
        return p.vision_timeout_s
    longest_but_one_s = sorted(gaps_s)[-2]
    usual_s = statistics.median([gap for gap in gaps_s if gap > BURST_S] or [longest_but_one_s])
    if p.in_lockstep:
        return max(p.vision_timeout_s, LOCKSTEP_GAPS * usual_s)
    late_s = max(longest_but_one_s - usual_s, 0.0)
    most_s = max(p.vision_timeout_s, SLOW_GAPS * usual_s)
    return min(max(usual_s + LATER * late_s + p.vision_spare_s, p.vision_timeout_least_s), most_s)
