"""Reports the reason for waiting: when it changes, and again if it lasts long."""

from __future__ import annotations

from simulation_tools.publisher.interface import Action, AnnounceStatus, Log

_NS = 1e-9


class WaitingReason:
    """Remembers the reason for waiting, and since when it holds."""

    def __init__(self) -> None:
        self._reason: str | None = None
        self._since_ns = self._said_ns = 0

    def report(self, now_ns: int, doing: str, reason: str, period_s: float) -> list[Action]:
        """Return the actions at a time of ROS's clock.

        doing: the present phase, in words. reason: why it goes on; empty: the publisher does not wait.
        """
        if reason != self._reason or now_ns < self._said_ns:
            self._reason, self._since_ns, self._said_ns = reason, now_ns, now_ns
            return [AnnounceStatus(reason)]
        if not reason or (now_ns - self._said_ns) * _NS < period_s:
            return []
        self._said_ns = now_ns
        waited_s = (now_ns - self._since_ns) * _NS
        return [Log(f"still {doing} after {waited_s:.0f} s: {reason}.")]
