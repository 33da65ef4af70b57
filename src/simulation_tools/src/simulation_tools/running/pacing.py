"""How simulated time follows the wall clock."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Callable

from flight_basics.checks import check_limits, limited
from simulation_tools.running.requests import RunLoopError

FORGIVEN_LAG_S = 0.1
"""If the loop is further behind the wall clock than this, it does not try to catch up."""


@dataclass(frozen=True)
class WallClock:
    """How the loop reads the wall time (s), and how it sleeps. A test may bring another clock."""

    now: Callable[[], float] = time.perf_counter
    sleep: Callable[[float], None] = time.sleep


@dataclass(frozen=True)
class PacingParameters:
    """How simulated time follows the wall clock.

    Raises:
        RunLoopError: a value makes no sense.
    """

    real_time_factor: float = limited(1.0, 0.0)
    """Simulated seconds per wall second. 0: as fast as possible."""
    lockstep: bool = False
    """Wait after each scan for the setpoint made from it."""
    participants: frozenset[str] = frozenset()
    """Names of further acknowledgements to wait for."""
    pose_sender: str = ""
    """The participant that also says whether it has sent an external pose, see `Barrier`. Empty: none."""
    lockstep_timeout_s: float = limited(1.0, above=0.0)
    """Wall time to wait for the answers to a scan, s. After it the loop counts a miss and goes on."""

    def __post_init__(self) -> None:
        check_limits(self, RunLoopError)


class Pacer:
    """Knows when the next step is due, in wall time."""

    def __init__(self, clock: WallClock) -> None:
        self._clock = clock
        self._anchor = (0.0, 0)

    def restart(self, time_us: int) -> None:
        """Start again: simulated time `time_us` belongs to the present wall time."""
        self._anchor = (self._clock.now(), time_us)

    def due_s(self, time_us: int, real_time_factor: float) -> float:
        """Return the wall time at which simulated time may pass `time_us`; -inf: at once.

        If the loop is too late to catch up, counting starts again.
        """
        if real_time_factor == 0.0:
            return -math.inf
        wall_s, simulated_us = self._anchor
        due_s = wall_s + 1e-6 * (time_us - simulated_us) / real_time_factor
        if self._clock.now() - due_s > FORGIVEN_LAG_S:
            self.restart(time_us)
        return due_s
