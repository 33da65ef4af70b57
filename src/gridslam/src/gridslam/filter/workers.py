"""Threads that share the particles among them."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, NamedTuple

LOOK_EVERY_S = 0.5
"""Time between two measurements of the machine's load."""


class Workers:
    """Runs kernels that release the GIL over ranges of particles, in one thread or several.

    Each particle is computed alone, from numbers drawn beforehand. So the result does not depend on the
    number of threads.

    Args:
        threads: their number; 0: as many as cores are free.
        free_cores: returns the number of free cores.
    """

    def __init__(self, threads: int, free_cores: Callable[[], int] | None = None):
        self._count = (lambda: threads) if threads else free_cores or FreeCores().count
        self._threads_max = threads or cores()
        self._pool: ThreadPoolExecutor | None = None

    def share(self, particles: int, kernel: Callable, *arguments: Any) -> None:
        """Call kernel(first, last, *arguments) for ranges that together hold all particles; wait for all."""
        threads = min(self._count(), self._threads_max, particles)
        if threads <= 1:
            kernel(0, particles, *arguments)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads_max)
        bounds = [particles * part // threads for part in range(threads + 1)]
        jobs = [self._pool.submit(kernel, first, last, *arguments) for first, last in zip(bounds, bounds[1:])]
        for job in jobs:
            job.result()


class Usage(NamedTuple):
    """Seconds since some moment in the past."""

    wall_s: float
    idle_s: float
    """Of all cores together."""
    own_s: float
    """CPU time of this process."""


class FreeCores:
    """Number of cores that this process could use: idle ones, and those that it uses already.

    Args:
        read: returns the machine's present usage; None if the system does not report it.
    """

    def __init__(self, read: Callable[[], Usage | None] | None = None):
        self._read = usage if read is None else read
        self._last = self._read()
        self._free = 1

    def count(self) -> int:
        """Return the number over the last moments; at least one."""
        last, now = self._last, None if self._last is None else self._read()
        if last is None or now is None:
            return self._free
        past_s = now.wall_s - last.wall_s
        if past_s >= LOOK_EVERY_S:
            busy_or_idle_s = now.idle_s - last.idle_s + now.own_s - last.own_s
            self._free = max(1, round(busy_or_idle_s / past_s))
            self._last = now
        return self._free


def usage() -> Usage | None:
    """Return the usage of machine and process from Linux; None if there is none."""
    try:
        with open("/proc/stat") as lines:
            words = lines.readline().split()
        idle_ticks = int(words[4]) + int(words[5])  # idle, and waiting for a disk
    except (OSError, ValueError, IndexError):  # some sandboxes have an empty one
        return None
    return Usage(time.monotonic(), idle_ticks / os.sysconf("SC_CLK_TCK"), time.process_time())


def cores() -> int:
    """Return how many cores this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
