"""The run loop's link where the flight controller brings its own MAVLink links."""

from __future__ import annotations

import time
from typing import Callable


class OwnLinks:
    """A `run_loop.Link` that carries nothing: PX4 talks to MAVROS and ground stations by itself."""

    def __init__(self) -> None:
        self.on_setpoint: Callable[[int], None] = lambda time_boot_ms: None
        self.on_external_pose: Callable[[int], None] = lambda time_boot_ms: None

    def poll(self, time_us: int, until: Callable[[], bool] = lambda: False) -> None:
        """Do nothing: no input comes this way."""

    def send_due(self, time_us: int) -> None:
        """Do nothing: no output goes this way."""

    def flush(self) -> None:
        """Do nothing: nothing was kept."""

    def take_orders(self, time_us: int) -> None:
        """In lockstep alone somebody waits with orders."""

    def keep_alive(self) -> None:
        """Do nothing: there is no lockstep with it."""

    def reset(self) -> None:
        """Do nothing: no message was due."""

    def wait(self, timeout_s: float) -> bool:
        """Sleep until the time is over."""
        time.sleep(max(timeout_s, 0.0))
        return False
