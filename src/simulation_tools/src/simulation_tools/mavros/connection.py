"""Tells by heartbeats, in the flight controller's own time, whether it is connected."""

from __future__ import annotations

import math
import time
from typing import Callable

from pymavlink.dialects.v20 import common

_JUMP_BACK_MS = 1000
"""A clock that goes back by more than this was reset. By less, it is a late message."""


class Connection:
    """Measures the time since the last heartbeat, in the flight controller's time.

    A slow simulation sends its heartbeats less often than once a second of wall time. Without any message
    the flight controller's time is unknown, so the wall clock counts.
    """

    def __init__(self, timeout_s: float, wall_clock: Callable[[], float] = time.monotonic) -> None:
        """timeout_s: time without heartbeats after which the connection is lost."""
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
