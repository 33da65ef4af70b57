"""Watches the stamps of messages: finds stamps of another clock, and a clock that jumped back."""

from __future__ import annotations

import math
import time

import rospy

from node_tools.throttled_warnings import ThrottledWarnings

FARTHEST_AHEAD_NS = 1_000_000_000
STANDS_STILL_S = 1.0
"""Wall time after which a clock that does not change counts as stopped."""


class StampWatch:
    """Decides which stamps a node accepts."""

    def __init__(self, warnings: ThrottledWarnings) -> None:
        self._warnings = warnings
        self._last_ns: int | None = None
        self._now: rospy.Time | None = None
        self._ran_at_s = -math.inf

    def is_ahead(self, stamp: rospy.Time, what: str) -> bool:
        """Return whether a stamp is far ahead of ROS time, and warn. The caller then drops the message.

        No stamp is ahead while ROS time is zero or stands still, as when a bag is played without --clock.
        """
        now, wall_s = rospy.Time.now(), time.monotonic()
        if self._now is not None and now != self._now:
            self._ran_at_s = wall_s
        self._now = now
        ahead_ns = stamp.to_nsec() - now.to_nsec()
        if now.is_zero() or wall_s - self._ran_at_s > STANDS_STILL_S or ahead_ns <= FARTHEST_AHEAD_NS:
            return False
        self._warnings.say(
            f"The {what} is stamped {ahead_ns * 1e-9:.3f} s ahead of ROS time and dropped; "
            "is its sender on another clock?"
        )
        return True

    def went_back(self, stamp: rospy.Time) -> bool:
        """Take in the next message's stamp. Warn and return True if it is older than the last one's."""
        stamp_ns = stamp.to_nsec()
        back_ns = 0 if self._last_ns is None else self._last_ns - stamp_ns
        self._last_ns = stamp_ns
        if back_ns > 0:
            self._warnings.say(f"The clock jumped back by {back_ns * 1e-9:.3f} s; starting anew.")
        return back_ns > 0
