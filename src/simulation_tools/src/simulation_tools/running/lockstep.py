"""Lockstep: after a scan, simulated time waits for the other nodes' answers to it."""

from __future__ import annotations

import threading
from typing import Callable, Protocol

from simulation_tools.running.pacing import WallClock

KEEP_ALIVE_S = 1.0
"""While lockstep waits, the flight controller tells this often that it is there."""

LOOK_PERIOD_S = 0.02
"""While lockstep waits, it looks this often for requests, a pause and the end."""

START_RETRY_S = 0.2
"""The first scan is repeated at this period until the nodes that answer it have started."""

START_PATIENCE_S = 15.0
"""If the first scan has no answer after this time, a warning says what is missing."""


def working_topic(participant: str) -> str:
    """Return the topic by which a participant says that it works.

    participant: the topic of its acknowledgements.
    """
    return f"{participant.rsplit('/', 1)[0]}/working"


class Barrier:
    """What lockstep waits for after a scan: a setpoint and acknowledgements with the scan's stamp.

    Stamps must be equal. A late answer to an earlier scan, or one from before a reset, does not count.
    pose_sender: the participant that says whether it has sent an external pose for the scan; empty: none.
    Such a pose is waited for, too.
    """

    def __init__(self, participants: frozenset[str], pose_sender: str = "") -> None:
        self._participants = participants | {pose_sender} - {""}
        self._pose_sender = pose_sender
        self._pose_under_way = self._has_pose = False
        self._acknowledged_ms: dict[str, int] = {}
        self._beat_s: dict[str, float] = {}
        self._changed = threading.Condition()
        self._stamp_ms = -1
        self.has_setpoint = False

    def raise_for(self, stamp_ms: int) -> None:
        """Wait for the answers to this scan from now on."""
        self._stamp_ms = stamp_ms
        self.has_setpoint = self._has_pose = False

    def on_setpoint(self, stamp_ms: int) -> None:
        """Take the stamp of a setpoint that arrived."""
        self.has_setpoint = self.has_setpoint or stamp_ms == self._stamp_ms

    def on_pose(self, stamp_ms: int) -> None:
        """Take the stamp of an external pose that arrived."""
        self._has_pose = self._has_pose or stamp_ms == self._stamp_ms

    def acknowledge(self, participant: str, stamp_ms: int, sent_pose: bool = False) -> None:
        """Take a participant's acknowledgement; from any thread. sent_pose: by the sender of poses."""
        with self._changed:
            self._acknowledged_ms[participant] = stamp_ms
            if participant == self._pose_sender:
                self._pose_under_way = sent_pose
            self._changed.notify()

    def beat(self, participant: str, now_s: float) -> None:
        """Note, from any thread, that a participant works at a wall time."""
        with self._changed:
            self._beat_s[participant] = now_s

    def works_until_s(self, timeout_s: float) -> float:
        """Return the wall time until which all that are waited for say that they work; -inf: one is silent.

        timeout_s: one that has not said so for so long works no more.
        """
        with self._changed:
            beats_s = [self._beat_s.get(name, float("-inf")) for name in self._silent()]
        return min(beats_s, default=float("-inf")) + timeout_s

    @property
    def last_beat_s(self) -> float:
        """Wall time at which any participant said last that it works; -inf: none has."""
        with self._changed:
            return max(self._beat_s.values(), default=float("-inf"))

    @property
    def lacks_pose(self) -> bool:
        """Whether an external pose for the scan is under way. Ask when all participants have acknowledged."""
        return self._pose_under_way and not self._has_pose

    def missing(self) -> str:
        """Return what has not come yet, in words."""
        missing = [] if self.has_setpoint else ["a setpoint"]
        with self._changed:
            silent = sorted(self._silent())
        missing += [f"an acknowledgement on {name}" for name in silent]
        if not silent and self.lacks_pose:
            missing.append("the external pose")
        return " and ".join(missing)

    def wait_for_participants(self, timeout_s: float) -> bool:
        """Sleep until every participant has acknowledged the stamp (True) or the time is over."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._silent(), timeout_s)

    def _silent(self) -> set[str]:
        return {name for name in self._participants if self._acknowledged_ms.get(name) != self._stamp_ms}


class SetpointInput(Protocol):
    """Where setpoints come from: the MAVLink link."""

    def wait(self, timeout_s: float) -> bool:
        """Sleep until input is there (True) or the time is over."""

    def poll(self, time_us: int, until: Callable[[], bool] = ...) -> None:
        """Handle all input that has arrived. Stop early if `until` returns True after a datagram."""

    def take_orders(self, time_us: int) -> None:
        """Carry out orders (modes, commands) that have arrived. All other input waits for the next poll."""

    def keep_alive(self) -> None:
        """Tell the other side that nothing has happened to this one, though time stands still."""


class Lockstep:
    """Waits for the answers to a scan.

    attend: called repeatedly during the wait; returns whether the simulation is paused. A pause does not
    count as waiting time. is_interrupted: whether to stop waiting at once (after a reset, or at the end).
    say: takes a sentence when it waits for what works, beyond the time-out; once for each scan.
    """

    def __init__(
        self,
        barrier: Barrier,
        link: SetpointInput,
        clock: WallClock,
        attend: Callable[[], bool],
        is_interrupted: Callable[[], bool],
        say: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self.barrier = barrier
        self._say, self._has_said = say, False
        self._alive_s = float("-inf")
        self._link = link
        self._clock = clock
        self._attend = attend
        self._is_interrupted = is_interrupted

    def wait(self, time_us: int, timeout_s: float) -> bool:
        """Wait for the answers to the scan of time_us. Return False after a time-out or an interruption.

        MAVLink input is applied up to the setpoint and the external pose of the scan, and no further. But
        what a participant orders before it acknowledges takes effect at this scan, though its order may
        arrive before or after the setpoint. A participant that says that it works is waited for.
        """
        barrier = self.barrier
        barrier.raise_for(time_us // 1000)
        self._has_said, self._alive_s = False, self._clock.now()
        self._deadline_s = self._alive_s + timeout_s
        if not self._read_until(lambda: barrier.has_setpoint, time_us, timeout_s):
            return False
        while not barrier.wait_for_participants(LOOK_PERIOD_S):
            if self._is_late(timeout_s) and not self._is_at_work(timeout_s):
                return False
        if self._has_said:  # the others had to wait, too
            self._deadline_s = self._clock.now() + timeout_s
        if not self._read_until(lambda: not barrier.lacks_pose, time_us, timeout_s):
            return False
        self._link.take_orders(time_us)
        return True

    def _is_at_work(self, timeout_s: float) -> bool:
        """Return whether all participants that are late say that they work."""
        if self._is_interrupted() or self.barrier.works_until_s(timeout_s) < self._clock.now():
            return False
        if not self._has_said:
            self._has_said = True
            self._say(
                f"Lockstep waits for {self.barrier.missing()}: it works, for more than {timeout_s:g} s."
            )
        return True

    def _read_until(self, is_there: Callable[[], bool], time_us: int, timeout_s: float) -> bool:
        while not is_there():
            if self._link.wait(LOOK_PERIOD_S):
                self._link.poll(time_us, is_there)
            if not is_there() and self._is_late(timeout_s) and not self._is_anybody_at_work(timeout_s):
                return False
        return True

    def _is_anybody_at_work(self, timeout_s: float) -> bool:
        """Return whether a participant works: it takes the CPU time that a setpoint needs, too."""
        return not self._is_interrupted() and self.barrier.last_beat_s + timeout_s >= self._clock.now()

    def _is_late(self, timeout_s: float) -> bool:
        now_s = self._clock.now()
        if now_s >= self._alive_s + KEEP_ALIVE_S:
            self._alive_s = now_s
            self._link.keep_alive()
        if self._attend():
            self._deadline_s = self._clock.now() + timeout_s
        return self._clock.now() > self._deadline_s or self._is_interrupted()

    def wait_for_first(
        self, time_us: int, publish_again: Callable[[], None], warn: Callable[[str], None]
    ) -> None:
        """Publish the first scan repeatedly until it is answered.

        The nodes that answer it may still be starting.
        """
        warn_s = self._clock.now() + START_PATIENCE_S
        while not (self.wait(time_us, START_RETRY_S) or self._is_interrupted()):
            publish_again()
            if self._clock.now() > warn_s:
                warn_s = float("inf")
                warn(
                    f"Lockstep: time does not begin before {self.barrier.missing()} for the first scan. "
                    "Start the nodes that answer scans, or fly without lockstep."
                )
