"""The last things that came on a topic, by their stamps."""

from __future__ import annotations

from typing import Generic, TypeVar

from genpy import Time

LATE_NS = 1_000_000_000
"""A scan waits for what belongs to it until TF is newer by this much."""
Thing = TypeVar("Thing")


class ByStamp(Generic[Thing]):
    """Keeps so many of them; all are forgotten when the clock goes back."""

    def __init__(self, kept: int) -> None:
        self._kept = kept
        self._known: dict[int, Thing] = {}
        self._newest_ns = -1

    @property
    def has_come(self) -> bool:
        """Whether there was anything yet."""
        return self._newest_ns >= 0

    def put(self, stamp: Time, thing: Thing) -> None:
        """Keep the newest one."""
        stamp_ns = stamp.to_nsec()
        if stamp_ns < self._newest_ns:  # the clock went back
            self._known.clear()
        self._newest_ns = stamp_ns
        self._known[stamp_ns] = thing
        while len(self._known) > self._kept:
            del self._known[next(iter(self._known))]

    def know(self, stamp: Time, tf_ns: int | None) -> bool:
        """Whether the topic has reached a scan's stamp, or TF is so much newer that it will not."""
        is_late = tf_ns is not None and tf_ns - stamp.to_nsec() > LATE_NS
        return is_late or self._newest_ns >= stamp.to_nsec()

    def get(self, stamp: Time) -> Thing | None:
        """Return what came with a scan's stamp; None: nothing did."""
        return self._known.get(stamp.to_nsec())
