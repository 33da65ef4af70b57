"""Whether the flight controller is there, told by its heartbeats and its own clock."""

from __future__ import annotations

import math
import time
from typing import Callable

from pymavlink.dialects.v20 import common

_JUMP_BACK_MS = 1000
"""A clock that is so much earlier has been set back; less is a message that was late."""


class Connection:
    """Counts how long no heartbeat has come, in the flight controller's time.

    A slow simulation sends everything, its heartbeat too, less often than once a second of wall time. When no
    message comes at all, the flight controller's time is unknown: then the wall clock counts.
    """

    def __init__(self, timeout_s: float, wall_clock: Callable[[], float] = time.monotonic) -> None:
        """timeout_s: how long a connection lasts without heartbeats."""
        self._timeout_s = timeout_s
        self._wall_clock = wall_clock
        self._heard_s = -math.inf  # wall time
        self._time_boot_ms = 0
        self._heartbeat_ms: int | None = None  # time_boot_ms

    def on_message(self, message: common.MAVLink_message) -> None:
        """Take note of any message from the flight controller."""
        self._heard_s = self._wall_clock()
        if message.get_type() == "HEARTBEAT":
            self._heartbeat_ms = self._time_boot_ms
            return
        time_boot_ms = getattr(message, "time_boot_ms", self._time_boot_ms)
        if time_boot_ms < self._time_boot_ms - _JUMP_BACK_MS:
            self._time_boot_ms = time_boot_ms
            self._heartbeat_ms = time_boot_ms if self._heartbeat_ms is not None else None
        self._time_boot_ms = max(self._time_boot_ms, time_boot_ms)

    @property
    def alive(self) -> bool:
        """Whether heartbeats arrive."""
        if self._heartbeat_ms is None:
            return False
        without_heartbeat_s = 1e-3 * (self._time_boot_ms - self._heartbeat_ms)
        silent_s = self._wall_clock() - self._heard_s
        return max(without_heartbeat_s, silent_s) < self._timeout_s
