"""How fast a flight was simulated, by three clocks. Peers use it, too, so it imports nothing of ours."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import Callable, Iterable


@dataclass(frozen=True)
class Speed:
    """The simulated time of a flight, and what it took: CPU time of the thread and the process, wall time."""

    simulated_s: float
    thread_s: float
    process_s: float
    wall_s: float

    @property
    def rtf(self) -> float:
        """Real-time factor by the CPU time of the thread that flies."""
        return self.simulated_s / self.thread_s

    @property
    def rtf_process(self) -> float:
        """Real-time factor by the CPU time of all threads of the process."""
        return self.simulated_s / self.process_s

    @property
    def rtf_wall(self) -> float:
        """Real-time factor by the wall."""
        return self.simulated_s / self.wall_s


def timed(fly: Callable[[], float]) -> Speed:
    """Measure `fly`, which returns the simulated time in s."""
    thread_s, process_s, wall_s = time.thread_time(), time.process_time(), time.perf_counter()
    simulated_s = fly()
    return Speed(
        simulated_s,
        time.thread_time() - thread_s,
        time.process_time() - process_s,
        time.perf_counter() - wall_s,
    )


def medians(speeds: Iterable[Speed]) -> dict[str, float]:
    """Return the medians of the real-time factors: rtf, rtf_process, rtf_wall."""
    flown = list(speeds)
    return {
        name: statistics.median(getattr(speed, name) for speed in flown)
        for name in ("rtf", "rtf_process", "rtf_wall")
    }
