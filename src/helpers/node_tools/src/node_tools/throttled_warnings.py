"""Warnings with a limited rate, however often their cause occurs."""

from __future__ import annotations

import re
import time

import rospy

PERIOD_S = 5.0
"""Wall time between two warnings of one kind, because ROS time may jump to and fro."""
PATIENCE_S = 1.0
"""ROS time for which others may mend a fault before it is told, as at a start."""
_NUMBERS = re.compile(r"\d+(\.\d+)?")


class ThrottledWarnings:
    """Logs each fault once in `PERIOD_S`. Sentences that differ only in numbers are one fault."""

    def __init__(self) -> None:
        self._said_at_s: dict[str, float] = {}
        self._lasts: dict[str, tuple[float, float]] = {}  # first and last time of each fault

    def say(self, sentence: object) -> None:
        """Log the sentence as a warning, unless the same fault was logged in the last `PERIOD_S`."""
        kind = _NUMBERS.sub("", str(sentence))
        now_s = time.monotonic()
        said_at_s = self._said_at_s.get(kind)
        if said_at_s is None or now_s - said_at_s >= PERIOD_S:
            self._said_at_s[kind] = now_s
            rospy.logwarn("%s", sentence)

    def say_if_it_lasts(self, sentence: object) -> None:
        """Say the sentence only if the same fault has come again and again for `PATIENCE_S`."""
        kind = _NUMBERS.sub("", str(sentence))
        now_s = rospy.get_time()
        first_s, last_s = self._lasts.get(kind, (now_s, now_s))
        if not 0.0 <= now_s - last_s <= PATIENCE_S:
            first_s = now_s
        self._lasts[kind] = first_s, now_s
        if now_s - first_s >= PATIENCE_S:
            self.say(sentence)
