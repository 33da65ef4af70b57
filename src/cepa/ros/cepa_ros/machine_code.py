"""Has numba compile the kernels of an algorithm before it steers."""

from __future__ import annotations

import gc
import subprocess
import sys
from typing import Callable

from cepa.warm_up import warm_up, warm_up_dynamic
from node_tools.compiling import run_compiled

IN_FLIGHT = ("nice", sys.executable, "-c", "from cepa.warm_up import {0}; {0}()")
"""Compiles in another process, because numba would hold up the node's answers. numba keeps the result."""


class MachineCode:
    """Knows which algorithms can answer without waiting for a compiler. say: is told the progress."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._there: set[Callable[[], float]] = set()

    def get(self, algorithm: str) -> None:
        """Compile what the algorithm needs, or load what numba has kept."""
        needed = self._needed_by(algorithm)
        if needed not in self._there:
            run_compiled(self._say, needed)
            self._there.add(needed)

    def get_in_flight(self, algorithm: str) -> None:
        """Do the same while another algorithm steers."""
        needed = self._needed_by(algorithm)
        if needed in self._there:
            return
        self._say(f"Getting the machine code of {algorithm}; until then the present algorithm steers.")
        command = [word.format(needed.__name__) for word in IN_FLIGHT]
        subprocess.run(command, check=False)  # if that fails, numba says why below
        self.get(algorithm)
        gc.freeze()

    def _needed_by(self, algorithm: str) -> Callable[[], float]:
        return warm_up_dynamic if algorithm == "dynamic" else warm_up
