"""Tells a clock that was set from time that has passed, by the stamps of one stream of messages.

Poses and scans come 10 to 50 times a second. So a long gap between two of them is no time that was flown: the
clock was set ahead, or nobody heard the messages between. In both cases what was timed goes on as if the gap
had not been.
"""

from __future__ import annotations

import math

LONGEST_GAP_S = 2.0
"""A longer gap between two messages of a stream does not count as time that passed."""
LONGEST_SPARSE_GAP_S = 15.0
"""The same of a stream of few messages, such as a battery's: PX4 tells it every 2 s, others seldom."""
BACK_S = 0.5
"""A message that is older by less came late, or the clock was trimmed: time stands still for a moment."""

STEP_PASSES_S = 0.02
"""Between two messages before and after a step, where several streams come."""


def clock_step_s(before_s: float, stamp_s: float) -> float:
    """Return by how much the clock was set between two messages in a row of these stamps; 0: time passed."""
    gap_s = stamp_s - before_s
    return gap_s if gap_s > LONGEST_GAP_S or gap_s < -BACK_S else 0.0


class SteadyTime:
    """A time that grows by what passes, however the clock of the stamps is set. It is for limits of time.

    A stream of many messages leads it: `at` takes each stamp of it. It begins with the first one's stamp.
    While that stream is silent, the others lead it: `passes` takes their stamps, each of any clock.

    Attributes:
        now_s: of the newest message; -inf: none has come. step_s: by how much the clock was set before the
        newest message; 0: it was not. silent_s: how much has passed since the leading stream's newest
        message; 0: it is not silent.
    """

    def __init__(self) -> None:
        self.now_s, self.step_s, self.silent_s = -math.inf, 0.0, 0.0
        self._stamp_s: float | None = None
        self._set_by_s = 0.0
        self._others: dict[str, tuple[float, float]] = {}
        """Newest stamp of each other stream, and what has passed by it since the leading stream's message."""

    def at(self, stamp_s: float) -> float:
        """Return the time of the stream's next message."""
        self.step_s = 0.0 if self._stamp_s is None else clock_step_s(self._stamp_s, stamp_s)
        if self.step_s and self.silent_s and self._stamp_s is not None:
            self.step_s = clock_step_s(self._stamp_s + self.silent_s, stamp_s)
        self._set_by_s += self.step_s
        if self.silent_s:  # time does not go back, nor stands still, because the others were ahead
            self._set_by_s = min(self._set_by_s, stamp_s - self.now_s)
        self._stamp_s, self.silent_s = stamp_s, 0.0
        self._others.clear()
        self.now_s = max(self.now_s, stamp_s - self._set_by_s)
        return self.now_s

    def passes(self, stream: str, stamp_s: float) -> None:
        """Take the stamp of a message of another stream, by its own clock."""
        before_s, passed_s = self._others.get(stream, (stamp_s, 0.0))
        gap_s = stamp_s - before_s
        passed_s += gap_s if 0.0 < gap_s <= LONGEST_SPARSE_GAP_S else 0.0
        self._others[stream] = stamp_s, passed_s
        if passed_s > max(self.silent_s, LONGEST_GAP_S):
            self.now_s += passed_s - self.silent_s
            self.silent_s = passed_s

    def of_other(self, stamp_s: float, late_s: float = LONGEST_GAP_S) -> float:
        """Return the time of a message of another stream that has just come.

        Its stamp may be of the clock before it was set, or after. So one that is farther than `late_s` from
        the newest message counts by its arrival.
        """
        time_s = stamp_s - self._set_by_s
        return time_s if abs(time_s - self.now_s) <= late_s else self.now_s


class SharedSteadyTime:
    """A steady time of several streams that have one clock, in whichever order their messages come.

    A clock that is set ahead is no time. One that is set back is left to the caller: his time goes back, too.

    Args:
        longest_gap_s: a longer gap between two messages, whatever their streams, is none that passed.
    """

    def __init__(self, longest_gap_s: float = LONGEST_GAP_S) -> None:
        self._longest_gap_s = longest_gap_s
        self._now_s: float | None = None
        self._set_by_s = self._before_s = 0.0

    def at(self, stamp_s: float) -> float:
        """Return the time of the next message of any stream."""
        time_s = stamp_s - self._set_by_s
        now_s = time_s if self._now_s is None else self._now_s
        gap_s, most_s = time_s - now_s, self._longest_gap_s
        if gap_s > most_s:
            self._before_s, self._set_by_s = self._set_by_s, stamp_s - now_s - STEP_PASSES_S
            time_s = now_s + STEP_PASSES_S
        elif gap_s < -most_s and abs(stamp_s - self._before_s - now_s) <= most_s:
            return stamp_s - self._before_s  # of the clock before it was set
        self._now_s = time_s if gap_s < -most_s else max(now_s, time_s)
        return time_s
