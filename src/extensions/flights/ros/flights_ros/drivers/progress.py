"""Logs the progress of the work after a flight."""

from __future__ import annotations

import time

import rospy

PERIOD_S = 5.0
"""Wall time, because simulated time passes slowly after the flight."""


class ProgressLog:
    """Logs at how many poses the clearance is measured."""

    def __init__(self) -> None:
        self._due_s = 0.0

    def __call__(self, done: int, of: int) -> None:
        """Log, if the last time was a while ago."""
        now_s = time.monotonic()
        if now_s >= self._due_s:
            self._due_s = now_s + PERIOD_S
            rospy.loginfo(f"Measuring the clearance: {done} of {of}.")
