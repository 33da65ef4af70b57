"""Threads that share the particles among them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Callable


class Workers:
    """Runs kernels that release the GIL over ranges of particles, in one thread or several.

    Each particle is computed alone, from numbers drawn beforehand, so that the result does not depend on the
    number of threads.
    """

    def __init__(self, threads: int):
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def share(self, particles: int, kernel: Callable, *arguments) -> None:
        """Call kernel(first, last, *arguments) for ranges that make up all particles; wait for all."""
        if self._pool is None:
            kernel(0, particles, *arguments)
            return
        bounds = [particles * part // self.threads for part in range(self.threads + 1)]
        jobs = [self._pool.submit(kernel, first, last, *arguments) for first, last in zip(bounds, bounds[1:])]
        for job in jobs:
            job.result()
