"""When an errand acknowledges a scan. In lockstep the simulator waits for that."""

from __future__ import annotations

import math
from typing import Any, Callable, Protocol

from flight_basics.errand.messages import Heard, Pose, Scan, Steered

MAP_LATE_S = 1.6
"""A scan is acknowledged when the map is at most so much older."""
STARVED_S = 3.0
"""Wall time after which nobody waits for a map that does not come."""

BarrierMessage = Pose | Scan | Steered | Heard


class Barrier(Protocol):
    """Decides which pose is followed when, and which scan is acknowledged when."""

    def take(self, message: BarrierMessage, is_active: bool) -> Pose | None:
        """Take a message. Return the pose to follow now; None: none. is_active: something is flown."""

    def note_followed(self, is_new_setpoint: bool) -> None:
        """The pose is followed. is_new_setpoint: it has led to another setpoint."""

    def note_map(self, stamp_s: float) -> None:
        """Take the time of the newest map, by the clock of the scans."""

    def passed(self, is_active: bool, is_busy: bool) -> Any | None:
        """Return the header of the scan to acknowledge now, once. is_busy: something is to be decided."""


class NoBarrier:
    """Nobody waits: each pose is followed when it comes."""

    def take(self, message: BarrierMessage, is_active: bool) -> Pose | None:
        """Return each pose."""
        return message if isinstance(message, Pose) else None

    def note_followed(self, is_new_setpoint: bool) -> None:
        """Nobody asks."""

    def note_map(self, stamp_s: float) -> None:
        """Nobody asks."""

    def passed(self, is_active: bool, is_busy: bool) -> None:
        """Nothing is acknowledged."""


class MapBarrier:
    """A scan is acknowledged when nothing is to be decided, and pose and map are as new as the scan.

    now_s: tells the wall time.
    """

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self._scan: Scan | None = None
        self._came_s = self._pose_s = self._map_s = -math.inf

    def take(self, message: BarrierMessage, is_active: bool) -> Pose | None:
        """Return each pose."""
        if isinstance(message, Scan):
            self._scan, self._came_s = message, self._now_s()
        elif isinstance(message, Pose) and message.place_m is not None:
            self._pose_s = message.stamp_s
            return message
        return None

    def note_followed(self, is_new_setpoint: bool) -> None:
        """A setpoint is not waited for."""

    def note_map(self, stamp_s: float) -> None:
        """Take the time of the newest map."""
        self._map_s = stamp_s

    def passed(self, is_active: bool, is_busy: bool) -> Any | None:
        """Return the header of the scan to acknowledge now, once."""
        scan = self._scan
        if scan is None or is_busy:
            return None
        if is_active:
            is_map_late = scan.stamp_s - self._map_s > MAP_LATE_S
            if self._pose_s < scan.stamp_s - 1e-6:
                return None
            if is_map_late and self._now_s() - self._came_s < STARVED_S:
                return None
        self._scan = None
        return scan.header

    @property
    def waits(self) -> bool:
        """Whether a scan is not acknowledged yet."""
        return self._scan is not None


class SteeringBarrier:
    """A pose is followed only at the instant of a scan, when the position controller has answered it.

    If that leads to a new setpoint, the scan is acknowledged when the position controller has heard it. So
    the outcome does not depend on the speed of messages.
    """

    def __init__(self) -> None:
        self._scan: Scan | None = None
        self._pose: Pose | None = None
        self._steered_s: float | None = None
        self._is_decided = self._is_unheard = False

    def take(self, message: BarrierMessage, is_active: bool) -> Pose | None:
        """Return the pose of the scan's instant, once, when it is answered."""
        if isinstance(message, Scan):
            self._scan, self._is_decided, self._is_unheard = message, False, False
        elif isinstance(message, Pose):
            self._pose = message
        elif isinstance(message, Steered):
            self._steered_s = message.stamp_s
        else:
            self._is_unheard = False
        scan, pose = self._scan, self._pose
        if not is_active or scan is None or pose is None or self._is_decided:
            return None
        return pose if scan.stamp_s == pose.stamp_s == self._steered_s else None

    def note_followed(self, is_new_setpoint: bool) -> None:
        """Wait for the setpoint, if there is a new one."""
        self._is_decided, self._is_unheard, self._steered_s = True, is_new_setpoint, None

    def note_map(self, stamp_s: float) -> None:
        """No map is waited for."""

    def passed(self, is_active: bool, is_busy: bool) -> Any | None:
        """Return the header of the scan to acknowledge now, once."""
        scan = self._scan
        if scan is None or is_busy or (is_active and not self._is_decided) or self._is_unheard:
            return None
        self._scan = None
        return scan.header
