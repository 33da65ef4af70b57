"""Measurements that wait until the filter's horizon has reached their time."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

Measurement = TypeVar("Measurement")

PATIENCE_US = 100_000
"""A measurement older than the horizon by more than this is dropped, as in PX4."""


class DelayBuffer(Generic[Measurement]):
    """A short queue of measurements with their times, in us of the autopilot's clock.

    newest_us: of the last accepted one. least_interval_us: a measurement that follows sooner is dropped, so
    that a fast source does not push others out.
    """

    def __init__(self, length: int, least_interval_us: int = 0) -> None:
        self._least_interval_us = least_interval_us
        self._waiting: deque[tuple[int, Measurement]] = deque(maxlen=length)
        self.newest_us: int | None = None

    def clear(self) -> None:
        """Forget everything."""
        self._waiting.clear()
        self.newest_us = None

    def push(self, time_us: int, measurement: Measurement) -> bool:
        """Store a measurement; the oldest one makes room. Return whether it was stored.

        A time before that of the last measurement counts as a new start of the source's clock.
        """
        if self.newest_us is not None and 0 <= time_us - self.newest_us < self._least_interval_us:
            return False
        self.newest_us = time_us
        self._waiting.append((time_us, measurement))
        return True

    def pop(self, horizon_us: int) -> Measurement | None:
        """Return the newest measurement that the horizon has reached, and forget the ones before it."""
        found = None
        for index, (time_us, measurement) in enumerate(self._waiting):
            if time_us <= horizon_us < time_us + PATIENCE_US:
                found = (index, measurement)
        if found is None:
            return None
        for _ in range(found[0] + 1):
            self._waiting.popleft()
        return found[1]
