"""Lockstep's barrier: what a simulator waits for after a scan."""

from __future__ import annotations

import threading


class Barrier:
    """What a lockstep simulator waits for at a scan instant: setpoint and acknowledgements of its stamp.

    Stamps are compared for equality: late words about an earlier scan, or from before a reset, open nothing.
    """

    def __init__(self, participants: frozenset[str]):
        self._participants = participants
        self._acknowledged_ms: dict[str, int] = {}
        self._changed = threading.Condition()
        self._stamp_ms = -1
        self.has_setpoint = False

    def raise_for(self, stamp_ms: int) -> None:
        """Wait for this scan from now on."""
        self._stamp_ms = stamp_ms
        self.has_setpoint = False

    def on_setpoint(self, stamp_ms: int) -> None:
        """Take the stamp of a setpoint that arrived."""
        self.has_setpoint = self.has_setpoint or stamp_ms == self._stamp_ms

    def acknowledge(self, participant: str, stamp_ms: int) -> None:
        """Take a participant's acknowledgement; from any thread."""
        with self._changed:
            self._acknowledged_ms[participant] = stamp_ms
            self._changed.notify()

    def missing(self) -> list[str]:
        """Return what has not come yet, in words."""
        missing = [] if self.has_setpoint else ["a setpoint"]
        with self._changed:
            return missing + [f"an acknowledgement on {name}" for name in sorted(self._silent())]

    def wait_for_participants(self, timeout_s: float) -> bool:
        """Sleep until every participant has acknowledged the stamp (True) or the time is over."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._silent(), timeout_s)

    def _silent(self) -> set[str]:
        return {name for name in self._participants if self._acknowledged_ms.get(name) != self._stamp_ms}
