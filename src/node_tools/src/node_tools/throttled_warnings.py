"""Warnings with a limited rate, however often their cause occurs."""

from __future__ import annotations

import re
import time

import rospy

PERIOD_S = 5.0
"""Wall time between two warnings of one kind, because ROS time may jump to and fro."""
_NUMBERS = re.compile(r"\d+")


class ThrottledWarnings:
    """Logs each fault once in `PERIOD_S`. Sentences that differ only in numbers are one fault."""

    def __init__(self) -> None:
        self._said_at_s: dict[str, float] = {}

    def say(self, sentence: object) -> None:
        """Log the sentence as a warning, unless the same fault was logged in the last `PERIOD_S`."""
        kind = _NUMBERS.sub("", str(sentence))
        now_s = time.monotonic()
        said_at_s = self._said_at_s.get(kind)
        if said_at_s is None or now_s - said_at_s >= PERIOD_S:
            self._said_at_s[kind] = now_s
            rospy.logwarn("%s", sentence)
